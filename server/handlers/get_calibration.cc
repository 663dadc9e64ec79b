#include "server/handlers/get_calibration.h"

#include "proto/convert/calibration.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {
namespace {
constexpr int kMostDecisions = 20;  // as the proto says: what a page shows
}  // namespace

absl::StatusOr<v1::GetCalibrationResponse> GetCalibration(Core& core, const Call& call,
                                                          const v1::GetCalibrationRequest& request) {
  if (request.has_calibration_id() == !request.approved_of_machine_id().empty()) {
    return convert::FieldError("calibration_id",
                               "exactly one of calibration_id and approved_of_machine_id must be set");
  }
  ASSIGN_OR_RETURN(records::CalibrationRecord record,
                   request.has_calibration_id()
                       ? core.database.GetCalibration(CalibrationId(request.calibration_id()))
                       : core.database.GetApprovedCalibration(MachineId(request.approved_of_machine_id())));
  ASSIGN_OR_RETURN(record.decisions, core.database.ListDecisions(record.id, kMostDecisions));
  v1::GetCalibrationResponse response;
  *response.mutable_calibration() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
