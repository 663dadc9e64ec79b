#include "server/handlers/put_log.h"

#include <algorithm>
#include <sstream>

#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "core/logs/reduce.h"
#include "core/records/chunked_session.h"
#include "core/session/read_session.h"
#include "proto/convert/field.h"
#include "proto/convert/log.h"
#include "proto/convert/program.h"
#include "proto/convert/session.h"
#include "server/handlers/session_check.h"

namespace axiscal::handlers {
namespace {

// What a byte of a log takes while it is reduced: the text, its fields, the session's cells; of usual lines of some 30
// characters and four numbers 10 to 14.
constexpr int64_t kBytesOfByte = 16;
constexpr size_t kPartBytes = 1 << 20;

// What is wrong with log, template or plan: with the place, where the reader gave one.
absl::Status Invalid(const absl::Status& status) {
  if (status.ok() || base::GetErrorDetail(status)) return status;
  if (absl::IsCancelled(status)) return base::Error(status.code(), std::string(status.message()), {"CALLER_GONE", {}});
  return base::Error(absl::StatusCode::kInvalidArgument, std::string(status.message()), {"LOG_INVALID", {}});
}

absl::StatusOr<logs::Reduced> Reduce(const std::string& log, const std::string& name, const records::LogForm& form,
                                     const machine::Machine& machine, const std::function<bool()>& cancelled) {
  ASSIGN_OR_RETURN(
      const logs::LogTemplate log_template,
      logs::ReadTemplate(form.template_text, form.template_name.empty() ? "template" : form.template_name));
  std::optional<session::Session> plan;
  if (!form.plan_text.empty()) {
    ASSIGN_OR_RETURN(plan, session::ReadPlanText(form.plan_text, form.plan_name.empty() ? "plan" : form.plan_name));
  }
  std::istringstream in(log);
  return logs::Reduce(in, name, log_template,
                      {.machine = &machine,
                       .plan = plan ? &*plan : nullptr,
                       .session = form.session,
                       .start_s = form.start_s,
                       .cancelled = cancelled});
}

// Keeps the raw text beside the session. The same bytes under the same name are one program.
absl::StatusOr<records::ProgramRecord> Keep(Core& core, const Call& call, const MachineId& machine,
                                            const std::string& kind, const std::string& name,
                                            const std::string& bytes) {
  const std::string sha256 = base::Sha256Hex(bytes);
  const std::string request = base::Sha256Hex(absl::StrCat(kind, "\n", machine.text(), "\n", name, "\n", sha256));
  ASSIGN_OR_RETURN(records::ProgramRecord program, core.database.BeginProgram({kind, name, call.By(request), machine}));
  if (program.state == records::ProgramState::kComplete) return program;
  for (size_t at = 0; at < bytes.size(); at += kPartBytes) {
    RETURN_IF_ERROR(
        core.database.AppendProgram(program.id, static_cast<int64_t>(at), bytes.substr(at, kPartBytes)).status());
  }
  return core.database.FinishProgram(program.id, static_cast<int64_t>(bytes.size()), sha256);
}

// The header says where the session is from.
absl::StatusOr<records::ProgramRecord> KeepAll(Core& core, const Call& call, const v1::PutLogHeader& header,
                                               const records::LogForm& form, const std::string& log,
                                               session::Session& session) {
  const MachineId machine(header.machine_id());
  ASSIGN_OR_RETURN(const records::ProgramRecord kept, Keep(core, call, machine, "log", header.name(), log));
  // What a template's or a plan's own lines say of another log.
  std::erase_if(session.header,
                [](const session::HeaderEntry& entry) { return entry.key == "log" || entry.key.starts_with("log_"); });
  const auto add = [&](const std::string& key, const std::string& value) { session.header.push_back({key, value}); };
  add("log", header.name());
  add("log_sha256", kept.sha256);
  add("log_program", std::to_string(kept.id.number()));
  const std::vector<std::string>& known = logs::KnownFormats();
  if (std::find(known.begin(), known.end(), form.template_text) != known.end()) {
    add("log_template", form.template_text);
  } else {
    ASSIGN_OR_RETURN(const records::ProgramRecord rules,
                     Keep(core, call, machine, "log-template",
                          form.template_name.empty() ? "template" : form.template_name, form.template_text));
    add("log_template", std::to_string(rules.id.number()));
  }
  if (!form.plan_text.empty()) {
    ASSIGN_OR_RETURN(
        const records::ProgramRecord plan,
        Keep(core, call, machine, "log-plan", form.plan_name.empty() ? "plan" : form.plan_name, form.plan_text));
    add("log_plan", std::to_string(plan.id.number()));
  }
  return kept;
}

// As a client would upload it: resumed where an earlier attempt stopped.
absl::StatusOr<records::SessionRecord> Store(Core& core, const Call& call, const std::string& request_id,
                                             const MachineId& machine, const session::Session& session,
                                             bool* was_there) {
  ASSIGN_OR_RETURN(records::SessionRecord stored,
                   core.database.CreateSession(NewSessionOf(machine, records::SchemaOf(session), call.By(request_id))));
  *was_there = stored.state == records::SessionState::kComplete;
  if (*was_there) return stored;
  ASSIGN_OR_RETURN(ReadingCheck check, ReadingCheck::Create(core, stored, stored.next_seq));
  records::ChunkedSession chunks(session, records::kUsualChunkReadings);
  for (int64_t seq = stored.next_seq; seq < chunks.chunk_count(); ++seq) {
    const records::Chunk chunk = chunks.At(seq);
    RETURN_IF_ERROR(check.Check(chunk));
    ASSIGN_OR_RETURN(const storage::AppendResult appended, core.database.AppendChunk(stored.id, chunk));
    if (!appended.duplicate) core.metrics->ReadingsStored(chunk.reading_count());
  }
  return FinishChecked(core, stored.id, chunks.Totals());
}

}  // namespace

absl::Status PutLogStream::Receive(const v1::PutLogRequest& request) {
  RETURN_IF_ERROR(RequireAccepting(core_));
  RETURN_IF_ERROR(received_.CheckOrder(request.has_header(), request.part_case() == v1::PutLogRequest::kData));
  return received_.is_declared() ? Append(request.data()) : Begin(request.header());
}

absl::Status PutLogStream::Begin(const v1::PutLogHeader& header) {
  RETURN_IF_ERROR(convert::RequireText("header.machine_id", header.machine_id(), 1, 255));
  RETURN_IF_ERROR(convert::RequireText("header.name", header.name(), 1, 255));
  if (header.name().find_first_of("/\\") != std::string::npos)
    return convert::FieldError("header.name", "must be a file name without folders");
  RETURN_IF_ERROR(convert::RequirePositive("header.size_bytes", header.size_bytes()));
  if (header.size_bytes() > records::kMaxLogBytes) {
    return base::Error(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("header.size_bytes = ", header.size_bytes(), ", at most ", records::kMaxLogBytes,
                                    " may be of a log"),
                       {"LOG_TOO_LARGE", {}});
  }
  RETURN_IF_ERROR(convert::RequireSha256("header.sha256", header.sha256()));
  RETURN_IF_ERROR(RequireRequestId(header.request_id()));
  absl::StatusOr<records::LogForm> form = convert::FromProto(header.form());
  if (!form.ok()) return convert::InField("header.form", form.status());
  RETURN_IF_ERROR(MachineOf(core_, MachineId(header.machine_id())).status());
  form_ = *std::move(form);
  header_ = header;
  received_.Declare(header.size_bytes());
  return absl::OkStatus();
}

absl::Status PutLogStream::Append(const std::string& bytes) {
  RETURN_IF_ERROR(received_.Take(bytes));
  // As they come: a stream that stands still holds no more than it has sent.
  RETURN_IF_ERROR(share_.Take(kBytesOfByte * static_cast<int64_t>(bytes.size())));
  bytes_ += bytes;
  return absl::OkStatus();
}

absl::StatusOr<v1::PutLogResponse> PutLogStream::End() {
  RETURN_IF_ERROR(received_.CheckEnd());
  if (base::Sha256Hex(bytes_) != header_.sha256()) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       "the bytes that came have another checksum than header.sha256 says", {"TOTALS_MISMATCH", {}});
  }
  const MachineId machine_id(header_.machine_id());
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineOf(core_, machine_id));
  absl::StatusOr<logs::Reduced> reduced = Reduce(bytes_, header_.name(), form_, machine, call_.is_cancelled);
  if (!reduced.ok()) return Invalid(reduced.status());
  session::Session& session = reduced->session;
  if (static_cast<int64_t>(session.reading_count()) > core_.limits.max_session_readings) {
    return base::Error(
        absl::StatusCode::kResourceExhausted,
        absl::StrCat(header_.name(), ": ", session.reading_count(), " readings, at most ",
                     core_.limits.max_session_readings, " may be in a session (limits.session_readings)"),
        {"SESSION_TOO_LARGE", {}});
  }
  RETURN_IF_ERROR(CheckSchema(core_, machine_id, records::SchemaOf(session)));
  records::StoredLog stored;
  ASSIGN_OR_RETURN(stored.log, KeepAll(core_, call_, header_, form_, bytes_, session));
  ASSIGN_OR_RETURN(stored.session, Store(core_, call_, header_.request_id(), machine_id, session, &stored.was_there));
  stored.notes = reduced->notes;
  stored.first_line = static_cast<int64_t>(reduced->lines.front());
  stored.last_line = static_cast<int64_t>(reduced->lines.back());
  if (reduced->cut) stored.cut_line = static_cast<int64_t>(reduced->cut->line);
  return convert::ToProto(stored);
}

}  // namespace axiscal::handlers
