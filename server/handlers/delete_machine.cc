#include "server/handlers/delete_machine.h"

#include "proto/convert/field.h"
#include "proto/convert/machine.h"

namespace axiscal::handlers {

absl::StatusOr<v1::DeleteMachineResponse> DeleteMachine(Core& core, const Call& call,
                                                        const v1::DeleteMachineRequest& request) {
  RETURN_IF_ERROR(convert::RequirePositive("etag", request.etag()));
  ASSIGN_OR_RETURN(const records::MachineRecord record,
                   core.database.DeleteMachine(MachineId(request.machine_id()), request.etag(), call.By()));
  v1::DeleteMachineResponse response;
  *response.mutable_machine() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
