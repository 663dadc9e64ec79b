#include "server/handlers/list_sessions.h"

#include "proto/convert/session.h"
#include "proto/convert/time.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListSessionsResponse> ListSessions(Core& core, const Call& call,
                                                      const v1::ListSessionsRequest& request) {
  storage::SessionFilter filter;
  if (!request.machine_id().empty()) filter.machine = MachineId(request.machine_id());
  if (request.state() != v1::SESSION_STATE_UNSPECIFIED) {
    ASSIGN_OR_RETURN(filter.state, convert::FromProto(request.state()));
  }
  filter.measured = {OPTIONAL_UTC(request, from_utc_us), OPTIONAL_UTC(request, to_utc_us)};
  RETURN_IF_ERROR(RequireSpan(filter.measured));
  filter.instrument = request.instrument();
  filter.name = request.name();
  filter.label = request.label();
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::SessionRecord> rows,
                   FirstWithRows(call, page, [&](const records::PageRequest& part) {
                     return core.database.ListSessions(filter, part, call.visible);
                   }));
  v1::ListSessionsResponse response;
  for (const records::SessionRecord& row : rows.rows) *response.add_sessions() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
