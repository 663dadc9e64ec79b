#include "server/handlers/get_calibration.h"

#include "proto/convert/calibration.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetCalibrationResponse> GetCalibration(Core& core, const Call& call,
                                                          const v1::GetCalibrationRequest& request) {
  if (request.has_calibration_id() == !request.approved_of_machine_id().empty()) {
    return convert::FieldError("calibration_id",
                               "exactly one of calibration_id and approved_of_machine_id must be set");
  }
  ASSIGN_OR_RETURN(const records::CalibrationRecord record,
                   request.has_calibration_id()
                       ? core.database.GetCalibration(CalibrationId(request.calibration_id()))
                       : core.database.GetApprovedCalibration(MachineId(request.approved_of_machine_id())));
  v1::GetCalibrationResponse response;
  *response.mutable_calibration() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
