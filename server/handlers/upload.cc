#include "server/handlers/upload.h"

#include "core/base/error_detail.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {
namespace {

absl::Status OutOfOrder(const std::string& text) {
  return base::Error(absl::StatusCode::kInvalidArgument, text, {"STREAM_INVALID", {}});
}

}  // namespace

UploadStream::UploadStream(Core& core, const Call& call, AcknowledgementWays ways)
    : core_(core), call_(call), ways_(std::move(ways)) {}

UploadStream::~UploadStream() {
  static_cast<void>(WaitForAll());
  StopAcknowledging();
}

absl::Status UploadStream::Receive(const v1::UploadRequest& request) {
  {
    const base::MutexLock lock(mutex_);
    if (!error_.ok()) return error_;
  }
  if (core_.draining) return RequireAccepting(core_);
  if (completed_) return OutOfOrder("a message after finish");
  if (!session_ && !request.has_header()) return OutOfOrder("the first message must be a header");
  switch (request.part_case()) {
    case v1::UploadRequest::kHeader:
      return session_ ? OutOfOrder("a second header") : Begin(request.header());
    case v1::UploadRequest::kChunk:
      return Append(request.chunk());
    case v1::UploadRequest::kFinish:
      return Finish(request.finish());
    default:
      return OutOfOrder("a message that is none of header, chunk, finish");
  }
}

absl::Status UploadStream::Begin(const v1::UploadHeader& header) {
  ASSIGN_OR_RETURN(records::SessionRecord session, core_.database.GetSession(SessionId(header.session_id())));
  if (header.resume_from_seq() < 0) return convert::FieldError("header.resume_from_seq", "must be >= 0");
  if (header.resume_from_seq() > session.next_seq) {
    return base::Error(
        absl::StatusCode::kOutOfRange,
        absl::StrCat("resume_from_seq ", header.resume_from_seq(), ", the session continues at ", session.next_seq),
        {"SEQ_GAP", {{"next_seq", absl::StrCat(session.next_seq)}}});
  }
  expected_seq_ = header.resume_from_seq();
  if (session.state == records::SessionState::kOpen) {
    ASSIGN_OR_RETURN(check_, ReadingCheck::Create(core_, session, expected_seq_));
  }
  {
    const base::MutexLock lock(mutex_);
    next_seq_ = session.next_seq;
  }
  session_ = std::move(session);
  if (ways_.send) acknowledger_ = std::thread([this] { Acknowledge(); });
  return absl::OkStatus();
}

absl::Status UploadStream::Append(const v1::Chunk& message) {
  if (message.seq() > expected_seq_) {
    return base::Error(absl::StatusCode::kOutOfRange,
                       absl::StrCat("chunk ", message.seq(), " came, chunk ", expected_seq_, " is missing"),
                       {"SEQ_GAP", {{"next_seq", absl::StrCat(expected_seq_)}}});
  }
  ASSIGN_OR_RETURN(const records::Chunk chunk, convert::FromProto(message, session_->columns));
  if (chunk.seq() == expected_seq_) {
    // A closed session only compares what comes again.
    if (check_) RETURN_IF_ERROR(check_->Check(chunk));
    if (chunk.seq() >= session_->next_seq) readings_ += chunk.reading_count();
    if (session_->reading_count + readings_ > core_.limits.max_session_readings) {
      return base::Error(absl::StatusCode::kResourceExhausted,
                         absl::StrCat("chunk ", chunk.seq(), ": more than ", core_.limits.max_session_readings,
                                      " readings in a session (limits.session_readings)"),
                         {"SESSION_TOO_LARGE", {}});
    }
    ++expected_seq_;
  }
  {
    const base::MutexLock lock(mutex_);
    while (under_way_ >= core_.limits.window_chunks && error_.ok()) changed_.Wait(mutex_);
    if (!error_.ok()) return error_;
    ++under_way_;
  }
  core_.database.AppendChunkAsync(session_->id, chunk,
                                  [this, count = chunk.reading_count()](absl::StatusOr<storage::AppendResult> result) {
                                    if (result.ok() && !result->duplicate) core_.metrics->ReadingsStored(count);
                                    Stored(result);
                                  });
  return absl::OkStatus();
}

void UploadStream::Stored(const absl::StatusOr<storage::AppendResult>& result) {
  const base::MutexLock lock(mutex_);
  --under_way_;
  if (result.ok()) {
    next_seq_ = std::max(next_seq_, result->next_seq);
    duplicates_ += result->duplicate ? 1 : 0;
  } else if (error_.ok()) {
    error_ = result.status();
  }
  // Under the lock: after it is released this stream may be gone.
  changed_.NotifyAll();
}

absl::Status UploadStream::Finish(const v1::UploadFinish& finish) {
  RETURN_IF_ERROR(WaitForAll());
  absl::StatusOr<records::SessionTotals> totals = convert::FromProto(finish.totals());
  if (!totals.ok()) return convert::InField("finish.totals", totals.status());
  ASSIGN_OR_RETURN(completed_, FinishChecked(core_, session_->id, *totals));
  StopAcknowledging();
  if (!ways_.send) return absl::OkStatus();
  v1::UploadResponse response;
  response.set_next_seq(completed_->next_seq);
  response.set_duplicate_chunks(duplicate_chunks());
  *response.mutable_completed_session() = convert::ToProto(*completed_);
  ways_.await_caller([&] { ways_.send(response); });
  return absl::OkStatus();
}

absl::Status UploadStream::End() {
  const absl::Status status = WaitForAll();
  StopAcknowledging();
  return status;
}

int64_t UploadStream::duplicate_chunks() {
  const base::MutexLock lock(mutex_);
  return duplicates_;
}

absl::Status UploadStream::WaitForAll() {
  const base::MutexLock lock(mutex_);
  while (under_way_ > 0) changed_.Wait(mutex_);
  return error_;
}

// The stream's second thread. After an error it asks the caller to end its side: the status can only be sent when the
// reading thread, which waits for the caller, returns.
void UploadStream::Acknowledge() {
  int64_t acknowledged_seq = -1;
  while (true) {
    v1::UploadResponse response;
    {
      const base::MutexLock lock(mutex_);
      while (!is_stopping_ && error_.ok() && next_seq_ == acknowledged_seq) changed_.Wait(mutex_);
      // What became durable last is acknowledged before the stream ends.
      if (is_stopping_ && next_seq_ == acknowledged_seq) return;
      response.set_next_seq(next_seq_);
      response.set_duplicate_chunks(duplicates_);
      response.set_refused(!error_.ok());
      acknowledged_seq = next_seq_;
    }
    if (!ways_.send(response) || response.refused()) return;
  }
}

void UploadStream::StopAcknowledging() {
  {
    const base::MutexLock lock(mutex_);
    is_stopping_ = true;
    changed_.NotifyAll();
  }
  if (acknowledger_.joinable()) ways_.await_caller([this] { acknowledger_.join(); });
}

absl::Status Summarise(UploadStream& upload, v1::UploadOnceResponse* response) {
  if (!upload.completed()) {
    return base::Error(absl::StatusCode::kAborted, "the stream ended without finish; the session stays open",
                       {"STREAM_INCOMPLETE", {}});
  }
  *response->mutable_session() = convert::ToProto(*upload.completed());
  response->set_duplicate_chunks(upload.duplicate_chunks());
  return absl::OkStatus();
}

}  // namespace axiscal::handlers
