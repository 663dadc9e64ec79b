#include "server/handlers/list_care.h"

#include "proto/convert/history.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListCareResponse> ListCare(Core& core, const Call& call, const v1::ListCareRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::MachineCare> rows, core.database.ListCare(page, call.visible));
  v1::ListCareResponse response;
  for (const records::MachineCare& row : rows.rows) *response.add_machines() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
