#include "server/handlers/latest_fleet.h"

#include "proto/convert/field.h"
#include "proto/convert/history.h"

namespace axiscal::handlers {

absl::StatusOr<v1::LatestFleetResponse> LatestFleet(Core& core, const Call& call,
                                                    const v1::LatestFleetRequest& request) {
  RETURN_IF_ERROR(convert::RequireAtMost("symbols", request.symbols_size(), convert::kMaxSymbols));
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::FleetRow> rows,
                   core.database.LatestFleet({request.symbols().begin(), request.symbols().end()}, page, call.visible));
  v1::LatestFleetResponse response;
  for (const records::FleetRow& row : rows.rows) *response.add_machines() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
