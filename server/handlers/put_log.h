// Ingest.PutLog: a header, then a controller's log in order; reduced, and stored with its session when size and
// checksum agree. What is wrong stores nothing.
#ifndef AXISCAL_SERVER_HANDLERS_PUT_LOG_H_
#define AXISCAL_SERVER_HANDLERS_PUT_LOG_H_

#include <string>

#include "axiscal/v1/ingest_service.pb.h"
#include "core/records/log.h"
#include "server/handlers/core.h"
#include "server/handlers/declared_bytes.h"

namespace axiscal::handlers {

class PutLogStream {
 public:
  PutLogStream(Core& core, const Call& call) : core_(core), call_(call), share_(core.reducing, call.user) {}

  // The next message. An error is the status of the call. STREAM_INVALID when messages come in another order,
  // OUT_OF_RANGE SIZE_EXCEEDED when more bytes come than the header says.
  absl::Status Receive(const v1::PutLogRequest& request);
  // No more messages. ABORTED STREAM_INCOMPLETE when bytes are missing: a malformed message looks like a normal end.
  // INVALID_ARGUMENT LOG_INVALID (line, column, name) where log, template or plan is wrong.
  absl::StatusOr<v1::PutLogResponse> End();

 private:
  absl::Status Begin(const v1::PutLogHeader& header);
  absl::Status Append(const std::string& bytes);

  Core& core_;
  const Call call_;
  Share share_;
  v1::PutLogHeader header_;
  DeclaredBytes received_;
  records::LogForm form_;
  std::string bytes_;
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_PUT_LOG_H_
