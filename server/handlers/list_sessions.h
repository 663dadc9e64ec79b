// Ingest.ListSessions: a page, newest first.
#ifndef AXISCAL_SERVER_HANDLERS_LIST_SESSIONS_H_
#define AXISCAL_SERVER_HANDLERS_LIST_SESSIONS_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::ListSessionsResponse> ListSessions(Core& core, const Call& call,
                                                      const v1::ListSessionsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_LIST_SESSIONS_H_
