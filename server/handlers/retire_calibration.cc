#include "server/handlers/retire_calibration.h"

#include "proto/convert/calibration.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {

absl::StatusOr<v1::RetireCalibrationResponse> RetireCalibration(Core& core, const Call& call,
                                                                const v1::RetireCalibrationRequest& request) {
  RETURN_IF_ERROR(convert::RequirePositive("etag", request.etag()));
  ASSIGN_OR_RETURN(const storage::Caller caller, ByWithReason(call, request.reason()));
  ASSIGN_OR_RETURN(const records::CalibrationRecord record,
                   core.database.RetireCalibration(CalibrationId(request.calibration_id()), request.etag(), caller));
  core.look_soon(record.content.machine);
  v1::RetireCalibrationResponse response;
  *response.mutable_calibration() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
