#include "server/handlers/get_program.h"

#include "core/base/error_detail.h"
#include "proto/convert/field.h"
#include "proto/convert/program.h"

namespace axiscal::handlers {

absl::Status GetProgram(Core& core, const Call& call, const v1::GetProgramRequest& request,
                        const std::function<bool(const v1::GetProgramResponse&)>& send) {
  ASSIGN_OR_RETURN(const records::ProgramRecord record, core.database.GetProgram(ProgramId(request.program_id())));
  if (record.state != records::ProgramState::kComplete) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("program ", record.id.number(), " is not complete"), {"PROGRAM_NOT_COMPLETE", {}});
  }
  if (request.offset_bytes() < 0 || request.offset_bytes() > record.byte_count) {
    return convert::FieldError("offset_bytes",
                               absl::StrCat(request.offset_bytes(), ", must be 0 to ", record.byte_count));
  }
  const absl::Status gone = base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
  v1::GetProgramResponse head;
  *head.mutable_program() = convert::ToProto(record);
  if (!send(head)) return gone;
  return core.database.ReadProgram(record.id, request.offset_bytes(), [&](const std::string& bytes) {
    for (size_t at = 0; at < bytes.size(); at += convert::kMaxProgramPartBytes) {
      v1::GetProgramResponse part;
      part.set_data(bytes.substr(at, convert::kMaxProgramPartBytes));
      if (!send(part)) return gone;
    }
    return absl::OkStatus();
  });
}

}  // namespace axiscal::handlers
