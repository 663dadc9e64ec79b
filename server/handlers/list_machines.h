// Machines.ListMachines: a page, in the order of machine_id.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_MACHINES_H_
#define AXISCAL_SERVER_HANDLERS_LIST_MACHINES_H_

#include "axiscal/v1/machines_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListMachinesResponse> ListMachines(Core& core, const Call& call,
                                                      const v1::ListMachinesRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_MACHINES_H_
