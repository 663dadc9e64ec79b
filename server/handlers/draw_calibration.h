// Calibrations.DrawCalibration: residuals of its sessions and ball-bar traces as pictures.
#ifndef AXISCAL_SERVER_HANDLERS_DRAW_CALIBRATION_H_
#define AXISCAL_SERVER_HANDLERS_DRAW_CALIBRATION_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::DrawCalibrationResponse> DrawCalibration(Core& core, const Call& call,
                                                            const v1::DrawCalibrationRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_DRAW_CALIBRATION_H_
