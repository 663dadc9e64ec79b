// Calibrations.RetireCalibration: takes a version out of use.
#ifndef AXISCAL_SERVER_HANDLERS_RETIRE_CALIBRATION_H_
#define AXISCAL_SERVER_HANDLERS_RETIRE_CALIBRATION_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::RetireCalibrationResponse> RetireCalibration(Core& core, const Call& call,
                                                                const v1::RetireCalibrationRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_RETIRE_CALIBRATION_H_
