#include "server/handlers/create_machine.h"

#include "proto/convert/machine.h"
#include "server/handlers/read_machine.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CreateMachineResponse> CreateMachine(Core& core, const Call& call,
                                                        const v1::CreateMachineRequest& request) {
  ASSIGN_OR_RETURN(const machine::Machine machine, ReadMachine(request.description_json()));
  ASSIGN_OR_RETURN(const records::MachineRecord record,
                   core.database.CreateMachine(MachineId(machine.id), request.description_json(), call.By()));
  v1::CreateMachineResponse response;
  *response.mutable_machine() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
