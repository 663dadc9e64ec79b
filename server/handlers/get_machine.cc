#include "server/handlers/get_machine.h"

#include "proto/convert/machine.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetMachineResponse> GetMachine(Core& core, const Call& call, const v1::GetMachineRequest& request) {
  const MachineId id(request.machine_id());
  ASSIGN_OR_RETURN(const records::MachineRecord record, request.has_revision()
                                                            ? core.database.GetMachineRevision(id, request.revision())
                                                            : core.database.GetMachine(id));
  v1::GetMachineResponse response;
  *response.mutable_machine() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
