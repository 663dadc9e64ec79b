// Ingest.CreateSession: opens a session whose header and columns fit its instrument and machine.
#ifndef AXISCAL_SERVER_HANDLERS_CREATE_SESSION_H_
#define AXISCAL_SERVER_HANDLERS_CREATE_SESSION_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::CreateSessionResponse> CreateSession(Core& core, const Call& call,
                                                        const v1::CreateSessionRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_CREATE_SESSION_H_
