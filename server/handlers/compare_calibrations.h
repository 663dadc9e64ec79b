// Calibrations.CompareCalibrations: what one calibration says otherwise than another, and what that does at the tool
// point.
#ifndef AXISCAL_SERVER_HANDLERS_COMPARE_CALIBRATIONS_H_
#define AXISCAL_SERVER_HANDLERS_COMPARE_CALIBRATIONS_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CompareCalibrationsResponse> CompareCalibrations(Core& core, const Call& call,
                                                                    const v1::CompareCalibrationsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_COMPARE_CALIBRATIONS_H_
