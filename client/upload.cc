#include "client/upload.h"

#include <thread>

#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "client/connection.h"
#include "core/base/error_detail.h"
#include "core/base/mutex.h"
#include "core/records/chunked_session.h"
#include "proto/convert/session.h"

namespace axiscal::client {
namespace {

using Stream = grpc::ClientReaderWriter<v1::UploadRequest, v1::UploadResponse>;

absl::Status RequireEqualColumns(const session::Session& session) {
  for (const session::Column& column : session.columns) {
    if (column.values.size() + column.texts.size() != session.reading_count() ||
        (!column.values.empty() && !column.texts.empty())) {
      return absl::InvalidArgumentError(absl::StrCat(column.name, ": ", column.values.size() + column.texts.size(),
                                                     " cells, must be ", session.reading_count()));
    }
  }
  if (session.reading_count() == 0) return absl::InvalidArgumentError("no readings, expected at least one");
  return absl::OkStatus();
}

// What the responses of one stream said, read on a thread of its own.
class Acknowledgements {
 public:
  explicit Acknowledgements(int64_t next_seq) : next_seq_(next_seq) {}

  void ReadAll(Stream& stream) {
    v1::UploadResponse response;
    while (stream.Read(&response)) {
      const base::MutexLock lock(mutex_);
      next_seq_ = std::max(next_seq_, response.next_seq());
      duplicates_ = response.duplicate_chunks();
      if (response.has_completed_session()) completed_ = response.completed_session();
      if (response.refused()) is_over_ = true;
      changed_.NotifyAll();
    }
    const base::MutexLock lock(mutex_);
    is_over_ = true;
    changed_.NotifyAll();
  }
  // Until a chunk of that seq may be sent with `window` under way; false when the stream is over. The point that is
  // durable goes to *next_seq.
  bool WaitForRoom(int64_t seq, int window, int64_t* next_seq) {
    const base::MutexLock lock(mutex_);
    while (!is_over_ && seq >= next_seq_ + window) changed_.Wait(mutex_);
    *next_seq = next_seq_;
    return !is_over_;
  }
  // Until something new is durable or the stream is over; false then.
  bool WaitForMore(int64_t* next_seq) {
    const base::MutexLock lock(mutex_);
    while (!is_over_ && next_seq_ <= *next_seq) changed_.Wait(mutex_);
    *next_seq = next_seq_;
    return !is_over_;
  }
  int64_t next_seq() {
    const base::MutexLock lock(mutex_);
    return next_seq_;
  }
  int64_t duplicates() {
    const base::MutexLock lock(mutex_);
    return duplicates_;
  }
  std::optional<v1::Session> completed() {
    const base::MutexLock lock(mutex_);
    return completed_;
  }

 private:
  base::Mutex mutex_;
  base::CondVar changed_;
  int64_t next_seq_ AXISCAL_GUARDED_BY(mutex_);
  int64_t duplicates_ AXISCAL_GUARDED_BY(mutex_) = 0;
  std::optional<v1::Session> completed_ AXISCAL_GUARDED_BY(mutex_);
  bool is_over_ AXISCAL_GUARDED_BY(mutex_) = false;
};

class Uploader {
 public:
  Uploader(const Connection& connection, const session::Session& session, const ProgressCallback& progress)
      : connection_(connection),
        stub_(v1::Ingest::NewStub(connection.channel())),
        chunks_(session, connection.options().chunk_readings),
        progress_(progress) {}

  absl::StatusOr<UploadResult> Run(const v1::CreateSessionRequest& request) {
    v1::CreateSessionResponse created;
    RETURN_IF_ERROR(connection_.Call(
        [&](grpc::ClientContext* context) { return stub_->CreateSession(context, request, &created); }));
    ASSIGN_OR_RETURN(result_.session, convert::FromProto(created.session()));
    if (result_.session.state == records::SessionState::kComplete) {
      result_.was_there = true;
      Report(chunks_.chunk_count());
      return result_;
    }
    window_ = std::clamp(std::min(connection_.options().window_chunks, created.window_chunks()), 1, 64);
    next_seq_ = result_.session.next_seq;
    return SendUntilComplete();
  }

 private:
  absl::StatusOr<UploadResult> SendUntilComplete() {
    Backoff backoff(connection_.options());
    base::SteadyTime give_up = GiveUpTime();
    while (true) {
      const int64_t before = next_seq_;
      const absl::Status status = RunStream();
      if (result_.session.state == records::SessionState::kComplete) return result_;
      if (!status.ok() && !IsBroken(status)) return status;
      ++result_.interruptions;
      if (next_seq_ > before) {
        give_up = GiveUpTime();
        backoff = Backoff(connection_.options());
      }
      // The server may know more than the last acknowledgement that came through; it may even be complete.
      absl::Status asked;
      do {
        if (!backoff.Wait(give_up)) {
          return status.ok() ? absl::UnavailableError("the server ends the stream before its end") : status;
        }
        asked = AskWhere();
        if (!asked.ok() && !IsBroken(asked)) return asked;
      } while (!asked.ok());
      if (result_.session.state == records::SessionState::kComplete) return result_;
    }
  }

  base::SteadyTime GiveUpTime() const { return base::SystemClock().SteadyNow() + connection_.options().give_up_after; }

  absl::Status AskWhere() {
    v1::GetSessionRequest request;
    request.set_session_id(result_.session.id.number());
    v1::GetSessionResponse response;
    RETURN_IF_ERROR(
        connection_.Call([&](grpc::ClientContext* context) { return stub_->GetSession(context, request, &response); }));
    ASSIGN_OR_RETURN(result_.session, convert::FromProto(response.session()));
    next_seq_ = result_.session.next_seq;
    return absl::OkStatus();
  }

  // One stream from next_seq_ on, as far as it gets. OK with an open session: it ended before its end.
  absl::Status RunStream() {
    const std::unique_ptr<grpc::ClientContext> context = connection_.NewStreamContext();
    const std::unique_ptr<Stream> stream = stub_->Upload(context.get());
    Acknowledgements acknowledgements(next_seq_);
    std::thread reader([&] { acknowledgements.ReadAll(*stream); });
    Send(*stream, acknowledgements);
    stream->WritesDone();
    reader.join();
    const absl::Status status = connection_.FromGrpc(stream->Finish());
    next_seq_ = acknowledgements.next_seq();
    result_.duplicate_chunks += acknowledgements.duplicates();
    if (const std::optional<v1::Session> completed = acknowledgements.completed()) {
      ASSIGN_OR_RETURN(result_.session, convert::FromProto(*completed));
      Report(chunks_.chunk_count());
    }
    return status;
  }

  // Header, chunks, finish; returns early when the stream is over.
  void Send(Stream& stream, Acknowledgements& acknowledgements) {
    v1::UploadRequest request;
    request.mutable_header()->set_session_id(result_.session.id.number());
    request.mutable_header()->set_resume_from_seq(next_seq_);
    if (!stream.Write(request)) return;
    int64_t durable = next_seq_;
    for (int64_t seq = next_seq_; seq < chunks_.chunk_count(); ++seq) {
      if (!acknowledgements.WaitForRoom(seq, window_, &durable)) return;
      Report(durable);
      *request.mutable_chunk() = convert::ToProto(chunks_.At(seq));
      if (!stream.Write(request)) return;
    }
    *request.mutable_finish()->mutable_totals() = convert::ToProto(chunks_.Totals());
    if (!stream.Write(request)) return;
    while (durable < chunks_.chunk_count() && acknowledgements.WaitForMore(&durable)) Report(durable);
  }

  void Report(int64_t durable_chunks) {
    if (!progress_ || durable_chunks == reported_chunks_) return;
    reported_chunks_ = durable_chunks;
    progress_({chunks_.ReadingsBelow(durable_chunks), chunks_.reading_count(), result_.interruptions});
  }

  const Connection& connection_;
  const std::unique_ptr<v1::Ingest::Stub> stub_;
  records::ChunkedSession chunks_;
  const ProgressCallback& progress_;
  UploadResult result_;
  int window_ = 1;
  int64_t next_seq_ = 0;
  int64_t reported_chunks_ = -1;
};

}  // namespace

absl::StatusOr<UploadResult> UploadSession(const Connection& connection, const MachineId& machine,
                                           const session::Session& session, const ProgressCallback& progress) {
  RETURN_IF_ERROR(RequireEqualColumns(session));
  v1::CreateSessionRequest request;
  request.set_machine_id(machine.text());
  request.set_request_id(records::ContentId(machine, session, connection.options().chunk_readings));
  *request.mutable_schema() = convert::ToProto(records::SchemaOf(session));
  return Uploader(connection, session, progress).Run(request);
}

}  // namespace axiscal::client
