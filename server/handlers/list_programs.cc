#include "server/handlers/list_programs.h"

#include "proto/convert/program.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListProgramsResponse> ListPrograms(Core& core, const Call& call,
                                                      const v1::ListProgramsRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::ProgramRecord> rows,
                   core.database.ListPrograms({request.kind()}, page, call.visible));
  v1::ListProgramsResponse response;
  for (const records::ProgramRecord& row : rows.rows) {
    if (row.state == records::ProgramState::kComplete) *response.add_programs() = convert::ToProto(row);
  }
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
