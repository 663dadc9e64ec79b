// Calibrations.ApproveCalibration: puts a version in use, or back in use.
#ifndef AXISCAL_SERVER_HANDLERS_APPROVE_CALIBRATION_H_
#define AXISCAL_SERVER_HANDLERS_APPROVE_CALIBRATION_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ApproveCalibrationResponse> ApproveCalibration(Core& core, const Call& call,
                                                                  const v1::ApproveCalibrationRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_APPROVE_CALIBRATION_H_
