#include "server/jobs/job_sessions.h"

#include <map>

#include "core/identify/identify.h"
#include "core/machine/machine_json.h"
#include "core/session/check_machine.h"

namespace axiscal::jobs {
namespace {

void Rename(const std::string& name, session::Session* session) {
  for (session::HeaderEntry& entry : session->header) {
    if (entry.key == "session") entry.value = name;
  }
}

}  // namespace

absl::StatusOr<MachineInput> LoadMachine(storage::Database& database, const MachineId& id) {
  MachineInput input;
  ASSIGN_OR_RETURN(input.record, database.GetMachine(id));
  ASSIGN_OR_RETURN(input.machine, machine::MachineFromJson(input.record.description_json));
  return input;
}

absl::StatusOr<MeasuredSessions> LoadSessions(storage::Database& database, const std::vector<SessionId>& ids,
                                              const machine::Machine& machine, const std::function<bool()>& cancelled) {
  MeasuredSessions stored;
  stored.measured_at = base::UtcTime::min();
  std::map<std::string, int> uses;
  for (const SessionId& id : ids) {
    ASSIGN_OR_RETURN(stored.records.emplace_back(), database.GetSession(id));
    ++uses[stored.records.back().name];
  }
  for (const records::SessionRecord& record : stored.records) {
    if (cancelled()) return absl::CancelledError("stopped");
    ASSIGN_OR_RETURN(session::Session session, database.ReadSession(record.id));
    const std::string name = absl::StrCat(record.name, "#", record.id.number());
    // The machine may have been described anew since the upload.
    RETURN_IF_ERROR(base::Within("session " + name, session::CheckAgainstMachine(session, machine)));
    // A machine is measured again under the same names: each measurement is a session, and a set-up, of its own.
    if (uses[record.name] > 1) Rename(name, &session);
    ASSIGN_OR_RETURN(stored.runs.emplace_back(), identify::BindMeasured(session, machine));
    stored.measured_at = std::max(stored.measured_at, record.measured_at.value_or(record.created_at));
  }
  return stored;
}

absl::StatusOr<MeasuredSessions> LoadSessions(storage::Database& database, const std::vector<SessionId>& ids,
                                              const machine::Machine& machine, JobContext& context) {
  return LoadSessions(database, ids, machine, [&context] { return context.cancelled(); });
}

}  // namespace axiscal::jobs
