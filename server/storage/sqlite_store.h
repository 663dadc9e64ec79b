// The Database on one SQLite file: each call is a function of connection and request, given to the writer's thread or
// to a reader. Used through OpenSqlite() alone.
#ifndef AXISCAL_SERVER_STORAGE_SQLITE_STORE_H_
#define AXISCAL_SERVER_STORAGE_SQLITE_STORE_H_

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/base/mutex.h"
#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/calibrations.h"
#include "server/storage/chunks.h"
#include "server/storage/file_lock.h"
#include "server/storage/history.h"
#include "server/storage/jobs.h"
#include "server/storage/machines.h"
#include "server/storage/migrate.h"
#include "server/storage/programs.h"
#include "server/storage/readers.h"
#include "server/storage/sessions.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/up_time.h"
#include "server/storage/writer.h"

namespace axiscal::storage {

// Whether a write adds to the disk (refused when it runs low) or ends, changes and cleans up (always let through).
enum class Growth { kGrows, kStays };

class SqliteStore final : public Database {
 public:
  // `up`: ReadUpTime() of the file.
  SqliteStore(const SqliteOptions& options, std::chrono::microseconds up, FileLock lock,
              std::unique_ptr<Connection> connection)
      : options_(options),
        up_at_open_(up),
        opened_at_(options.clock->SteadyNow()),
        owner_id_(MakeOwnerId()),
        lock_(std::move(lock)),
        readers_(options.path),
        writer_(std::move(connection)) {}
  ~SqliteStore() override {
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
  absl::StatusOr<int> ExpireSessions(std::chrono::microseconds idle) override {
    return Expire([&](Connection& c) { return storage::ExpireSessions(c, Present(), idle); });
  }
  absl::StatusOr<session::Session> ReadSession(SessionId id) override;
  absl::Status ReadChunks(SessionId id, int64_t first_seq,
                          const std::function<absl::Status(const records::Chunk&)>& visit) override;

  // ---- jobs
  absl::StatusOr<JobRecord> CreateJob(const NewJob& job, int max_queued) override {
    return Write<JobRecord>(Growth::kGrows,
                            [&](Connection& c) { return storage::CreateJob(c, Present(), job, max_queued); });
  }
  absl::StatusOr<JobRecord> GetJob(JobId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetJob(c, id); });
  }
  absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter, const PageRequest& page,
                                           const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListJobs(c, filter, page, visible); });
  }
  absl::StatusOr<std::optional<JobRecord>> ClaimJob(std::chrono::microseconds lease) override {
    return Write<std::optional<JobRecord>>(Growth::kStays,
                                           [&](Connection& c) { return storage::ClaimJob(c, Owner(), lease); });
  }
  absl::StatusOr<std::optional<std::chrono::microseconds>> NextJobWait() override {
    return readers_.Run([&](Connection& c) { return storage::NextJobWait(c, Present()); });
  }
  absl::StatusOr<JobRecord> HeartbeatJob(const JobClaim& claim, std::chrono::microseconds lease,
                                         const JobProgress& progress) override {
    return Write<JobRecord>(Growth::kStays,
                            [&](Connection& c) { return storage::HeartbeatJob(c, Owner(), claim, lease, progress); });
  }
  absl::StatusOr<JobRecord> SucceedJob(const JobClaim& claim, const JobProduct& product) override {
    return Write<JobRecord>(Growth::kStays,
                            [&](Connection& c) { return storage::SucceedJob(c, Owner(), claim, product); });
  }
  absl::StatusOr<JobRecord> EndJob(const JobClaim& claim, JobEnd end, const JobError& error,
                                   std::chrono::microseconds retry_after) override {
    return Write<JobRecord>(Growth::kStays,
                            [&](Connection& c) { return storage::EndJob(c, Owner(), claim, end, error, retry_after); });
  }
  absl::StatusOr<JobRecord> CancelJob(JobId id, const Caller& caller) override {
    return Write<JobRecord>(Growth::kStays, [&](Connection& c) { return storage::CancelJob(c, Now(), id, caller); });
  }
  absl::StatusOr<JobRecord> RequeueJob(JobId id, int max_queued, const Caller& caller) override {
    return Write<JobRecord>(Growth::kStays,
                            [&](Connection& c) { return storage::RequeueJob(c, Present(), id, max_queued, caller); });
  }
  absl::StatusOr<std::vector<JobRecord>> RescueJobs() override {
    return Write<std::vector<JobRecord>>(Growth::kStays,
                                         [&](Connection& c) { return storage::RescueJobs(c, Owner()); });
  }

  // ---- calibrations
  absl::StatusOr<CalibrationRecord> CreateCalibration(const NewCalibration& calibration) override {
    return Write<CalibrationRecord>(
        Growth::kGrows, [&](Connection& c) { return storage::CreateCalibration(c, Now(), calibration, std::nullopt); });
  }
  absl::StatusOr<CalibrationRecord> GetCalibration(CalibrationId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetCalibration(c, id); });
  }
  absl::StatusOr<CalibrationRecord> GetApprovedCalibration(const MachineId& machine) override {
    return readers_.Run([&](Connection& c) { return storage::GetApprovedCalibration(c, machine); });
  }
  absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter, const PageRequest& page,
                                                           const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::ListCalibrations(c, filter, page, visible); });
  }
  absl::StatusOr<CalibrationRecord> ApproveCalibration(CalibrationId id, int64_t expected_etag,
                                                       const Caller& caller) override {
    return Write<CalibrationRecord>(Growth::kStays, [&](Connection& c) {
      return storage::ApproveCalibration(c, Now(), id, expected_etag, caller);
    });
  }
  absl::StatusOr<CalibrationRecord> RetireCalibration(CalibrationId id, int64_t expected_etag,
                                                      const Caller& caller) override {
    return Write<CalibrationRecord>(
        Growth::kStays, [&](Connection& c) { return storage::RetireCalibration(c, Now(), id, expected_etag, caller); });
  }

  // ---- history
  absl::StatusOr<std::vector<DriftSeries>> QueryDrift(const DriftQuery& query) override {
    return readers_.Run([&](Connection& c) { return storage::QueryDrift(c, query); });
  }
  absl::StatusOr<Page<FleetRow>> LatestFleet(const std::vector<std::string>& symbols, const PageRequest& page,
                                             const Visible& visible) override {
    return readers_.Run([&](Connection& c) { return storage::LatestFleet(c, symbols, page, visible); });
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

  // ---- audit
  absl::Status AppendAudit(const AuditEntry& entry) override {
    return writer_.Run([&](Connection& c) { return storage::AppendAudit(c, entry); });
  }
  absl::StatusOr<Page<AuditEntry>> ListAudit(const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListAudit(c, page); });
  }

  int schema_version() const override { return static_cast<int>(EmbeddedMigrations().size()); }

 private:
  using SharedSpecs = std::shared_ptr<const std::vector<ColumnSpec>>;

  static std::string MakeOwnerId();
  UtcTime Now() const { return options_.clock->UtcNow(); }
  std::chrono::microseconds UpTime() const {
    const auto here = options_.clock->SteadyNow() - opened_at_;
    return up_at_open_ + std::chrono::duration_cast<std::chrono::microseconds>(here);
  }
  Moment Present() const { return {Now(), UpTime().count()}; }
  JobOwner Owner() const {
    const auto steady = options_.clock->SteadyNow().time_since_epoch();
    return {owner_id_, Present(), std::chrono::duration_cast<std::chrono::microseconds>(steady).count()};
  }

  absl::Status CheckDisk(Growth growth) const;
  template <typename T, typename Work>
  absl::StatusOr<T> Write(Growth growth, const Work& work) {
    RETURN_IF_ERROR(CheckDisk(growth));
    std::optional<T> result;
    RETURN_IF_ERROR(writer_.Run([&](Connection& connection) {
      absl::StatusOr<T> made = work(connection);
      if (!made.ok()) return std::move(made).status();
      result = *std::move(made);
      return absl::OkStatus();
    }));
    return *std::move(result);
  }
  // Whoever keeps house calls these now and then: a crash then loses little of the time that is counted.
  template <typename Work>
  absl::StatusOr<int> Expire(const Work& work) {
    return Write<int>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<int> {
      RETURN_IF_ERROR(SaveUpTime(c, UpTime()));
      return work(c);
    });
  }
  // DATA_LOSS unless all that belongs to it is as it was stored.
  absl::Status CheckWhole(const SessionRecord& session);
  absl::Status CheckWhole(const ProgramRecord& program);
  void TellDamage(const absl::Status& status) const {
    if (options_.damaged) options_.damaged(status);
  }
  absl::StatusOr<SharedSpecs> Specs(SessionId id);
  absl::StatusOr<EncodedChunk> Encode(SessionId id, const records::Chunk& chunk);
  absl::Status VisitChunks(const SessionRecord& session, int64_t first_seq,
                           const std::function<absl::Status(const records::Chunk&)>& visit);
  absl::Status VisitParts(const ProgramRecord& program, int64_t offset,
                          const std::function<absl::Status(const std::string&)>& visit);

  const SqliteOptions options_;
  const std::chrono::microseconds up_at_open_;
  const base::SteadyTime opened_at_;
  const std::string owner_id_;
  const FileLock lock_;  // released last
  Readers readers_;
  base::Mutex specs_mutex_;
  // Of recent sessions; they never change.
  std::unordered_map<SessionId, SharedSpecs> specs_ AXISCAL_GUARDED_BY(specs_mutex_);
  Writer writer_;  // closed first
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_SQLITE_STORE_H_
