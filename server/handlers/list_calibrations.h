// Calibrations.ListCalibrations: a page, newest first, without JSON texts.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_CALIBRATIONS_H_
#define AXISCAL_SERVER_HANDLERS_LIST_CALIBRATIONS_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListCalibrationsResponse> ListCalibrations(Core& core, const Call& call,
                                                              const v1::ListCalibrationsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_CALIBRATIONS_H_
