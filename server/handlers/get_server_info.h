// Admin.GetServerInfo: versions, limits and load.
#ifndef AXISCAL_SERVER_HANDLERS_GET_SERVER_INFO_H_
#define AXISCAL_SERVER_HANDLERS_GET_SERVER_INFO_H_

#include "axiscal/v1/admin_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// As the server is built (server.cc).
inline constexpr int kMaxMessageBytes = 4 << 20;

absl::StatusOr<v1::GetServerInfoResponse> GetServerInfo(Core& core, const Call& call,
                                                        const v1::GetServerInfoRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_GET_SERVER_INFO_H_
