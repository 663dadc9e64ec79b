// Programs.PutProgram: a header, then the bytes in order; stored when size and checksum agree.
#ifndef AXISCAL_SERVER_HANDLERS_PUT_PROGRAM_H_
#define AXISCAL_SERVER_HANDLERS_PUT_PROGRAM_H_

#include <string>

#include "axiscal/v1/programs_service.pb.h"
#include "server/handlers/core.h"
#include "server/handlers/declared_bytes.h"

namespace axiscal::handlers {

class PutProgramStream {
 public:
  PutProgramStream(Core& core, const Call& call) : core_(core), call_(call) {}

  // The next message. An error is the status of the call. STREAM_INVALID when messages come in another order,
  // OUT_OF_RANGE SIZE_EXCEEDED when more bytes come than the header says.
  absl::Status Receive(const v1::PutProgramRequest& request);
  // No more messages. ABORTED STREAM_INCOMPLETE when bytes are missing: a malformed message looks like a normal end.
  absl::StatusOr<v1::PutProgramResponse> End();

 private:
  absl::Status Begin(const v1::PutProgramHeader& header);
  absl::Status Append(const std::string& bytes);
  absl::Status Store(const std::string& part);

  Core& core_;
  const Call call_;
  v1::PutProgramHeader header_;
  DeclaredBytes received_;
  records::ProgramRecord program_;
  // Each part that is stored is a transaction that waits for the disk: messages are gathered into parts of one size,
  // the same ones when the program is sent again.
  std::string gathered_;
  int64_t stored_ = 0;  // bytes
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_PUT_PROGRAM_H_
