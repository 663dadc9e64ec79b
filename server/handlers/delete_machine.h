// Machines.DeleteMachine: hides the machine, removes nothing.
#ifndef AXISCAL_SERVER_HANDLERS_DELETE_MACHINE_H_
#define AXISCAL_SERVER_HANDLERS_DELETE_MACHINE_H_

#include "axiscal/v1/machines_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::DeleteMachineResponse> DeleteMachine(Core& core, const Call& call,
                                                        const v1::DeleteMachineRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_DELETE_MACHINE_H_
