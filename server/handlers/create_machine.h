// Machines.CreateMachine: a valid description becomes a machine.
#ifndef AXISCAL_SERVER_HANDLERS_CREATE_MACHINE_H_
#define AXISCAL_SERVER_HANDLERS_CREATE_MACHINE_H_

#include "axiscal/v1/machines_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CreateMachineResponse> CreateMachine(Core& core, const Call& call,
                                                        const v1::CreateMachineRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CREATE_MACHINE_H_
