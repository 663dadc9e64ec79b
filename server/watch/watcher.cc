#include "server/watch/watcher.h"

#include <algorithm>

#include "server/inputs/machine_history.h"
#include "server/watch/conditions.h"
#include "server/watch/plan.h"

namespace axiscal::watch {
namespace {

using records::EventKind;

absl::Status ReadRoutines(storage::Database& database, const MachineId& machine, HistoryFacts& facts) {
  ASSIGN_OR_RETURN(const std::vector<records::RoutineRecord> routines, database.RoutinesOf(machine));
  if (routines.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<records::RoutineRun> newest, database.NewestRuns(machine));
  for (const records::RoutineRun& run : newest) {
    const auto works = [&](const records::RoutineRecord& routine) {
      const auto is_here = [&](const records::RoutineStop& stop) { return stop.machine == machine; };
      return routine.id == run.routine_id && routine.content.is_enabled &&
             std::none_of(routine.stops.begin(), routine.stops.end(), is_here);
    };
    if (std::any_of(routines.begin(), routines.end(), works)) facts.runs.push_back(run);
  }
  for (const records::RoutineRun& run : facts.runs) {
    if (run.state != records::RunState::kProposed || !run.calibration) continue;
    const absl::StatusOr<records::CalibrationRecord> record = database.GetCalibration(*run.calibration);
    // A damaged one cannot be approved: it waits for nobody.
    if (record.ok() && record->state == records::CalibrationState::kCandidate)
      facts.candidates.insert(*run.calibration);
  }
  return absl::OkStatus();
}

absl::Status ReadPeers(storage::Database& database, const MachineId& machine, HistoryFacts& facts) {
  ASSIGN_OR_RETURN(const storage::Belonging belonging,
                   database.WhereBelongs({storage::ResourceKind::kMachine, machine.text()}, ""));
  if (belonging.machines.empty()) return absl::OkStatus();
  for (const std::string& group : belonging.machines[0].groups) {
    const storage::Visible in_group = {false, {{records::Scope::Kind::kGroup, group}}, ""};
    records::PageRequest page;
    do {
      ASSIGN_OR_RETURN(records::Page<records::FleetRow> rows, database.LatestFleet({}, page, in_group));
      for (records::FleetRow& row : rows.rows)
        if (row.machine != machine && !row.latest.empty()) facts.peers[group].push_back(std::move(row));
      page.token = rows.next_token;
    } while (!page.token.empty());
  }
  return absl::OkStatus();
}

// The calibration in use, where it stands on what was rejected.
absl::Status ReadRejected(storage::Database& database, const MachineId& machine, HistoryFacts& facts) {
  records::CalibrationFilter approved;
  approved.machine = machine;
  approved.state = records::CalibrationState::kApproved;
  ASSIGN_OR_RETURN(const records::Page<records::CalibrationRecord> page, database.ListCalibrations(approved, {1, ""}));
  if (!page.rows.empty() && !page.rows[0].rejected_sessions.empty()) facts.on_rejected = page.rows[0];
  return absl::OkStatus();
}

absl::StatusOr<HistoryFacts> ReadHistory(storage::Database& database, const MachineId& machine, base::UtcTime now,
                                         const records::ExpectationsRecord& expected,
                                         const std::function<bool()>& is_cancelled) {
  HistoryFacts facts;
  facts.now = now;
  facts.expected = expected;
  RETURN_IF_ERROR(ReadRoutines(database, machine, facts));
  RETURN_IF_ERROR(ReadPeers(database, machine, facts));
  RETURN_IF_ERROR(ReadRejected(database, machine, facts));
  ASSIGN_OR_RETURN(facts.history,
                   inputs::FollowHistory(database, machine, expected.content.counts_candidates, is_cancelled));
  if (!facts.history.newest) return facts;
  const absl::StatusOr<records::CalibrationRecord> newest = database.GetCalibration(*facts.history.newest);
  if (!newest.ok()) return facts;  // a damaged one says nothing of the model; that it is damaged, others say
  absl::StatusOr<reports::CalibrationReport> report = reports::ReadCalibrationReport(newest->content.report_json);
  if (report.ok()) facts.newest_report = *std::move(report);
  return facts;
}

// The history with candidates counted; `counted` is what the machine is expected to hold to.
absl::StatusOr<inputs::MachineHistory> WithCandidates(storage::Database& database, const MachineId& machine,
                                                      const HistoryFacts& counted,
                                                      const std::function<bool()>& is_cancelled) {
  if (counted.expected.content.counts_candidates) return counted.history;
  records::CalibrationFilter candidates;
  candidates.machine = machine;
  candidates.state = records::CalibrationState::kCandidate;
  ASSIGN_OR_RETURN(const records::Page<records::CalibrationRecord> page,
                   database.ListCalibrations(candidates, {1, ""}));
  if (page.rows.empty()) return counted.history;
  return inputs::FollowHistory(database, machine, true, is_cancelled);
}

absl::StatusOr<TimeFacts> ReadTimes(storage::Database& database, const MachineId& machine, base::UtcTime now,
                                    const records::ExpectationsRecord& expected) {
  TimeFacts facts;
  facts.now = now;
  facts.expected = expected;
  records::CalibrationFilter approved;
  approved.machine = machine;
  approved.state = records::CalibrationState::kApproved;
  ASSIGN_OR_RETURN(const records::Page<records::CalibrationRecord> page, database.ListCalibrations(approved, {1, ""}));
  if (!page.rows.empty()) {
    facts.approved = page.rows[0].id;
    facts.approved_measured_at = page.rows[0].content.measured_at;
  }
  for (const records::ExpectedSession& session : expected.content.sessions) {
    ASSIGN_OR_RETURN(facts.newest_sessions[session.name], database.NewestSession(machine, session.name));
  }
  // More than a machine can have.
  ASSIGN_OR_RETURN(records::Page<records::CellRecord> cells, database.ListCells(machine, {1000, ""}, {}));
  facts.cells = std::move(cells.rows);
  return facts;
}

}  // namespace

Watcher::Watcher(storage::Database& database, std::shared_ptr<EventBoard> board, WatcherOptions options)
    : database_(database), board_(std::move(board)), options_(std::move(options)) {}

Watcher::~Watcher() { Stop(); }

void Watcher::Start() {
  {
    const base::MutexLock lock(mutex_);
    has_ended_ = false;
  }
  thread_ = std::thread([this] {
    Loop();
    const base::MutexLock lock(mutex_);
    has_ended_ = true;
    changed_.NotifyAll();
  });
}

void Watcher::Stop(std::chrono::milliseconds patience) {
  {
    const auto deadline = std::chrono::steady_clock::now() + patience;
    const base::MutexLock lock(mutex_);
    finishing_ = true;
    changed_.NotifyAll();
    while (!has_ended_ && std::chrono::steady_clock::now() < deadline) changed_.WaitUntil(mutex_, deadline);
    stopping_ = true;
    changed_.NotifyAll();
  }
  if (thread_.joinable()) thread_.join();
}

void Watcher::LookSoon(const MachineId& machine) {
  const base::MutexLock lock(mutex_);
  due_.insert(machine);
  changed_.NotifyAll();
}

absl::Status Watcher::Look(const MachineId& machine) {
  // Before all else: what changes while it is looked at is looked at again.
  ASSIGN_OR_RETURN(const storage::LookStand stand, database_.GetLookStand(machine));
  ASSIGN_OR_RETURN(const records::ExpectationsRecord expected, database_.GetExpectations(machine));
  const base::UtcTime now = options_.clock->UtcNow();
  std::set<EventKind> kinds(std::begin(kOfTime), std::end(kOfTime));
  ASSIGN_OR_RETURN(const TimeFacts times, ReadTimes(database_, machine, now, expected));
  std::vector<Condition> conditions = ConditionsOf(times);
  const bool has_changed = stand.changes != stand.looked_at || stand.looked_by != options_.version;
  std::vector<storage::StandingFinding> findings;
  if (has_changed) {
    kinds.insert(std::begin(kOfHistory), std::end(kOfHistory));
    const auto is_cancelled = [this] { return stopping_.load(); };
    ASSIGN_OR_RETURN(const HistoryFacts facts, ReadHistory(database_, machine, now, expected, is_cancelled));
    ASSIGN_OR_RETURN(const inputs::MachineHistory all, WithCandidates(database_, machine, facts, is_cancelled));
    findings = StandingFindings(all, times.approved_measured_at);
    for (Condition& condition : ConditionsOf(facts)) conditions.push_back(std::move(condition));
  }
  ASSIGN_OR_RETURN(const std::vector<records::Event> standing, database_.StandingEvents(machine));
  storage::EventChanges changes = PlanChanges(machine, kinds, standing, conditions);
  if (has_changed) {
    changes.looked_at = stand.changes;
    changes.looked_by = options_.version;
    changes.findings = std::move(findings);
  }
  if (changes.empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const int count, database_.ChangeEvents(changes));
  if (count > 0) board_->Tell();
  return absl::OkStatus();
}

void Watcher::LookAtAll() {
  const auto tell = [this](const MachineId& machine, const absl::Status& status) {
    if (!status.ok() && !stopping_ && options_.tell) options_.tell(machine, status);
  };
  const absl::StatusOr<int> back = database_.BringBackEvents();
  tell(MachineId(), back.status());
  if (back.ok() && *back > 0) board_->Tell();
  const absl::StatusOr<std::vector<MachineId>> machines = database_.MachinesToLookAt(options_.version);
  tell(MachineId(), machines.status());
  if (!machines.ok()) return;
  for (const MachineId& machine : *machines) {
    if (finishing_ || !IsMine()) return;
    tell(machine, Look(machine));  // one that cannot be looked at hides none of the others
  }
}

void Watcher::LookAtDue() {
  std::set<MachineId> due;
  {
    const base::MutexLock lock(mutex_);
    due.swap(due_);
  }
  for (const MachineId& machine : due) {
    if (stopping_ || !IsMine()) return;
    const absl::Status status = Look(machine);
    if (!status.ok() && !stopping_ && options_.tell) options_.tell(machine, status);
  }
}

void Watcher::Loop() {
  while (!finishing_) {
    if (IsMine()) LookAtAll();
    const base::SteadyTime next = options_.clock->SteadyNow() + options_.every;
    while (!finishing_ && options_.clock->SteadyNow() < next) {
      LookAtDue();
      const base::MutexLock lock(mutex_);
      if (due_.empty() && !finishing_) options_.clock->WaitUntil(changed_, mutex_, next);
    }
  }
  LookAtDue();
}

}  // namespace axiscal::watch
