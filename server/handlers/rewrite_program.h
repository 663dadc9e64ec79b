// Programs.RewriteProgram: a program is rewritten while it comes, nothing is stored.
#ifndef AXISCAL_SERVER_HANDLERS_REWRITE_PROGRAM_H_
#define AXISCAL_SERVER_HANDLERS_REWRITE_PROGRAM_H_

#include <functional>
#include <optional>

#include "axiscal/v1/programs_service.pb.h"
#include "core/nc/rewrite.h"
#include "server/handlers/core.h"
#include "server/handlers/declared_bytes.h"
#include "server/inputs/compensation.h"

namespace axiscal::handlers {

class RewriteProgramStream {
 public:
  // `send` returns false when the caller has left.
  RewriteProgramStream(Core& core, const Call& call, std::function<bool(const v1::RewriteProgramResponse&)> send);

  // The next message. An error is the status of the call: STREAM_INVALID when messages come in another order,
  // OUT_OF_RANGE SIZE_EXCEEDED, and those of inputs::CompensationFor and of the engine.
  absl::Status Receive(const v1::RewriteProgramRequest& request);
  // No more messages: sends what is left and the result. ABORTED STREAM_INCOMPLETE when bytes are missing (a malformed
  // message looks like a normal end), FAILED_PRECONDITION TOTALS_MISMATCH when the checksum differs, and the engine's
  // refusal.
  absl::Status End();

 private:
  absl::Status Begin(const v1::RewriteProgramHeader& header);
  absl::Status Rewrite(const std::string& bytes);
  absl::Status Take(const char* bytes, size_t size);
  absl::Status SendData();

  Core& core_;
  const Call call_;
  const std::function<bool(const v1::RewriteProgramResponse&)> send_;
  v1::RewriteProgramHeader header_;
  DeclaredBytes received_;
  std::optional<inputs::Compensation> compensation_;
  std::optional<nc::Rewriter> rewriter_;
  v1::RewriteProgramResponse response_;
  int64_t sent_ = 0;  // bytes
  uint32_t received_crc32c_ = 0, sent_crc32c_ = 0;
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_REWRITE_PROGRAM_H_
