// Calibrations.GetCalibration: one by its id, or the one in use on a machine.
#ifndef AXISCAL_SERVER_HANDLERS_GET_CALIBRATION_H_
#define AXISCAL_SERVER_HANDLERS_GET_CALIBRATION_H_

#include "axiscal/v1/calibrations_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetCalibrationResponse> GetCalibration(Core& core, const Call& call,
                                                          const v1::GetCalibrationRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_GET_CALIBRATION_H_
