// Machines.UpdateMachine: replaces the description that the caller edited.
#ifndef AXISCAL_SERVER_HANDLERS_UPDATE_MACHINE_H_
#define AXISCAL_SERVER_HANDLERS_UPDATE_MACHINE_H_

#include "axiscal/v1/machines_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::UpdateMachineResponse> UpdateMachine(Core& core, const Call& call,
                                                        const v1::UpdateMachineRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_UPDATE_MACHINE_H_
