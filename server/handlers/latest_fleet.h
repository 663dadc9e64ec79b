// History.LatestFleet: the newest identified errors of a page of machines.
#ifndef AXISCAL_SERVER_HANDLERS_LATEST_FLEET_H_
#define AXISCAL_SERVER_HANDLERS_LATEST_FLEET_H_

#include "axiscal/v1/history_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::LatestFleetResponse> LatestFleet(Core& core, const Call& call,
                                                    const v1::LatestFleetRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LATEST_FLEET_H_
