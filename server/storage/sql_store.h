// The Database on an engine that takes SQL: each call is a function of connection and request, given to the writer's
// thread or to a reader. Used through OpenSqlite() and OpenPostgres() alone.
#ifndef AXISCAL_SERVER_STORAGE_SQL_STORE_H_
#define AXISCAL_SERVER_STORAGE_SQL_STORE_H_

#include <atomic>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "core/base/clock.h"
#include "core/base/mutex.h"
#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/calibrations.h"
#include "server/storage/care.h"
#include "server/storage/cells.h"
#include "server/storage/chunks.h"
#include "server/storage/database.h"
#include "server/storage/engine.h"
#include "server/storage/events.h"
#include "server/storage/handed_tables.h"
#include "server/storage/history.h"
#include "server/storage/job_owner.h"
#include "server/storage/jobs.h"
#include "server/storage/machines.h"
#include "server/storage/marks.h"
#include "server/storage/programs.h"
#include "server/storage/readers.h"
#include "server/storage/routine_runs.h"
#include "server/storage/routines.h"
#include "server/storage/session_remarks.h"
#include "server/storage/sessions.h"
#include "server/storage/up_time.h"
#include "server/storage/webhooks.h"
#include "server/storage/writer.h"

namespace axiscal::storage {

struct StoreOptions {
  // As SqliteOptions and PostgresOptions say. May be empty.
  std::function<void(const JobRecord&)> rescued;
  std::function<void(const absl::Status&)> damaged;
  base::Clock* clock = &base::SystemClock();
};

// Whether a write adds to the disk (refused when it runs low) or ends, changes and cleans up (always let through).
enum class Growth { kGrows, kStays };

class SqlStore final : public Database {
 public:
  // `connection`, the one that writes, has the present schema.
  static absl::StatusOr<std::unique_ptr<Database>> Open(const StoreOptions& options, std::unique_ptr<Engine> engine,
                                                        std::unique_ptr<Connection> connection);
  ~SqlStore() override {
    StopFollowing();
    // What fails here is lost as after a crash: a little of the time that is counted.
    static_cast<void>(writer_.Run([&](Connection& c) { return SaveUpTime(c, UpTime()); }));
  }

  // ---- machines
  absl::StatusOr<MachineRecord> CreateMachine(const MachineId& id, const std::string& description_json,
                                              const Caller& caller) override {
    return Write<MachineRecord>(
        Growth::kGrows, [&](Connection& c) { return storage::CreateMachine(c, Now(), id, description_json, caller); });
  }
  absl::StatusOr<MachineRecord> GetMachine(const MachineId& id) override {
    return readers_.Run([&](Connection& c) { return storage::GetMachine(c, id); });
  }
  absl::StatusOr<MachineRecord> GetMachineRevision(const MachineId& id, int64_t revision) override {
    return readers_.Run([&](Connection& c) { return storage::GetMachineRevision(c, id, revision); });
  }
  absl::StatusOr<MachineRecord> UpdateMachine(const MachineId& id, int64_t expected_revision,
                                              const std::string& description_json, const Caller& caller) override {
    return Write<MachineRecord>(Growth::kGrows, [&](Connection& c) {
      return storage::UpdateMachine(c, Now(), id, expected_revision, description_json, caller);
    });
  }
  absl::StatusOr<MachineRecord> DeleteMachine(const MachineId& id, int64_t expected_revision,
                                              const Caller& caller) override {
    return Write<MachineRecord>(
        Growth::kStays, [&](Connection& c) { return storage::DeleteMachine(c, Now(), id, expected_revision, caller); });
  }
  absl::StatusOr<Page<MachineRecord>> ListMachines(const PageRequest& page, const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListMachines(c, page, visible); });
  }

  // ---- sessions
  absl::StatusOr<SessionRecord> CreateSession(const NewSession& session) override;
  absl::StatusOr<SessionRecord> GetSession(SessionId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetSession(c, id); });
  }
  absl::StatusOr<Page<SessionRecord>> ListSessions(const SessionFilter& filter, const PageRequest& page,
                                                   const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListSessions(c, filter, page, visible); });
  }
  absl::StatusOr<AppendResult> AppendChunk(SessionId id, const records::Chunk& chunk) override;
  void AppendChunkAsync(SessionId id, const records::Chunk& chunk,
                        std::function<void(absl::StatusOr<AppendResult>)> done) override;
  absl::StatusOr<SessionRecord> FinishSession(SessionId id, const SessionTotals& totals) override {
    return Write<SessionRecord>(Growth::kStays,
                                [&](Connection& c) { return storage::FinishSession(c, Now(), id, totals); });
  }
  absl::StatusOr<SessionRecord> AbortSession(SessionId id) override {
    return Write<SessionRecord>(Growth::kStays, [&](Connection& c) { return storage::AbortSession(c, Now(), id); });
  }
  absl::StatusOr<SessionRecord> AnnotateSession(SessionId id, const std::string& note,
                                                const std::vector<std::string>& labels, int64_t expected_etag,
                                                const Caller& caller) override {
    return Write<SessionRecord>(Growth::kGrows, [&](Connection& c) {
      return storage::AnnotateSession(c, Now(), id, note, labels, expected_etag, caller);
    });
  }
  absl::StatusOr<RejectedSession> RejectSession(SessionId id, bool is_rejected, const std::string& reason,
                                                const Caller& caller) override {
    return Write<RejectedSession>(Growth::kGrows, [&](Connection& c) {
      return storage::RejectSession(c, Now(), id, is_rejected, reason, caller);
    });
  }
  absl::StatusOr<int> ExpireSessions(std::chrono::microseconds idle) override {
    return Expire([&](Connection& c) { return storage::ExpireSessions(c, Present(), idle); });
  }
  absl::StatusOr<int> ExpireReadings(std::chrono::microseconds age) override;
  absl::StatusOr<session::Session> ReadSession(SessionId id) override;
  absl::Status ReadChunks(SessionId id, int64_t first_seq,
                          const std::function<absl::Status(const records::Chunk&)>& visit) override;

  // ---- jobs
  absl::StatusOr<JobRecord> CreateJob(const NewJob& job, const JobRoom& room) override {
    return Write<JobRecord>(Growth::kGrows, [&](Connection& c) {
      return Told(c, kJobsChanged, storage::CreateJob(c, Present(), job, room));
    });
  }
  absl::StatusOr<JobRecord> GetJob(JobId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetJob(c, id); });
  }
  absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter, const PageRequest& page,
                                           const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListJobs(c, filter, page, visible); });
  }
  absl::StatusOr<std::optional<JobRecord>> ClaimJob(std::chrono::microseconds lease) override;
  absl::StatusOr<std::optional<std::chrono::microseconds>> NextJobWait() override {
    return readers_.Run([&](Connection& c) { return storage::NextJobWait(c, Present()); });
  }
  absl::StatusOr<std::vector<std::pair<JobId, int64_t>>> JobVersions(const std::vector<JobId>& ids) override {
    return readers_.Run([&](Connection& c) { return storage::JobVersions(c, ids); });
  }
  absl::StatusOr<JobQueue> CountJobs() override {
    return readers_.Run([](Connection& c) { return storage::CountJobs(c); });
  }
  absl::StatusOr<JobRecord> HeartbeatJob(const JobClaim& claim, std::chrono::microseconds lease,
                                         const JobProgress& progress) override {
    return Write<JobRecord>(Growth::kStays, [&](Connection& c) {
      return Told(c, kJobsChanged, storage::HeartbeatJob(c, Owner(c), claim, lease, progress));
    });
  }
  absl::StatusOr<JobRecord> SucceedJob(const JobClaim& claim, const JobProduct& product) override {
    return Write<JobRecord>(Growth::kStays, [&](Connection& c) {
      return Told(c, kJobsChanged, storage::SucceedJob(c, Owner(c), claim, product));
    });
  }
  absl::StatusOr<JobRecord> EndJob(const JobClaim& claim, JobEnd end, const JobError& error,
                                   std::chrono::microseconds retry_after) override {
    return Write<JobRecord>(Growth::kStays, [&](Connection& c) {
      return Told(c, kJobsChanged, storage::EndJob(c, Owner(c), claim, end, error, retry_after));
    });
  }
  absl::StatusOr<JobRecord> CancelJob(JobId id, const Caller& caller) override {
    return Write<JobRecord>(
        Growth::kStays, [&](Connection& c) { return Told(c, kJobsChanged, storage::CancelJob(c, Now(), id, caller)); });
  }
  absl::StatusOr<JobRecord> RequeueJob(JobId id, const JobRoom& room, const Caller& caller) override {
    return Write<JobRecord>(Growth::kStays, [&](Connection& c) {
      return Told(c, kJobsChanged, storage::RequeueJob(c, Present(), id, room, caller));
    });
  }
  absl::StatusOr<std::vector<JobRecord>> RescueJobs() override {
    return Write<std::vector<JobRecord>>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<std::vector<JobRecord>> {
      // By the time of all processes.
      if (engine_->is_shared()) RETURN_IF_ERROR(FallInStep(c));
      auto rescued = storage::RescueJobs(c, Owner(c));
      if (!rescued.ok() || rescued->empty()) return rescued;
      return Told(c, kJobsChanged, std::move(rescued));
    });
  }
  absl::StatusOr<std::vector<JobRecord>> ReturnJobs(const std::vector<JobClaim>& held) override {
    return Write<std::vector<JobRecord>>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<std::vector<JobRecord>> {
      auto returned = storage::ReturnJobs(c, Owner(c), held);
      if (!returned.ok() || returned->empty()) return returned;
      return Told(c, kJobsChanged, std::move(returned));
    });
  }

  // ---- calibrations
  absl::StatusOr<CalibrationRecord> CreateCalibration(const NewCalibration& calibration) override {
    return Write<CalibrationRecord>(
        Growth::kGrows, [&](Connection& c) { return storage::CreateCalibration(c, Now(), calibration, std::nullopt); });
  }
  absl::StatusOr<CalibrationRecord> GetCalibration(CalibrationId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetCalibration(c, id); });
  }
  absl::StatusOr<std::vector<records::Decision>> ListDecisions(CalibrationId id, int limit) override {
    return readers_.Run([&](Connection& c) { return storage::ListDecisions(c, id, limit); });
  }
  absl::StatusOr<CalibrationRecord> GetApprovedCalibration(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::GetApprovedCalibration(c, machine); });
  }
  absl::StatusOr<CalibrationRecord> GetApprovedByPerson(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::GetApprovedByPerson(c, machine); });
  }
  absl::StatusOr<std::optional<CalibrationId>> GetFormerOf(CalibrationId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetFormerOf(c, id); });
  }
  absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter, const PageRequest& page,
                                                           const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListCalibrations(c, filter, page, visible); });
  }
  absl::StatusOr<CalibrationRecord> ApproveCalibration(CalibrationId id, int64_t expected_etag,
                                                       std::optional<CalibrationId> former,
                                                       const Caller& caller) override {
    return Write<CalibrationRecord>(Growth::kStays, [&](Connection& c) {
      return storage::ApproveCalibration(c, Now(), id, expected_etag, former, caller);
    });
  }
  absl::StatusOr<CalibrationRecord> RetireCalibration(CalibrationId id, int64_t expected_etag,
                                                      const Caller& caller) override {
    return Write<CalibrationRecord>(
        Growth::kStays, [&](Connection& c) { return storage::RetireCalibration(c, Now(), id, expected_etag, caller); });
  }

  // ---- history
  absl::StatusOr<std::vector<DriftSeries>> QueryDrift(const DriftQuery& query) override {
    return readers_.Run([&](Connection& c) { return storage::QueryDrift(c, query, ToldOnce()); });
  }
  absl::StatusOr<Page<FleetRow>> LatestFleet(const std::vector<std::string>& symbols, const PageRequest& page,
                                             const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::LatestFleet(c, symbols, page, visible, ToldOnce()); });
  }

  // ---- programs
  absl::StatusOr<ProgramRecord> BeginProgram(const NewProgram& program) override;
  absl::StatusOr<ProgramRecord> AppendProgram(ProgramId id, int64_t offset, const std::string& bytes) override {
    ASSIGN_OR_RETURN(const EncodedPart part, PreparePart(offset, bytes));
    return Write<ProgramRecord>(Growth::kGrows,
                                [&](Connection& c) { return storage::AppendProgram(c, Present(), id, part); });
  }
  absl::StatusOr<ProgramRecord> FinishProgram(ProgramId id, int64_t byte_count, const std::string& sha256) override;
  absl::StatusOr<ProgramRecord> GetProgram(ProgramId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetProgram(c, id); });
  }
  absl::StatusOr<Page<ProgramRecord>> ListPrograms(const ProgramFilter& filter, const PageRequest& page,
                                                   const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListPrograms(c, filter, page, visible); });
  }
  absl::Status ReadProgram(ProgramId id, int64_t offset,
                           const std::function<absl::Status(const std::string& bytes)>& visit) override;
  absl::StatusOr<int> ExpirePrograms(std::chrono::microseconds idle) override {
    return Expire([&](Connection& c) { return storage::ExpirePrograms(c, Present(), idle); });
  }

  // ---- access
  absl::StatusOr<PrincipalRecord> CreatePrincipal(const std::string& name, const std::string& note,
                                                  const Caller& caller) override {
    return Write<PrincipalRecord>(
        Growth::kGrows, [&](Connection& c) { return storage::CreatePrincipal(c, Now(), name, note, caller); });
  }
  absl::StatusOr<PrincipalRecord> RevokePrincipal(const std::string& name, const Caller& caller) override {
    return Write<PrincipalRecord>(Growth::kStays,
                                  [&](Connection& c) { return storage::RevokePrincipal(c, Now(), name, caller); });
  }
  absl::StatusOr<Page<PrincipalRecord>> ListPrincipals(const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListPrincipals(c, page); });
  }
  absl::StatusOr<TokenRecord> CreateToken(const NewToken& token, const Caller& caller) override {
    return Write<TokenRecord>(Growth::kGrows,
                              [&](Connection& c) { return storage::CreateToken(c, Now(), token, caller); });
  }
  absl::StatusOr<TokenRecord> RevokeToken(int64_t id, const Caller& caller) override {
    return Write<TokenRecord>(Growth::kStays,
                              [&](Connection& c) { return storage::RevokeToken(c, Now(), id, caller); });
  }
  absl::Status TouchToken(int64_t id) override {
    return writer_.Run([&](Connection& c) { return storage::TouchToken(c, Now(), id); });
  }
  absl::StatusOr<PrincipalRecord> ChangeRole(const std::string& principal, const Grant& grant, bool holds,
                                             const Caller& caller) override {
    return Write<PrincipalRecord>(
        Growth::kStays, [&](Connection& c) { return storage::ChangeRole(c, Now(), principal, grant, holds, caller); });
  }
  absl::StatusOr<MachineAccess> ChangeGroup(const std::string& group, const MachineId& machine, bool belongs,
                                            const Caller& caller) override {
    return Write<MachineAccess>(
        Growth::kStays, [&](Connection& c) { return storage::ChangeGroup(c, Now(), group, machine, belongs, caller); });
  }
  absl::StatusOr<MachineAccess> SetFourEyes(const MachineId& machine, bool four_eyes, const Caller& caller) override {
    return Write<MachineAccess>(
        Growth::kStays, [&](Connection& c) { return storage::SetFourEyes(c, Now(), machine, four_eyes, caller); });
  }
  absl::StatusOr<Page<MachineAccess>> ListMachineAccess(const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListMachineAccess(c, page); });
  }
  absl::StatusOr<std::optional<Holder>> FindHolderOfToken(const std::string& sha256) override {
    return readers_.Run([&](Connection& c) { return storage::FindHolderOfToken(c, sha256); });
  }
  absl::StatusOr<std::optional<Holder>> FindHolderOfName(const std::string& name) override {
    return readers_.Run([&](Connection& c) { return storage::FindHolderOfName(c, name); });
  }
  absl::StatusOr<Belonging> WhereBelongs(const Resource& resource, const std::string& principal) override {
    return readers_.Run([&](Connection& c) { return storage::WhereBelongs(c, resource, principal); });
  }

  // ---- compensation tables that controls may have
  absl::Status NoteHandedTable(CalibrationId calibration, const std::string& format, const Caller& caller) override {
    return writer_.Run([&](Connection& c) { return storage::NoteHandedTable(c, Now(), calibration, format, caller); });
  }
  absl::StatusOr<std::vector<HandedTable>> ListHandedTables(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::ListHandedTables(c, machine); });
  }

  // ---- cells
  absl::StatusOr<CellRecord> ReportCell(const CellReport& report, const Caller& caller) override {
    // Of the same size each time: a disk that runs low does not make cells silent.
    return Write<CellRecord>(Growth::kStays,
                             [&](Connection& c) { return storage::ReportCell(c, Present(), report, caller); });
  }
  absl::StatusOr<Page<CellRecord>> ListCells(const std::optional<MachineId>& machine, const PageRequest& page,
                                             const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListCells(c, Present(), machine, page, visible); });
  }
  absl::Status ForgetCell(const MachineId& machine, const std::string& name, const Caller& caller) override {
    return writer_.Run([&](Connection& c) { return storage::ForgetCell(c, Present(), machine, name, caller); });
  }
  absl::StatusOr<CellSums> SumCells() override {
    return readers_.Run([&](Connection& c) { return storage::SumCells(c, Present()); });
  }

  // ---- marks
  absl::StatusOr<Mark> PutMark(const NewMark& mark, const Caller& caller) override {
    return Write<Mark>(Growth::kGrows, [&](Connection& c) { return storage::PutMark(c, Now(), mark, caller); });
  }
  absl::StatusOr<Mark> WithdrawMark(MarkId id, const Caller& caller) override {
    return Write<Mark>(Growth::kStays, [&](Connection& c) { return storage::WithdrawMark(c, Now(), id, caller); });
  }
  absl::StatusOr<Page<Mark>> ListMarks(const MachineId& machine, const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListMarks(c, machine, page); });
  }

  // ---- events
  absl::StatusOr<ExpectationsRecord> GetExpectations(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::GetExpectations(c, machine); });
  }
  absl::StatusOr<ExpectationsRecord> SetExpectations(const Expectations& expected, int64_t expected_etag,
                                                     const Caller& caller) override {
    return Write<ExpectationsRecord>(Growth::kGrows, [&](Connection& c) {
      return storage::SetExpectations(c, Now(), expected, expected_etag, caller);
    });
  }
  absl::StatusOr<Event> GetEvent(EventId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetEvent(c, id); });
  }
  absl::StatusOr<Page<Event>> ListEvents(const EventFilter& filter, const PageRequest& page,
                                         const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListEvents(c, filter, page, visible); });
  }
  absl::StatusOr<std::vector<Event>> StandingEvents(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::StandingEvents(c, machine); });
  }
  absl::StatusOr<Event> AcknowledgeEvent(EventId id, const std::string& note, const Caller& caller) override {
    return Write<Event>(Growth::kStays, [&](Connection& c) {
      return Told(c, kEventsChanged, storage::AcknowledgeEvent(c, Now(), id, note, caller));
    });
  }
  absl::StatusOr<Event> ShelveEvent(EventId id, std::optional<UtcTime> until, const std::string& note,
                                    const Caller& caller) override {
    return Write<Event>(Growth::kStays, [&](Connection& c) {
      return Told(c, kEventsChanged, storage::ShelveEvent(c, Now(), id, until, note, caller));
    });
  }
  absl::StatusOr<int> BringBackEvents() override {
    // Whether there is one is read first: most of the time there is none, and a write waits for the disk.
    ASSIGN_OR_RETURN(const bool is_due,
                     readers_.Run([&](Connection& c) { return storage::HasEventToBringBack(c, Now()); }));
    if (!is_due) return 0;
    return Write<int>(Growth::kStays,
                      [&](Connection& c) { return Told(c, kEventsChanged, storage::BringBackEvents(c, Now())); });
  }
  absl::StatusOr<int> ChangeEvents(const EventChanges& changes) override {
    return Write<int>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<int> {
      absl::StatusOr<int> count = storage::ChangeEvents(c, Now(), changes);
      if (!count.ok() || *count == 0) return count;
      return Told(c, kEventsChanged, std::move(count));
    });
  }
  absl::StatusOr<EventChangePage> ReadEventChanges(int64_t after, const std::optional<MachineId>& machine,
                                                   const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ReadEventChanges(c, after, machine, visible); });
  }
  absl::StatusOr<int64_t> LastEventChange() override {
    return readers_.Run([](Connection& c) { return storage::LastEventChange(c); });
  }
  absl::StatusOr<LookStand> GetLookStand(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::GetLookStand(c, machine); });
  }
  absl::StatusOr<Page<MachineCare>> ListCare(const PageRequest& page, const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListCare(c, Now(), page, visible); });
  }
  absl::StatusOr<std::vector<MachineId>> MachinesToLookAt(const std::string& version) override {
    return readers_.Run([&](Connection& c) { return storage::MachinesToLookAt(c, version); });
  }
  absl::StatusOr<std::optional<UtcTime>> NewestSession(const MachineId& machine, const std::string& name) override {
    return readers_.Run([&](Connection& c) { return storage::NewestSession(c, machine, name); });
  }

  // ---- routines
  absl::StatusOr<RoutineRecord> PutRoutine(const Routine& routine, int64_t expected_etag,
                                           const Caller& caller) override {
    return Write<RoutineRecord>(
        Growth::kGrows, [&](Connection& c) { return storage::PutRoutine(c, Now(), routine, expected_etag, caller); });
  }
  absl::StatusOr<RoutineRecord> RemoveRoutine(const std::string& name, int64_t expected_etag,
                                              const Caller& caller) override {
    return Write<RoutineRecord>(
        Growth::kStays, [&](Connection& c) { return storage::RemoveRoutine(c, Now(), name, expected_etag, caller); });
  }
  absl::StatusOr<RoutineRecord> StopRoutine(const std::string& name, const MachineId& machine, bool stops,
                                            const std::string& note, const Caller& caller) override {
    return Write<RoutineRecord>(Growth::kStays, [&](Connection& c) {
      return storage::StopRoutine(c, Now(), name, machine, stops, note, caller);
    });
  }
  absl::StatusOr<std::vector<RoutineRecord>> ListRoutines(const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListRoutines(c, visible); });
  }
  absl::StatusOr<std::vector<MachineId>> MachinesWithRoutines() override {
    return readers_.Run([](Connection& c) { return storage::MachinesWithRoutines(c); });
  }
  absl::StatusOr<std::vector<RoutineRecord>> RoutinesOf(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::RoutinesOf(c, machine); });
  }
  absl::StatusOr<std::vector<RoutineRun>> NewestRuns(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::NewestRuns(c, machine); });
  }
  absl::StatusOr<std::optional<NamedSession>> NewSessionFor(RoutineId routine, const MachineId& machine,
                                                            const std::string& name) override {
    return readers_.Run([&](Connection& c) { return storage::NewSessionFor(c, routine, machine, name); });
  }
  absl::StatusOr<RoutineRun> BeginRun(const RoutineRecord& routine, const MachineId& machine,
                                      const std::vector<SessionId>& sessions,
                                      const std::vector<SessionId>& check_sessions) override {
    return Write<RoutineRun>(Growth::kGrows, [&](Connection& c) {
      return storage::BeginRun(c, Now(), routine, machine, sessions, check_sessions);
    });
  }
  absl::StatusOr<RoutineRun> ChangeRun(const RunChange& change) override {
    return Write<RoutineRun>(Growth::kStays, [&](Connection& c) { return storage::ChangeRun(c, Now(), change); });
  }
  absl::StatusOr<RoutineRun> RetryRoutine(const std::string& name, const MachineId& machine,
                                          const Caller& caller) override {
    return Write<RoutineRun>(Growth::kGrows,
                             [&](Connection& c) { return storage::RetryRoutine(c, Now(), name, machine, caller); });
  }
  absl::StatusOr<Page<RoutineRun>> ListRuns(const RunFilter& filter, const PageRequest& page,
                                            const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListRuns(c, filter, page, visible); });
  }

  // ---- webhooks
  absl::StatusOr<WebhookRecord> PutWebhook(const Webhook& webhook, const NewSecret& secret, int64_t expected_etag,
                                           const Caller& caller) override {
    return Write<WebhookRecord>(Growth::kGrows, [&](Connection& c) {
      return Told(c, kEventsChanged, storage::PutWebhook(c, Now(), webhook, secret, expected_etag, caller));
    });
  }
  absl::StatusOr<WebhookRecord> RemoveWebhook(const std::string& name, int64_t expected_etag,
                                              const Caller& caller) override {
    return Write<WebhookRecord>(
        Growth::kStays, [&](Connection& c) { return storage::RemoveWebhook(c, Now(), name, expected_etag, caller); });
  }
  absl::StatusOr<WebhookRecord> GetWebhook(const std::string& name) override {
    return readers_.Run([&](Connection& c) { return storage::GetWebhook(c, name); });
  }
  absl::StatusOr<std::vector<WebhookRecord>> ListWebhooks() override {
    return readers_.Run([&](Connection& c) { return storage::ListWebhooks(c); });
  }
  absl::StatusOr<bool> StepWebhook(const WebhookStep& step) override {
    return Write<bool>(Growth::kStays, [&](Connection& c) { return storage::StepWebhook(c, Now(), step); });
  }
  absl::StatusOr<Page<DeadLetter>> ListDeadLetters(const std::string& name, const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListDeadLetters(c, name, page); });
  }
  absl::StatusOr<int64_t> ResendDeadLetters(const std::string& name, std::optional<int64_t> change,
                                            const Caller& caller) override {
    return Write<int64_t>(Growth::kStays, [&](Connection& c) {
      return Told(c, kEventsChanged, storage::ResendDeadLetters(c, Now(), name, change, caller));
    });
  }
  absl::StatusOr<std::optional<EventChange>> WantedLetter(WebhookId webhook) override {
    return readers_.Run([&](Connection& c) { return storage::WantedLetter(c, webhook); });
  }
  absl::StatusOr<bool> EndWantedLetter(WebhookId webhook, int64_t change, const std::string& error) override {
    return Write<bool>(Growth::kStays,
                       [&](Connection& c) { return storage::EndWantedLetter(c, Now(), webhook, change, error); });
  }

  // ---- audit
  absl::Status AppendAudit(const AuditEntry& entry) override {
    return writer_.Run([&](Connection& c) { return storage::AppendAudit(c, entry); });
  }
  absl::StatusOr<Page<AuditEntry>> ListAudit(const AuditFilter& filter, const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListAudit(c, filter, page); });
  }
  absl::StatusOr<AuditHead> CheckAudit() override {
    return readers_.Run([](Connection& c) { return storage::CheckAudit(c); });
  }
  absl::StatusOr<int> ExpireAudit(std::chrono::microseconds age) override {
    return Expire([&](Connection& c) { return storage::ExpireAudit(c, Present(), age); });
  }

  absl::StatusOr<BackupResult> Backup(const std::string& path, const std::function<absl::Status()>& go_on) override {
    return engine_->Backup(path, go_on);
  }

  // What it writes is of use, too: how long the file was open.
  absl::Status TryWrite() override {
    return writer_.Run([&](Connection& c) { return SaveUpTime(c, UpTime()); });
  }
  absl::Status TryReadAnew() override {
    ASSIGN_OR_RETURN(const std::unique_ptr<Connection> connection, engine_->OpenReader());
    ASSIGN_OR_RETURN(Statement row, connection->Ask("SELECT up_us FROM up_time WHERE id = 1"));
    return row.Step().status();
  }
  absl::StatusOr<std::vector<std::pair<MachineId, int64_t>>> MachinesWithEvents(int most) override {
    return readers_.Run([&](Connection& c) { return storage::MachinesWithEvents(c, most); });
  }

  // ---- several processes
  bool is_shared() const override { return engine_->is_shared(); }
  void Follow(std::function<void(const News&)> heard) override;
  void StopFollowing() override;
  bool IsCaretaker() override;
  void TellOthers(const std::optional<MachineId>& machine) override;

  int schema_version() const override { return engine_->schema_version(); }

 private:
  using SharedSpecs = std::shared_ptr<const std::vector<ColumnSpec>>;

  SqlStore(const StoreOptions& options, std::chrono::microseconds up, std::unique_ptr<Engine> engine,
           std::unique_ptr<Connection> connection)
      : engine_(std::move(engine)),
        options_(options),
        up_at_open_(up),
        opened_at_(options.clock->SteadyNow()),
        owner_id_(NewOwnerId()),
        readers_([this] { return engine_->OpenReader(); }),
        writer_(std::move(connection), [this] { engine_->Between(); }) {}
  UtcTime Now() const { return options_.clock->UtcNow(); }
  std::chrono::microseconds UpTime() const {
    const auto here = options_.clock->SteadyNow() - opened_at_;
    return up_at_open_ + std::chrono::duration_cast<std::chrono::microseconds>(here) +
           std::chrono::microseconds(up_of_others_us_);
  }
  Moment Present() const { return {Now(), UpTime().count()}; }
  absl::StatusOr<std::vector<JobRecord>> RescueJobsOnOpen() {
    return Write<std::vector<JobRecord>>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<std::vector<JobRecord>> {
      if (engine_->is_shared()) RETURN_IF_ERROR(FallInStep(c));
      if (c.has_others()) return std::vector<JobRecord>();
      return storage::RescueJobs(c, Owner(c));
    });
  }
  // On the connection for claims, which is there.
  absl::StatusOr<std::optional<JobRecord>> ClaimBeside(std::chrono::microseconds lease) AXISCAL_REQUIRES(claims_mutex_);
  JobOwner Owner(const Connection& connection) const {
    const auto steady = options_.clock->SteadyNow().time_since_epoch();
    const Moment now = Present();
    // One process's steady clock is not another's.
    const int64_t lease_now_us =
        engine_->is_shared() ? now.up_us : std::chrono::duration_cast<std::chrono::microseconds>(steady).count();
    return {owner_id_, now, lease_now_us, !connection.has_others()};
  }
  // Words of Connection::Tell().
  static constexpr char kJobsChanged[] = "jobs", kEventsChanged[] = "events", kRoutinesChanged[] = "routines";
  static constexpr char kLookAt[] = "look ";  // and a machine
  // What a write gives, told to the other processes where it is OK.
  template <typename T>
  static absl::StatusOr<T> Told(Connection& connection, const std::string& what, absl::StatusOr<T> made) {
    if (made.ok()) RETURN_IF_ERROR(connection.Tell(what));
    return made;
  }
  // Counts on from where the process is that is furthest.
  absl::Status FallInStep(Connection& connection);
  // That, and the role of caretaker: taken where nobody has it, prolonged, or `leaves` it.
  absl::Status KeepRole(Connection& connection, bool leaves);
  void Beat();

  absl::Status CheckRoom(Growth growth) const {
    return growth == Growth::kGrows ? engine_->CheckRoom() : absl::OkStatus();
  }
  template <typename T, typename Work>
  absl::StatusOr<T> Write(Growth growth, const Work& work, Writer::Durable durable = Writer::Durable::kNow) {
    RETURN_IF_ERROR(CheckRoom(growth));
    std::optional<T> result;
    const auto run = [&](Connection& connection) {
      absl::StatusOr<T> made = work(connection);
      if (!made.ok()) return std::move(made).status();
      result = *std::move(made);
      return absl::OkStatus();
    };
    RETURN_IF_ERROR(writer_.Run(run, durable));
    return *std::move(result);
  }
  // Whoever keeps house calls these now and then: a crash then loses little of the time that is counted.
  template <typename Work>
  absl::StatusOr<int> Expire(const Work& work) {
    return Write<int>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<int> {
      RETURN_IF_ERROR(SaveUpTime(c, UpTime()));
      RETURN_IF_ERROR(MarkAge(c, UpTime()));
      return work(c);
    });
  }
  // DATA_LOSS unless all that belongs to it is as it was stored.
  absl::Status CheckWhole(const SessionRecord& session);
  absl::Status CheckWhole(const ProgramRecord& program);
  absl::Status NotDamagedIfGone(const SessionRecord& session, const absl::Status& status);
  void TellDamage(const absl::Status& status) const {
    if (options_.damaged) options_.damaged(status);
  }
  // For what is read again and again: each damage is told once.
  std::function<void(const absl::Status&)> ToldOnce() {
    return [this](const absl::Status& status) {
      const base::MutexLock lock(told_mutex_);
      if (told_.size() < kMaxTold && told_.insert(std::string(status.message())).second) TellDamage(status);
    };
  }
  absl::StatusOr<SharedSpecs> Specs(SessionId id);
  absl::StatusOr<EncodedChunk> Encode(SessionId id, const records::Chunk& chunk);
  absl::Status VisitChunks(const SessionRecord& session, int64_t first_seq,
                           const std::function<absl::Status(const records::Chunk&)>& visit);
  absl::Status VisitParts(const ProgramRecord& program, int64_t offset,
                          const std::function<absl::Status(const std::string&)>& visit);

  const std::unique_ptr<Engine> engine_;  // closed last
  const StoreOptions options_;
  const std::chrono::microseconds up_at_open_;
  const base::SteadyTime opened_at_;
  const std::string owner_id_;
  std::atomic<int64_t> up_of_others_us_ = 0;  // that this process was not there to count
  // Until when this process is the caretaker, on its steady clock.
  std::atomic<base::SteadyTime> caretaker_until_{base::SteadyTime{}};
  base::Mutex follow_mutex_;
  base::CondVar stop_following_;
  bool follows_ AXISCAL_GUARDED_BY(follow_mutex_) = false;
  std::thread beats_;
  std::unique_ptr<Listener> listener_;
  Readers readers_;
  base::Mutex specs_mutex_;
  // Of recent sessions; they never change.
  std::unordered_map<SessionId, SharedSpecs> specs_ AXISCAL_GUARDED_BY(specs_mutex_);
  base::Mutex claims_mutex_;
  // Of a store that is shared, from the first claim on.
  std::unique_ptr<Connection> claims_ AXISCAL_GUARDED_BY(claims_mutex_);
  static constexpr size_t kMaxTold = 1000;
  base::Mutex told_mutex_;
  std::set<std::string> told_ AXISCAL_GUARDED_BY(told_mutex_);
  Writer writer_;  // closed first
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SQL_STORE_H_
