// Ingest.GetSession: where a session stands, and its schema.
#ifndef AXISCAL_SERVER_HANDLERS_GET_SESSION_H_
#define AXISCAL_SERVER_HANDLERS_GET_SESSION_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetSessionResponse> GetSession(Core& core, const Call& call, const v1::GetSessionRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_GET_SESSION_H_
