// Calibrations.ListResiduals: every reading of a calibration's sessions with what its errors leave of it.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_RESIDUALS_H_
#define AXISCAL_SERVER_HANDLERS_LIST_RESIDUALS_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// As CalibrationFits::Of; NOT_FOUND SESSION_NOT_FOUND where the calibration does not stand on the session that is asked
// for; PAGE_INVALID.
absl::StatusOr<v1::ListResidualsResponse> ListResiduals(Core& core, const Call& call,
                                                        const v1::ListResidualsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_RESIDUALS_H_
