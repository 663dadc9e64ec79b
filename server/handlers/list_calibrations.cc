#include "server/handlers/list_calibrations.h"

#include "proto/convert/calibration.h"
#include "proto/convert/time.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListCalibrationsResponse> ListCalibrations(Core& core, const Call& call,
                                                              const v1::ListCalibrationsRequest& request) {
  records::CalibrationFilter filter;
  if (!request.machine_id().empty()) filter.machine = MachineId(request.machine_id());
  if (request.state() != v1::CALIBRATION_STATE_UNSPECIFIED) {
    ASSIGN_OR_RETURN(filter.state, convert::FromProto(request.state()));
  }
  filter.measured = {OPTIONAL_UTC(request, from_utc_us), OPTIONAL_UTC(request, to_utc_us)};
  RETURN_IF_ERROR(RequireSpan(filter.measured));
  if (request.has_session_id()) filter.session = SessionId(request.session_id());
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::CalibrationRecord> rows,
                   FirstWithRows(call, page, [&](const records::PageRequest& part) {
                     return core.database.ListCalibrations(filter, part, call.visible);
                   }));
  v1::ListCalibrationsResponse response;
  for (const records::CalibrationRecord& row : rows.rows) *response.add_calibrations() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
