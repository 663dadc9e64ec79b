#include "server/routines/keeper.h"

#include <algorithm>

#include "absl/strings/str_join.h"
#include "core/base/error_detail.h"
#include "proto/convert/job_params.h"
#include "server/inputs/calibration_use.h"
#include "server/inputs/job_inputs.h"
#include "server/routines/judge.h"

namespace axiscal::routines {
namespace {

using records::RoutineRecord;
using records::RoutineRun;
using records::RunState;

records::JobParams ParamsOf(const RoutineRun& run, const records::Routine& routine) {
  if (routine.work == records::RoutineWork::kLoop) {
    records::CloseLoopParams params;
    params.machine = run.machine;
    params.fit = run.sessions;
    params.check = run.check_sessions;
    params.max_effects = routine.max_effects;
    params.budget_json = routine.budget_json;
    params.monte_carlo_runs = routine.monte_carlo_runs;
    params.monte_carlo_seed = routine.monte_carlo_seed;
    return params;
  }
  records::IdentifyParams params;
  params.machine = run.machine;
  params.sessions = run.sessions;
  params.declared = routine.declared;
  params.budget_json = routine.budget_json;
  params.monte_carlo_runs = routine.monte_carlo_runs;
  params.monte_carlo_seed = routine.monte_carlo_seed;
  return params;
}

const records::RoutineStop* StopOn(const RoutineRecord& routine, const MachineId& machine) {
  const auto stop = std::find_if(routine.stops.begin(), routine.stops.end(),
                                 [&](const records::RoutineStop& one) { return one.machine == machine; });
  return stop == routine.stops.end() ? nullptr : &*stop;
}

// Why a routine does nothing on a machine; empty: it works.
std::string WhyStopped(const RoutineRecord* routine, const MachineId& machine) {
  if (routine == nullptr) return "the routine was removed, or works for this machine no more";
  if (!routine->content.is_enabled) return "the routine was disabled by " + routine->changed_by;
  const records::RoutineStop* const stop = StopOn(*routine, machine);
  if (stop == nullptr) return "";
  return absl::StrCat("the routine was stopped on this machine by ", stop->by,
                      stop->note.empty() ? "" : ": " + stop->note);
}

// The last time at or before `now` that it was this minute of a UTC day.
base::UtcTime LastAt(int utc_minute, base::UtcTime now) {
  const auto day = std::chrono::floor<std::chrono::days>(now);
  const base::UtcTime today = day + std::chrono::minutes(utc_minute);
  return today <= now ? today : today - std::chrono::days(1);
}

storage::Caller CallerOf(const RoutineRun& run, const std::string& request_id, const std::string& reason = "") {
  return {run.principal, request_id, "routine", reason};
}

std::string Sentence(const absl::Status& status) { return std::string(status.message()); }

}  // namespace

Keeper::Keeper(storage::Database& database, jobs::JobRunner& jobs, const access::Gate& gate, KeeperOptions options)
    : database_(database), jobs_(jobs), gate_(gate), options_(std::move(options)) {}

Keeper::~Keeper() { Stop(); }

void Keeper::Start() {
  thread_ = std::thread([this] { Loop(); });
}

void Keeper::Stop() {
  {
    const base::MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  if (thread_.joinable()) thread_.join();
}

void Keeper::LookSoon(const MachineId& machine) {
  const base::MutexLock lock(mutex_);
  due_.insert(machine);
  changed_.NotifyAll();
}

void Keeper::LookAtAllSoon() {
  const base::MutexLock lock(mutex_);
  all_due_ = true;
  changed_.NotifyAll();
}

void Keeper::Loop() {
  while (!stopping_) {
    if (GoesOn()) LookAtAll();
    const base::SteadyTime next = options_.clock->SteadyNow() + options_.every;
    bool is_all_due = false;
    while (!stopping_ && !is_all_due && options_.clock->SteadyNow() < next) {
      std::set<MachineId> due;
      {
        const base::MutexLock lock(mutex_);
        if (due_.empty() && !all_due_ && !stopping_) options_.clock->WaitUntil(changed_, mutex_, next);
        due.swap(due_);
        is_all_due = std::exchange(all_due_, false);
      }
      for (const MachineId& machine : due)
        if (GoesOn()) Look(machine);
    }
  }
}

void Keeper::LookAtAll() {
  const absl::StatusOr<std::vector<MachineId>> machines = database_.MachinesWithRoutines();
  if (!machines.ok()) {
    if (options_.tell) options_.tell(MachineId(), "", machines.status());
    return;
  }
  for (const MachineId& machine : *machines)
    if (GoesOn()) Look(machine);
}

void Keeper::Look(const MachineId& machine) {
  const auto tell = [&](const std::string& routine, const absl::Status& status) {
    if (!status.ok() && !stopping_ && options_.tell) options_.tell(machine, routine, status);
  };
  const absl::StatusOr<std::vector<RoutineRecord>> routines = database_.RoutinesOf(machine);
  tell("", routines.status());
  const absl::StatusOr<std::vector<RoutineRun>> runs = database_.NewestRuns(machine);
  tell("", runs.status());
  if (!routines.ok() || !runs.ok()) return;
  std::set<RoutineId> busy;
  for (const RoutineRun& run : *runs) {
    if (!records::IsOpen(run.state) || !GoesOn()) continue;
    busy.insert(run.routine_id);
    const auto routine = std::find_if(routines->begin(), routines->end(),
                                      [&](const RoutineRecord& one) { return one.id == run.routine_id; });
    tell(run.routine, Follow(run, routine == routines->end() ? nullptr : &*routine));
  }
  for (const RoutineRecord& routine : *routines) {
    if (!GoesOn() || busy.contains(routine.id) || !WhyStopped(&routine, machine).empty()) continue;
    tell(routine.content.name, Begin(routine, machine));
  }
}

absl::Status Keeper::Begin(const RoutineRecord& routine, const MachineId& machine) {
  std::vector<SessionId> sessions, check_sessions;
  std::optional<base::UtcTime> first, last, came;
  const auto find = [&](const std::vector<std::string>& names, std::vector<SessionId>& found) -> absl::StatusOr<bool> {
    for (const std::string& name : names) {
      ASSIGN_OR_RETURN(const std::optional<storage::NamedSession> session,
                       database_.NewSessionFor(routine.id, machine, name));
      if (!session) return false;
      found.push_back(session->id);
      first = std::min(first.value_or(session->measured_at), session->measured_at);
      last = std::max(last.value_or(session->measured_at), session->measured_at);
      came = std::max(came.value_or(session->came_at), session->came_at);
    }
    return true;
  };
  ASSIGN_OR_RETURN(const bool has_sessions, find(routine.content.sessions, sessions));
  if (!has_sessions) return absl::OkStatus();
  ASSIGN_OR_RETURN(const bool has_checks, find(routine.content.check_sessions, check_sessions));
  if (!has_checks || *last - *first > std::chrono::hours(routine.content.within_hours)) return absl::OkStatus();
  const std::optional<int>& at = routine.content.at_utc_minute;
  if (at && LastAt(*at, options_.clock->UtcNow()) < *came) return absl::OkStatus();
  const absl::StatusOr<RoutineRun> run = database_.BeginRun(routine, machine, sessions, check_sessions);
  // Changed meanwhile: the next look goes by what it is then. A machine that was deleted is none of its business.
  const std::string reason = base::ErrorReason(run.status());
  if (reason == "ETAG_MISMATCH" || reason == "ROUTINE_NOT_FOUND" || reason == "MACHINE_DELETED")
    return absl::OkStatus();
  RETURN_IF_ERROR(run.status());
  return Queue(*run, routine.content);
}

absl::Status Keeper::Queue(const RoutineRun& run, const records::Routine& routine) {
  const auto refused = [&](const absl::Status& status) {
    return MayPass(status) ? status : End(run, RunState::kFailed, Sentence(status));
  };
  std::vector<storage::Resource> named = {{storage::ResourceKind::kMachine, run.machine.text(), 0}};
  for (const auto* const list : {&run.sessions, &run.check_sessions})
    for (const SessionId id : *list) named.push_back({storage::ResourceKind::kSession, "", id.number()});
  if (const absl::Status may = gate_.MayStill(run.principal, "Jobs.CreateJob", named); !may.ok()) {
    if (MayPass(may)) return may;
    // What is outside every role of a principal is said not to exist.
    return End(run, RunState::kFailed,
               absl::StrCat("it acts as ", run.principal,
                            absl::IsNotFound(may) ? ", which has no role for this machine" : ": " + Sentence(may)));
  }
  const records::JobParams params = ParamsOf(run, routine);
  if (const absl::Status fits = inputs::CheckInputs(database_, params); !fits.ok()) return refused(fits);
  storage::NewJob job;
  job.kind = records::KindOf(params);
  job.machine = run.machine;
  job.params = convert::Serialize(params);
  // The same after a crash between the job and what is written down of it: there is one job.
  job.caller = CallerOf(run, absl::StrCat("routine-run-", run.id.number()));
  const absl::StatusOr<records::JobRecord> created = jobs_.Create(job);
  if (!created.ok()) return refused(created.status());
  return database_.ChangeRun({run.id, RunState::kRunning, created->id, {}, ""}).status();
}

absl::Status Keeper::Follow(const RoutineRun& run, const RoutineRecord* routine) {
  if (const std::string why = WhyStopped(routine, run.machine); !why.empty()) {
    if (run.job) RETURN_IF_ERROR(jobs_.Cancel(*run.job, CallerOf(run, "")).status());
    return End(run, RunState::kStopped, why);
  }
  if (run.state == RunState::kWaiting) return Queue(run, routine->content);
  ASSIGN_OR_RETURN(const records::JobRecord job, jobs_.Get(*run.job));
  const std::string name = absl::StrCat("job ", job.id.number());
  switch (job.state) {
    case records::JobState::kSucceeded:
      break;
    case records::JobState::kFailed:
    case records::JobState::kDead:
      return End(run, RunState::kFailed, name + ": " + (job.error ? job.error->message : "failed"));
    case records::JobState::kCancelled:
      return End(run, RunState::kStopped, name + " was cancelled");
    default:
      return absl::OkStatus();
  }
  if (!job.calibration) return End(run, RunState::kFailed, name + " made no calibration");
  const absl::StatusOr<records::CalibrationRecord> candidate = database_.GetCalibration(*job.calibration);
  if (!candidate.ok()) {
    if (MayPass(candidate.status())) return candidate.status();
    return End(run, RunState::kFailed, Sentence(candidate.status()), job.calibration);
  }
  return Conclude(run, routine->content, *candidate);
}

absl::StatusOr<std::string> Keeper::WhyNotApprove(const RoutineRun& run, const records::CalibrationRecord& candidate) {
  const storage::Resource calibration = {storage::ResourceKind::kCalibration, "", candidate.id.number()};
  ASSIGN_OR_RETURN(const storage::Belonging belonging, database_.WhereBelongs(calibration, run.principal));
  for (const records::MachineAccess& machine : belonging.machines)
    if (machine.four_eyes) return absl::StrCat("machine ", machine.machine.text(), " asks for the eyes of a person");
  for (const absl::Status& status : {gate_.MayStill(run.principal, "Calibrations.ApproveCalibration", {calibration}),
                                     inputs::CheckUsable(database_, candidate)}) {
    if (status.ok()) continue;
    if (MayPass(status)) return status;
    return Sentence(status);
  }
  return std::string();
}

absl::Status Keeper::Conclude(const RoutineRun& run, const records::Routine& routine,
                              const records::CalibrationRecord& candidate) {
  // A crash came between the approval and what is written down of it, or a person was faster.
  if (candidate.state == records::CalibrationState::kApproved)
    return End(run, RunState::kApproved, "approved by " + candidate.approved_by, candidate.id);
  if (candidate.state == records::CalibrationState::kRetired)
    return End(run, RunState::kProposed, "it was retired meanwhile", candidate.id);
  ASSIGN_OR_RETURN(Judgement judgement, options_.judge(database_, candidate));
  if (routine.approve_within_um) {
    if (judgement.largest_change_um && *judgement.largest_change_um > *routine.approve_within_um) {
      judgement.doubts.push_back(absl::StrFormat("the tool point moves by more than the %g um that it may approve",
                                                 *routine.approve_within_um));
    }
    const std::optional<double>& since_person_um = judgement.largest_change_since_person_um;
    if (since_person_um && *since_person_um > *routine.approve_within_um) {
      judgement.doubts.push_back(absl::StrFormat(
          "together with what routines have approved since a person did, it moves by more than the %g um",
          *routine.approve_within_um));
    }
    ASSIGN_OR_RETURN(const std::string why_not, WhyNotApprove(run, candidate));
    if (!why_not.empty()) judgement.doubts.push_back(why_not);
    if (judgement.doubts.empty()) {
      const std::string reason = absl::StrCat("routine ", routine.name, ", run ", run.id.number());
      // Where a person has put another one in use meanwhile this is ABORTED: it is judged again, against that one.
      const absl::StatusOr<records::CalibrationRecord> approved =
          database_.ApproveCalibration(candidate.id, candidate.etag, judgement.in_use, CallerOf(run, "", reason));
      RETURN_IF_ERROR(approved.status());
      return End(run, RunState::kApproved, judgement.text, candidate.id);
    }
  }
  std::string text = judgement.text;
  if (!judgement.doubts.empty()) {
    absl::StrAppend(
        &text, routine.approve_within_um ? "; not approved: " : "; look at: ", absl::StrJoin(judgement.doubts, "; "));
  }
  const bool is_news = !judgement.agrees || !judgement.doubts.empty();
  return End(run, is_news ? RunState::kProposed : RunState::kAgrees, text, candidate.id);
}

absl::Status Keeper::End(const RoutineRun& run, RunState state, const std::string& text,
                         const std::optional<CalibrationId>& calibration) {
  const absl::StatusOr<RoutineRun> ended = database_.ChangeRun({run.id, state, run.job, calibration, text});
  RETURN_IF_ERROR(ended.status());
  if (options_.ended) options_.ended(*ended);
  return absl::OkStatus();
}

}  // namespace axiscal::routines
