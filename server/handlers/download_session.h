// Ingest.DownloadSession: a complete session, schema first, totals last.
#ifndef AXISCAL_SERVER_HANDLERS_DOWNLOAD_SESSION_H_
#define AXISCAL_SERVER_HANDLERS_DOWNLOAD_SESSION_H_

#include "axiscal/v1/ingest_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// `send` returns false when the caller has left.
absl::Status DownloadSession(Core& core, const Call& call, const v1::DownloadSessionRequest& request,
                             const std::function<bool(const v1::DownloadSessionResponse&)>& send);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_DOWNLOAD_SESSION_H_
