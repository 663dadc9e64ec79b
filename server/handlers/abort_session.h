// Ingest.AbortSession: gives an open session up.
#ifndef AXISCAL_SERVER_HANDLERS_ABORT_SESSION_H_
#define AXISCAL_SERVER_HANDLERS_ABORT_SESSION_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::AbortSessionResponse> AbortSession(Core& core, const Call& call,
                                                      const v1::AbortSessionRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_ABORT_SESSION_H_
