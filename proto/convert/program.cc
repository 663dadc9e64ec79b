#include "proto/convert/program.h"

#include "proto/convert/field.h"

namespace axiscal::convert {

v1::Program ToProto(const records::ProgramRecord& record) {
  v1::Program message;
  message.set_program_id(record.id.number());
  message.set_name(record.name);
  message.set_size_bytes(record.byte_count);
  message.set_sha256(record.sha256);
  message.set_created_utc_us(base::ToUtcUs(record.created_at));
  message.set_kind(record.kind);
  message.set_created_by(record.created_by);
  return message;
}

absl::StatusOr<records::ProgramRecord> FromProto(const v1::Program& message) {
  RETURN_IF_ERROR(RequirePositive("program_id", message.program_id()));
  RETURN_IF_ERROR(RequireNotNegative("size_bytes", message.size_bytes()));
  RETURN_IF_ERROR(RequireSha256("sha256", message.sha256()));
  records::ProgramRecord record;
  record.id = ProgramId(message.program_id());
  record.kind = message.kind();
  record.name = message.name();
  record.state = records::ProgramState::kComplete;
  record.byte_count = message.size_bytes();
  record.sha256 = message.sha256();
  record.created_by = message.created_by();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  return record;
}

}  // namespace axiscal::convert
