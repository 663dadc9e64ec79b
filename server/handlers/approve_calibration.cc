#include "server/handlers/approve_calibration.h"

#include "proto/convert/calibration.h"
#include "proto/convert/field.h"
#include "server/inputs/calibration_use.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ApproveCalibrationResponse> ApproveCalibration(Core& core, const Call& call,
                                                                  const v1::ApproveCalibrationRequest& request) {
  RETURN_IF_ERROR(convert::RequirePositive("etag", request.etag()));
  ASSIGN_OR_RETURN(const storage::Caller caller, ByWithReason(call, request.reason()));
  ASSIGN_OR_RETURN(const records::CalibrationRecord present,
                   core.database.GetCalibration(CalibrationId(request.calibration_id())));
  if (present.state != records::CalibrationState::kApproved)
    RETURN_IF_ERROR(inputs::CheckUsable(core.database, present));
  ASSIGN_OR_RETURN(const records::CalibrationRecord record,
                   core.database.ApproveCalibration(CalibrationId(request.calibration_id()), request.etag(), caller));
  core.look_soon(record.content.machine);
  v1::ApproveCalibrationResponse response;
  *response.mutable_calibration() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
