#include "server/handlers/update_machine.h"

#include "proto/convert/field.h"
#include "proto/convert/machine.h"
#include "server/handlers/read_machine.h"

namespace axiscal::handlers {

absl::StatusOr<v1::UpdateMachineResponse> UpdateMachine(Core& core, const Call& call,
                                                        const v1::UpdateMachineRequest& request) {
  ASSIGN_OR_RETURN(const machine::Machine machine, ReadMachine(request.description_json()));
  RETURN_IF_ERROR(convert::RequirePositive("etag", request.etag()));
  ASSIGN_OR_RETURN(
      const records::MachineRecord record,
      core.database.UpdateMachine(MachineId(machine.id), request.etag(), request.description_json(), call.By()));
  v1::UpdateMachineResponse response;
  *response.mutable_machine() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
