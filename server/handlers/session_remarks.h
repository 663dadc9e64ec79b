// What people say of sessions: Ingest.AnnotateSession, RejectSession.
#ifndef AXISCAL_SERVER_HANDLERS_SESSION_REMARKS_H_
#define AXISCAL_SERVER_HANDLERS_SESSION_REMARKS_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::AnnotateSessionResponse> AnnotateSession(Core& core, const Call& call,
                                                            const v1::AnnotateSessionRequest& request);
absl::StatusOr<v1::RejectSessionResponse> RejectSession(Core& core, const Call& call,
                                                        const v1::RejectSessionRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_SESSION_REMARKS_H_
