#include "proto/convert/routine.h"

#include <set>

#include "proto/convert/access.h"
#include "proto/convert/field.h"
#include "proto/convert/job_params.h"
#include "proto/convert/time.h"

namespace axiscal::convert {
namespace {

using records::RoutineWork;
using records::Scope;

constexpr int kMostNames = 32;          // of a set that is measured within a day
constexpr int kMostHoursOfSet = 8760;   // a year
constexpr int kDefaultHoursOfSet = 24;  // measured in one night
constexpr int kMinutesOfDay = 24 * 60;
constexpr double kMostApprovedUm = 10'000;
constexpr size_t kMostNoteBytes = 1000;
constexpr size_t kMostOptionBytes = 8192;  // of budget and declared errors: all routines are listed in one message

// Each once, also over both lists.
template <typename Texts>
absl::Status ReadNames(const std::string& field, const Texts& texts, std::set<std::string>& seen,
                       std::vector<std::string>& names) {
  RETURN_IF_ERROR(RequireAtMost(field, texts.size(), kMostNames));
  for (int i = 0; i < texts.size(); ++i) {
    const std::string place = absl::StrCat(field, "[", i, "]");
    RETURN_IF_ERROR(RequireText(place, texts[i], 1, 255));
    if (!seen.insert(texts[i]).second) return FieldError(place, texts[i] + " stands twice");
    names.push_back(texts[i]);
  }
  return absl::OkStatus();
}

// What the jobs' own params are held to, with a machine and sessions in the place of those to come.
template <typename Params, typename Message>
absl::StatusOr<Params> ReadOptions(const v1::Routine& message, Message params) {
  params.set_machine_id("machine");
  params.set_budget_json(message.budget_json());
  if (message.has_monte_carlo_runs()) params.set_monte_carlo_runs(message.monte_carlo_runs());
  if (message.has_monte_carlo_seed()) params.set_monte_carlo_seed(message.monte_carlo_seed());
  size_t bytes = message.budget_json().size();
  for (const std::string& error : message.declared_errors()) bytes += error.size();
  if (bytes > kMostOptionBytes) {
    return FieldError("budget_json",
                      absl::StrCat(bytes, " bytes with declared_errors, must be at most ", kMostOptionBytes));
  }
  ASSIGN_OR_RETURN(const records::JobParams read, FromProto(params));
  return std::get<Params>(read);
}

template <typename Params>
void TakeSimulation(const Params& params, records::Routine& routine) {
  routine.budget_json = params.budget_json;
  routine.monte_carlo_runs = params.monte_carlo_runs;
  routine.monte_carlo_seed = params.monte_carlo_seed;
}

absl::Status ReadWork(const v1::Routine& message, records::Routine& routine) {
  if (message.work() == v1::ROUTINE_WORK_IDENTIFY) {
    if (!routine.check_sessions.empty())
      return FieldError("check_sessions", "must be empty: an identification proves nothing on other sessions");
    if (message.has_max_effects())
      return FieldError("max_effects", "must not be set: it is of ROUTINE_WORK_CLOSE_LOOP");
    v1::IdentifyParams params;
    params.add_session_ids(1);
    *params.mutable_declared_errors() = message.declared_errors();
    ASSIGN_OR_RETURN(const auto read, ReadOptions<records::IdentifyParams>(message, params));
    routine.work = RoutineWork::kFit;
    routine.declared = read.declared;
    TakeSimulation(read, routine);
    return absl::OkStatus();
  }
  if (message.work() != v1::ROUTINE_WORK_CLOSE_LOOP)
    return FieldError("work", absl::StrCat(static_cast<int>(message.work()), " is no work of a routine"));
  if (message.declared_errors_size() > 0)
    return FieldError("declared_errors", "must be empty: they are of ROUTINE_WORK_IDENTIFY");
  v1::CloseLoopParams params;
  params.add_fit_session_ids(1);
  if (message.has_max_effects()) params.set_max_effects(message.max_effects());
  ASSIGN_OR_RETURN(const auto read, ReadOptions<records::CloseLoopParams>(message, params));
  routine.work = RoutineWork::kLoop;
  routine.max_effects = read.max_effects;
  TakeSimulation(read, routine);
  return absl::OkStatus();
}

}  // namespace

v1::Routine ToProto(const records::Routine& routine) {
  v1::Routine message;
  message.set_name(routine.name);
  *message.mutable_scope() = ToProto(routine.scope);
  message.set_principal(routine.principal);
  for (const std::string& name : routine.sessions) message.add_sessions(name);
  for (const std::string& name : routine.check_sessions) message.add_check_sessions(name);
  message.set_within_hours(routine.within_hours);
  if (routine.at_utc_minute) message.set_at_utc_minute(*routine.at_utc_minute);
  message.set_work(static_cast<v1::RoutineWork>(routine.work));
  for (const std::string& error : routine.declared) message.add_declared_errors(error);
  if (routine.max_effects) message.set_max_effects(*routine.max_effects);
  message.set_budget_json(routine.budget_json);
  if (routine.monte_carlo_runs) {
    message.set_monte_carlo_runs(*routine.monte_carlo_runs);
    message.set_monte_carlo_seed(routine.monte_carlo_seed);
  }
  if (routine.approve_within_um) message.set_approve_within_um(*routine.approve_within_um);
  message.set_disabled(!routine.is_enabled);
  message.set_note(routine.note);
  return message;
}

v1::Routine ToProto(const records::RoutineRecord& record) {
  v1::Routine message = ToProto(record.content);
  message.set_etag(record.etag);
  message.set_created_by(record.created_by);
  message.set_created_utc_us(base::ToUtcUs(record.created_at));
  message.set_changed_by(record.changed_by);
  message.set_changed_utc_us(base::ToUtcUs(record.changed_at));
  for (const records::RoutineStop& stop : record.stops) {
    v1::RoutineStop& added = *message.add_stops();
    added.set_machine_id(stop.machine.text());
    added.set_by(stop.by);
    added.set_note(stop.note);
    added.set_at_utc_us(base::ToUtcUs(stop.at));
  }
  return message;
}

absl::StatusOr<records::Routine> FromProto(const v1::Routine& message) {
  records::Routine routine;
  RETURN_IF_ERROR(RequireAccessName("name", message.name()));
  routine.name = message.name();
  ASSIGN_OR_RETURN(routine.scope, FromProto(message.scope()));
  if (routine.scope.kind == Scope::Kind::kAll)
    return FieldError("scope", "must be a machine or a group: nobody looks after a routine of all machines");
  RETURN_IF_ERROR(RequireAccessName("principal", message.principal()));
  routine.principal = message.principal();
  RETURN_IF_ERROR(RequireMessage("sessions", message.sessions_size() > 0));
  std::set<std::string> seen;
  RETURN_IF_ERROR(ReadNames("sessions", message.sessions(), seen, routine.sessions));
  RETURN_IF_ERROR(ReadNames("check_sessions", message.check_sessions(), seen, routine.check_sessions));
  if (message.within_hours() < 0 || message.within_hours() > kMostHoursOfSet) {
    return FieldError("within_hours", absl::StrCat(message.within_hours(), ", must be 1 to ", kMostHoursOfSet,
                                                   ", or 0 for ", kDefaultHoursOfSet));
  }
  routine.within_hours = message.within_hours() == 0 ? kDefaultHoursOfSet : message.within_hours();
  if (message.has_at_utc_minute()) {
    if (message.at_utc_minute() < 0 || message.at_utc_minute() >= kMinutesOfDay) {
      return FieldError("at_utc_minute", absl::StrCat(message.at_utc_minute(), ", must be 0 to ", kMinutesOfDay - 1));
    }
    routine.at_utc_minute = message.at_utc_minute();
  }
  RETURN_IF_ERROR(ReadWork(message, routine));
  if (message.has_approve_within_um()) {
    const double um = message.approve_within_um();
    if (!(um > 0.0 && um <= kMostApprovedUm))
      return FieldError("approve_within_um", absl::StrCat(um, ", must be > 0 and at most ", kMostApprovedUm));
    routine.approve_within_um = um;
  }
  routine.is_enabled = !message.disabled();
  RETURN_IF_ERROR(RequireText("note", message.note(), 0, kMostNoteBytes));
  routine.note = message.note();
  return routine;
}

absl::StatusOr<records::RoutineRecord> RecordFromProto(const v1::Routine& message) {
  records::RoutineRecord record;
  ASSIGN_OR_RETURN(record.content, FromProto(message));
  record.etag = message.etag();
  record.created_by = message.created_by();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  record.changed_by = message.changed_by();
  record.changed_at = base::FromUtcUs(message.changed_utc_us());
  for (const v1::RoutineStop& stop : message.stops()) {
    record.stops.push_back({MachineId(stop.machine_id()), stop.by(), stop.note(), base::FromUtcUs(stop.at_utc_us())});
  }
  return record;
}

v1::RoutineRun ToProto(const records::RoutineRun& run) {
  v1::RoutineRun message;
  message.set_run_id(run.id.number());
  message.set_routine(run.routine);
  message.set_routine_etag(run.routine_etag);
  message.set_machine_id(run.machine.text());
  message.set_principal(run.principal);
  message.set_state(static_cast<v1::RoutineRunState>(run.state));
  for (const SessionId id : run.sessions) message.add_session_ids(id.number());
  for (const SessionId id : run.check_sessions) message.add_check_session_ids(id.number());
  if (run.job) message.set_job_id(run.job->number());
  if (run.calibration) message.set_calibration_id(run.calibration->number());
  message.set_text(run.text);
  message.set_began_utc_us(base::ToUtcUs(run.began_at));
  SET_OPTIONAL_UTC(message, ended_utc_us, run.ended_at);
  return message;
}

absl::StatusOr<records::RoutineRun> FromProto(const v1::RoutineRun& message) {
  records::RoutineRun run;
  RETURN_IF_ERROR(RequirePositive("run_id", message.run_id()));
  run.id = RunId(message.run_id());
  run.routine = message.routine();
  run.routine_etag = message.routine_etag();
  run.machine = MachineId(message.machine_id());
  run.principal = message.principal();
  run.state = static_cast<records::RunState>(message.state());
  for (const int64_t id : message.session_ids()) run.sessions.push_back(SessionId(id));
  for (const int64_t id : message.check_session_ids()) run.check_sessions.push_back(SessionId(id));
  if (message.has_job_id()) run.job = JobId(message.job_id());
  if (message.has_calibration_id()) run.calibration = CalibrationId(message.calibration_id());
  run.text = message.text();
  run.began_at = base::FromUtcUs(message.began_utc_us());
  run.ended_at = OPTIONAL_UTC(message, ended_utc_us);
  return run;
}

}  // namespace axiscal::convert
