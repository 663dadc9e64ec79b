#include "server/handlers/put_program.h"

#include <string_view>

#include "core/base/error_detail.h"
#include "proto/convert/field.h"
#include "proto/convert/program.h"

namespace axiscal::handlers {
namespace {

constexpr size_t kPartBytes = 1 << 20;

constexpr size_t kLookedAtBytes = 1024;

// Pictures, spreadsheets, texts of two bytes per character: a zero byte stands between others near their begin. In
// front of a program and behind it zeros are the leader and trailer of a punched tape; farther on they stay as they
// are.
absl::Status RequireProgramText(std::string_view program) {
  program = program.substr(0, kLookedAtBytes);
  const size_t begin = program.find_first_not_of('\0');
  const size_t zero = program.find('\0', begin);
  if (begin == program.npos || zero == program.npos || program.find_first_not_of('\0', zero) == program.npos)
    return absl::OkStatus();
  return base::Error(absl::StatusCode::kInvalidArgument,
                     absl::StrCat("data: byte ", zero + 1,
                                  " is 0 and others follow, so that this is no text: an NC program is one, of one byte "
                                  "per character (ASCII or UTF-8)"),
                     {"PROGRAM_NOT_TEXT", {}});
}

}  // namespace

absl::Status PutProgramStream::Receive(const v1::PutProgramRequest& request) {
  RETURN_IF_ERROR(RequireAccepting(core_));
  RETURN_IF_ERROR(received_.CheckOrder(request.has_header(), request.part_case() == v1::PutProgramRequest::kData));
  return received_.is_declared() ? Append(request.data()) : Begin(request.header());
}

absl::Status PutProgramStream::Begin(const v1::PutProgramHeader& header) {
  RETURN_IF_ERROR(convert::RequireText("header.name", header.name(), 1, 255));
  if (header.name().find_first_of("/\\") != std::string::npos) {
    return convert::FieldError("header.name", "must be a file name without folders");
  }
  RETURN_IF_ERROR(convert::RequireNotNegative("header.size_bytes", header.size_bytes()));
  if (header.size_bytes() > core_.limits.max_program_bytes) {
    return base::Error(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("header.size_bytes = ", header.size_bytes(), ", at most ",
                                    core_.limits.max_program_bytes, " may be (limits.program_bytes)"),
                       {"PROGRAM_TOO_LARGE", {}});
  }
  RETURN_IF_ERROR(convert::RequireSha256("header.sha256", header.sha256()));
  RETURN_IF_ERROR(convert::RequireText("header.request_id", header.request_id(), 1, kMaxRequestIdBytes));
  ASSIGN_OR_RETURN(program_, core_.database.BeginProgram({"nc", header.name(), call_.By(header.request_id())}));
  header_ = header;
  received_.Declare(header.size_bytes());
  return absl::OkStatus();
}

absl::Status PutProgramStream::Append(const std::string& bytes) {
  RETURN_IF_ERROR(received_.Take(bytes));
  gathered_ += bytes;
  size_t taken = 0;
  for (; gathered_.size() - taken >= kPartBytes; taken += kPartBytes)
    RETURN_IF_ERROR(Store(gathered_.substr(taken, kPartBytes)));
  gathered_.erase(0, taken);
  return absl::OkStatus();
}

absl::Status PutProgramStream::Store(const std::string& part) {
  const int64_t offset = stored_;
  if (offset == 0) RETURN_IF_ERROR(RequireProgramText(part));
  stored_ += static_cast<int64_t>(part.size());
  // Sent again after it was stored: what is there need not be compared, the checksum is.
  if (program_.state == records::ProgramState::kComplete) return absl::OkStatus();
  return core_.database.AppendProgram(program_.id, offset, part).status();
}

absl::StatusOr<v1::PutProgramResponse> PutProgramStream::End() {
  RETURN_IF_ERROR(received_.CheckEnd());
  if (!gathered_.empty()) RETURN_IF_ERROR(Store(gathered_));
  ASSIGN_OR_RETURN(const records::ProgramRecord record,
                   core_.database.FinishProgram(program_.id, header_.size_bytes(), header_.sha256()));
  v1::PutProgramResponse response;
  *response.mutable_program() = convert::ToProto(record);
  return response;
}

}  // namespace axiscal::handlers
