// Machines.GetMachine: the present description, or an earlier revision.
#ifndef AXISCAL_SERVER_HANDLERS_GET_MACHINE_H_
#define AXISCAL_SERVER_HANDLERS_GET_MACHINE_H_

#include "axiscal/v1/machines_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetMachineResponse> GetMachine(Core& core, const Call& call, const v1::GetMachineRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_GET_MACHINE_H_
