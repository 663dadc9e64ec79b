#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "client/connection.h"
#include "client/transfer.h"
#include "core/session/checksum.h"
#include "proto/convert/session.h"

namespace axiscal::client {
namespace {

// The session as far as it has come; complete when the totals fit.
class Assembly {
 public:
  absl::Status Take(const v1::DownloadSessionResponse& message) {
    if (message.has_schema()) {
      ASSIGN_OR_RETURN(schema_, convert::FromProto(message.schema()));
      session_.header = schema_.header;
      for (const records::ColumnSpec& column : schema_.columns) session_.columns.push_back({column.name, {}, {}});
      return absl::OkStatus();
    }
    if (message.has_totals()) {
      ASSIGN_OR_RETURN(const records::SessionTotals totals, convert::FromProto(message.totals()));
      is_complete_ = totals.hash == session::SessionHash(crcs_) &&
                     totals.reading_count == static_cast<int64_t>(session_.reading_count());
      return is_complete_ ? absl::OkStatus() : absl::DataLossError("the session's totals do not fit what came");
    }
    ASSIGN_OR_RETURN(const records::Chunk chunk, convert::FromProto(message.chunk(), schema_.columns));
    crcs_.push_back(chunk.crc32c());
    for (size_t i = 0; i < chunk.columns().size(); ++i) {
      session::Column& to = session_.columns[i];
      const session::Column& from = chunk.columns()[i];
      to.values.insert(to.values.end(), from.values.begin(), from.values.end());
      to.texts.insert(to.texts.end(), from.texts.begin(), from.texts.end());
    }
    return absl::OkStatus();
  }
  bool is_complete() const { return is_complete_; }
  session::Session Finish() { return std::move(session_); }

 private:
  records::SessionSchema schema_;
  session::Session session_;
  std::vector<uint32_t> crcs_;
  bool is_complete_ = false;
};

}  // namespace

absl::StatusOr<session::Session> DownloadSession(const Connection& connection, SessionId id) {
  const auto stub = v1::Ingest::NewStub(connection.channel());
  v1::DownloadSessionRequest request;
  request.set_session_id(id.number());
  Backoff backoff(connection.options());
  const base::SteadyTime give_up = base::SystemClock().SteadyNow() + connection.options().give_up_after;
  while (true) {
    const auto context = connection.NewStreamContext();
    const auto reader = stub->DownloadSession(context.get(), request);
    Assembly assembly;
    absl::Status taken;
    v1::DownloadSessionResponse message;
    while (taken.ok() && reader->Read(&message)) taken = assembly.Take(message);
    if (!taken.ok()) context->TryCancel();
    const absl::Status status = connection.FromGrpc(reader->Finish());
    RETURN_IF_ERROR(taken);
    if (status.ok() && assembly.is_complete()) return assembly.Finish();
    if (!status.ok() && !absl::IsUnavailable(status)) return status;
    if (!backoff.Wait(give_up))
      return status.ok() ? absl::UnavailableError("the download ended before its end") : status;
  }
}

}  // namespace axiscal::client
