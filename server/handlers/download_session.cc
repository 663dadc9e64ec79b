#include "server/handlers/download_session.h"

#include "core/base/error_detail.h"
#include "core/session/checksum.h"
#include "proto/convert/session.h"

namespace axiscal::handlers {

absl::Status DownloadSession(Core& core, const Call& call, const v1::DownloadSessionRequest& request,
                             const std::function<bool(const v1::DownloadSessionResponse&)>& send) {
  ASSIGN_OR_RETURN(const records::SessionRecord record, core.database.GetSession(SessionId(request.session_id())));
  v1::DownloadSessionResponse head;
  *head.mutable_schema() = convert::ToProto(records::SessionSchema{record.header, record.columns});
  if (record.state != records::SessionState::kComplete) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("session ", record.id.number(), " is not complete"), {"SESSION_NOT_COMPLETE", {}});
  }
  if (!send(head)) return absl::CancelledError("the caller has left");
  records::SessionTotals totals;
  std::vector<uint32_t> crcs;
  RETURN_IF_ERROR(core.database.ReadChunks(record.id, 0, [&](const records::Chunk& chunk) {
    totals.reading_count += chunk.reading_count();
    crcs.push_back(chunk.crc32c());
    v1::DownloadSessionResponse message;
    *message.mutable_chunk() = convert::ToProto(chunk);
    return send(message) ? absl::OkStatus() : absl::CancelledError("the caller has left");
  }));
  totals.chunk_count = static_cast<int64_t>(crcs.size());
  totals.hash = session::SessionHash(crcs);
  v1::DownloadSessionResponse tail;
  *tail.mutable_totals() = convert::ToProto(totals);
  return send(tail) ? absl::OkStatus() : absl::CancelledError("the caller has left");
}

}  // namespace axiscal::handlers
