// Ingest.Upload and UploadOnce: one stream of header, chunks and finish. Chunks go to the disk several at a time; an
// acknowledgement is sent when they are durable.
#ifndef AXISCAL_SERVER_HANDLERS_UPLOAD_H_
#define AXISCAL_SERVER_HANDLERS_UPLOAD_H_

#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "axiscal/v1/ingest_service.pb.h"
#include "core/base/mutex.h"
#include "server/handlers/core.h"
#include "server/handlers/session_check.h"

namespace axiscal::handlers {

// How acknowledgements leave. Without `send` none are sent.
struct AcknowledgementWays {
  // Blocks until the caller has room for it; false when the caller has left. Called on a thread of the stream, too.
  std::function<bool(const v1::UploadResponse&)> send;
  // Runs what blocks until the caller takes an acknowledgement, as part of its silence (HeldCall::Await).
  std::function<void(const std::function<void()>&)> await_caller = [](const std::function<void()>& wait) { wait(); };
};

class UploadStream {
 public:
  UploadStream(Core& core, const Call& call, AcknowledgementWays ways);
  // Waits until nothing of this stream is under way, and until the caller has taken what is being acknowledged.
  ~UploadStream();
  UploadStream(const UploadStream&) = delete;
  UploadStream& operator=(const UploadStream&) = delete;

  // The next message. An error is the status of the call: nothing more may be received. UNAVAILABLE DRAINING when the
  // server stops, STREAM_INVALID when messages come in another order.
  absl::Status Receive(const v1::UploadRequest& request);
  // No more messages, or none that can be read. Waits for what is under way and acknowledges it; an error is the status
  // of the call. The session stays open unless it was finished.
  absl::Status End();

  // Set when the session was finished.
  const std::optional<records::SessionRecord>& completed() const { return completed_; }
  int64_t duplicate_chunks();

 private:
  absl::Status Begin(const v1::UploadHeader& header);
  absl::Status Append(const v1::Chunk& message);
  absl::Status Finish(const v1::UploadFinish& finish);
  void Stored(const absl::StatusOr<storage::AppendResult>& result);
  absl::Status WaitForAll();
  void Acknowledge();
  void StopAcknowledging();

  Core& core_;
  const Call call_;
  const AcknowledgementWays ways_;
  std::optional<records::SessionRecord> session_;
  std::optional<ReadingCheck> check_;
  int64_t expected_seq_ = 0;
  int64_t readings_ = 0;  // that came behind those that the session had
  std::optional<records::SessionRecord> completed_;

  base::Mutex mutex_;
  base::CondVar changed_;
  int under_way_ AXISCAL_GUARDED_BY(mutex_) = 0;
  int64_t next_seq_ AXISCAL_GUARDED_BY(mutex_) = 0;
  int64_t duplicates_ AXISCAL_GUARDED_BY(mutex_) = 0;
  absl::Status error_ AXISCAL_GUARDED_BY(mutex_);
  bool is_stopping_ AXISCAL_GUARDED_BY(mutex_) = false;

  std::thread acknowledger_;
};

// The answer of UploadOnce after End(). ABORTED STREAM_INCOMPLETE when the session was not finished.
absl::Status Summarise(UploadStream& upload, v1::UploadOnceResponse* response);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_UPLOAD_H_
