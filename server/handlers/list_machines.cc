#include "server/handlers/list_machines.h"

#include "proto/convert/machine.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListMachinesResponse> ListMachines(Core& core, const Call& call,
                                                      const v1::ListMachinesRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::MachineRecord> rows, core.database.ListMachines(page, call.visible));
  v1::ListMachinesResponse response;
  for (const records::MachineRecord& row : rows.rows) *response.add_machines() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

}  // namespace axiscal::handlers
