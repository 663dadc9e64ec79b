// Ingest.FinishSession: closes an open session whose chunks are all there.
#ifndef AXISCAL_SERVER_HANDLERS_FINISH_SESSION_H_
#define AXISCAL_SERVER_HANDLERS_FINISH_SESSION_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::FinishSessionResponse> FinishSession(Core& core, const Call& call,
                                                        const v1::FinishSessionRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_FINISH_SESSION_H_
