#include "server/storage/sqlite_database.h"

#include <sys/statvfs.h>

#include <csignal>
#include <random>
#include <unordered_map>

#include "absl/strings/str_format.h"
#include "core/base/sha256.h"
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
#include "server/storage/refusal.h"
#include "server/storage/sessions.h"
#include "server/storage/writer.h"

namespace axiscal::storage {
namespace {

// Whether a write adds to the disk (refused when it runs low) or ends, changes and cleans up (always let through).
enum class Growth { kGrows, kStays };

class SqliteDatabase final : public Database {
 public:
  SqliteDatabase(const SqliteOptions& options, FileLock lock, std::unique_ptr<Connection> connection)
      : options_(options),
        owner_id_(MakeOwnerId()),
        lock_(std::move(lock)),
        readers_(options.path),
        writer_(std::move(connection)) {}

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
  absl::StatusOr<Page<MachineRecord>> ListMachines(const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListMachines(c, page); });
  }

  // ---- sessions
  absl::StatusOr<SessionRecord> CreateSession(const NewSession& session) override {
    return Write<SessionRecord>(Growth::kGrows,
                                [&](Connection& c) { return storage::CreateSession(c, Now(), session); });
  }
  absl::StatusOr<SessionRecord> GetSession(SessionId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetSession(c, id); });
  }
  absl::StatusOr<Page<SessionRecord>> ListSessions(const SessionFilter& filter, const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListSessions(c, filter, page); });
  }
  absl::StatusOr<AppendResult> AppendChunk(SessionId id, int64_t seq, const std::vector<session::Column>& columns,
                                           uint32_t crc32c) override;
  void AppendChunkAsync(SessionId id, int64_t seq, const std::vector<session::Column>& columns, uint32_t crc32c,
                        std::function<void(absl::StatusOr<AppendResult>)> done) override;
  absl::StatusOr<SessionRecord> FinishSession(SessionId id, const SessionTotals& totals) override {
    return Write<SessionRecord>(Growth::kStays,
                                [&](Connection& c) { return storage::FinishSession(c, Now(), id, totals); });
  }
  absl::StatusOr<SessionRecord> AbortSession(SessionId id) override {
    return Write<SessionRecord>(Growth::kStays, [&](Connection& c) { return storage::AbortSession(c, Now(), id); });
  }
  absl::StatusOr<int> ExpireSessions(UtcTime idle_since) override {
    return Write<int>(Growth::kStays, [&](Connection& c) { return storage::ExpireSessions(c, Now(), idle_since); });
  }
  absl::StatusOr<session::Session> ReadSession(SessionId id) override;
  absl::Status ReadChunks(
      SessionId id, int64_t first_seq,
      const std::function<absl::Status(int64_t seq, const std::vector<session::Column>&)>& visit) override;

  // ---- jobs
  absl::StatusOr<JobRecord> CreateJob(const NewJob& job, int max_queued) override {
    return Write<JobRecord>(Growth::kGrows,
                            [&](Connection& c) { return storage::CreateJob(c, Now(), job, max_queued); });
  }
  absl::StatusOr<JobRecord> GetJob(JobId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetJob(c, id); });
  }
  absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter, const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListJobs(c, filter, page); });
  }
  absl::StatusOr<std::optional<JobRecord>> ClaimJob(std::chrono::microseconds lease) override {
    return Write<std::optional<JobRecord>>(Growth::kStays,
                                           [&](Connection& c) { return storage::ClaimJob(c, Owner(), lease); });
  }
  absl::StatusOr<std::optional<UtcTime>> NextJobTime() override {
    return readers_.Run([&](Connection& c) { return storage::NextJobTime(c); });
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
                            [&](Connection& c) { return storage::RequeueJob(c, Now(), id, max_queued, caller); });
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
  absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter,
                                                           const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListCalibrations(c, filter, page); });
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
  absl::StatusOr<Page<FleetRow>> LatestFleet(const std::vector<std::string>& symbols,
                                             const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::LatestFleet(c, symbols, page); });
  }

  // ---- programs
  absl::StatusOr<ProgramRecord> BeginProgram(const NewProgram& program) override {
    return Write<ProgramRecord>(Growth::kGrows,
                                [&](Connection& c) { return storage::BeginProgram(c, Now(), program); });
  }
  absl::StatusOr<ProgramRecord> AppendProgram(ProgramId id, int64_t offset, const std::string& bytes) override {
    ASSIGN_OR_RETURN(const EncodedPart part, PreparePart(offset, bytes));
    return Write<ProgramRecord>(Growth::kGrows,
                                [&](Connection& c) { return storage::AppendProgram(c, Now(), id, part); });
  }
  absl::StatusOr<ProgramRecord> FinishProgram(ProgramId id, int64_t byte_count, const std::string& sha256) override;
  absl::StatusOr<ProgramRecord> GetProgram(ProgramId id) override {
    return readers_.Run([&](Connection& c) { return storage::GetProgram(c, id); });
  }
  absl::StatusOr<Page<ProgramRecord>> ListPrograms(const ProgramFilter& filter, const PageRequest& page) override {
    return readers_.Run([&](Connection& c) { return storage::ListPrograms(c, filter, page); });
  }
  absl::Status ReadProgram(ProgramId id, int64_t offset,
                           const std::function<absl::Status(const std::string& bytes)>& visit) override;
  absl::StatusOr<int> ExpirePrograms(UtcTime idle_since) override {
    return Write<int>(Growth::kStays, [&](Connection& c) { return storage::ExpirePrograms(c, idle_since); });
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

  static std::string MakeOwnerId() {
    std::random_device random;
    return absl::StrFormat("%08x%08x%08x", random(), random(), random());
  }
  UtcTime Now() const { return options_.clock->UtcNow(); }
  JobOwner Owner() const {
    const auto steady = options_.clock->SteadyNow().time_since_epoch();
    return {owner_id_, Now(), std::chrono::duration_cast<std::chrono::microseconds>(steady).count()};
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
  absl::StatusOr<SharedSpecs> Specs(SessionId id);
  absl::StatusOr<EncodedChunk> Encode(SessionId id, int64_t seq, const std::vector<session::Column>& columns,
                                      uint32_t crc32c);
  absl::Status VisitParts(const ProgramRecord& program, int64_t offset,
                          const std::function<absl::Status(const std::string&)>& visit);

  const SqliteOptions options_;
  const std::string owner_id_;
  const FileLock lock_;  // released last
  Readers readers_;
  std::mutex specs_mutex_;
  std::unordered_map<SessionId, SharedSpecs> specs_;  // guarded by specs_mutex_; of recent sessions, they never change
  Writer writer_;                                     // closed first
};

absl::Status SqliteDatabase::CheckDisk(Growth growth) const {
  if (growth == Growth::kStays) return absl::OkStatus();
  const int64_t free_bytes = options_.free_bytes();
  if (free_bytes >= options_.min_free_bytes) return absl::OkStatus();
  return base::Error(absl::StatusCode::kResourceExhausted,
                     absl::StrCat(options_.path, ": ", free_bytes, " bytes free on the disk, at least ",
                                  options_.min_free_bytes, " must stay free"),
                     {"DISK_LOW", {{"free_bytes", std::to_string(free_bytes)}}});
}

absl::StatusOr<SqliteDatabase::SharedSpecs> SqliteDatabase::Specs(SessionId id) {
  constexpr size_t kMaxRemembered = 4096;
  {
    const std::lock_guard<std::mutex> lock(specs_mutex_);
    const auto found = specs_.find(id);
    if (found != specs_.end()) return found->second;
  }
  ASSIGN_OR_RETURN(std::vector<ColumnSpec> columns,
                   readers_.Run([&](Connection& c) { return GetSessionColumns(c, id); }));
  const SharedSpecs specs = std::make_shared<const std::vector<ColumnSpec>>(std::move(columns));
  const std::lock_guard<std::mutex> lock(specs_mutex_);
  if (specs_.size() >= kMaxRemembered) specs_.clear();
  specs_[id] = specs;
  return specs;
}

absl::StatusOr<EncodedChunk> SqliteDatabase::Encode(SessionId id, int64_t seq,
                                                    const std::vector<session::Column>& columns, uint32_t crc32c) {
  RETURN_IF_ERROR(CheckDisk(Growth::kGrows));
  ASSIGN_OR_RETURN(const SharedSpecs specs, Specs(id));
  return PrepareChunk(seq, columns, crc32c, *specs);
}

absl::StatusOr<AppendResult> SqliteDatabase::AppendChunk(SessionId id, int64_t seq,
                                                         const std::vector<session::Column>& columns, uint32_t crc32c) {
  ASSIGN_OR_RETURN(const EncodedChunk chunk, Encode(id, seq, columns, crc32c));
  return Write<AppendResult>(Growth::kStays, [&](Connection& c) { return storage::AppendChunk(c, Now(), id, chunk); });
}

void SqliteDatabase::AppendChunkAsync(SessionId id, int64_t seq, const std::vector<session::Column>& columns,
                                      uint32_t crc32c, std::function<void(absl::StatusOr<AppendResult>)> done) {
  absl::StatusOr<EncodedChunk> encoded = Encode(id, seq, columns, crc32c);
  // A refusal goes through the writer too, so that answers keep the order of the calls.
  auto chunk = std::make_shared<absl::StatusOr<EncodedChunk>>(std::move(encoded));
  auto result = std::make_shared<AppendResult>();
  writer_.Start(
      [this, id, chunk, result](Connection& connection) {
        if (!chunk->ok()) return std::move(*chunk).status();
        absl::StatusOr<AppendResult> appended = storage::AppendChunk(connection, Now(), id, **chunk);
        if (!appended.ok()) return std::move(appended).status();
        *result = *appended;
        return absl::OkStatus();
      },
      [result, done = std::move(done)](absl::Status written) {
        if (written.ok()) return done(*result);
        done(std::move(written));
      });
}

absl::Status SqliteDatabase::ReadChunks(
    SessionId id, int64_t first_seq,
    const std::function<absl::Status(int64_t seq, const std::vector<session::Column>&)>& visit) {
  ASSIGN_OR_RETURN(const SessionRecord session, GetSession(id));
  if (session.state != SessionState::kComplete && session.state != SessionState::kOpen) {
    return FailedPrecondition(absl::StrCat("session ", id.number(), " is not complete"), "SESSION_NOT_COMPLETE");
  }
  // One short read per chunk: what is durable cannot change, and a slow visitor must not keep the log from being
  // merged.
  for (int64_t seq = std::max<int64_t>(first_seq, 0);; ++seq) {
    ASSIGN_OR_RETURN(const std::optional<std::vector<session::Column>> columns,
                     readers_.Run([&](Connection& c) { return ReadChunk(c, session, seq); }));
    if (!columns.has_value()) return absl::OkStatus();
    RETURN_IF_ERROR(visit(seq, *columns));
  }
}

absl::StatusOr<session::Session> SqliteDatabase::ReadSession(SessionId id) {
  ASSIGN_OR_RETURN(const SessionRecord record, GetSession(id));
  if (record.state != SessionState::kComplete) {
    return FailedPrecondition(absl::StrCat("session ", id.number(), " is not complete"), "SESSION_NOT_COMPLETE");
  }
  session::Session session;
  session.header = record.header;
  for (const ColumnSpec& spec : record.columns) session.columns.push_back({spec.name, {}, {}});
  RETURN_IF_ERROR(ReadChunks(id, 0, [&](int64_t seq, const std::vector<session::Column>& columns) {
    for (size_t i = 0; i < columns.size(); ++i) {
      session::Column& whole = session.columns[i];
      whole.values.insert(whole.values.end(), columns[i].values.begin(), columns[i].values.end());
      whole.texts.insert(whole.texts.end(), columns[i].texts.begin(), columns[i].texts.end());
    }
    return absl::OkStatus();
  }));
  return session;
}

absl::Status SqliteDatabase::VisitParts(const ProgramRecord& program, int64_t offset,
                                        const std::function<absl::Status(const std::string&)>& visit) {
  while (true) {
    ASSIGN_OR_RETURN(const std::optional<std::string> bytes,
                     readers_.Run([&](Connection& c) { return ReadPart(c, program, offset); }));
    if (!bytes.has_value()) return absl::OkStatus();
    RETURN_IF_ERROR(visit(*bytes));
    offset += static_cast<int64_t>(bytes->size());
  }
}

absl::Status SqliteDatabase::ReadProgram(ProgramId id, int64_t offset,
                                         const std::function<absl::Status(const std::string& bytes)>& visit) {
  if (offset < 0) return InvalidArgument(absl::StrCat("offset = ", offset, ", must be >= 0"), "PART_INVALID");
  ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(id));
  if (program.state != ProgramState::kComplete) {
    return FailedPrecondition(absl::StrCat("program ", id.number(), " is not complete"), "PROGRAM_NOT_COMPLETE");
  }
  return VisitParts(program, offset, visit);
}

absl::StatusOr<ProgramRecord> SqliteDatabase::FinishProgram(ProgramId id, int64_t byte_count,
                                                            const std::string& sha256) {
  ASSIGN_OR_RETURN(const ProgramRecord program, GetProgram(id));
  // Parts are only ever added, so their hash may be taken outside the writer's turn.
  base::Sha256 sha;
  RETURN_IF_ERROR(VisitParts(program, 0, [&](const std::string& bytes) {
    sha.Add(bytes);
    return absl::OkStatus();
  }));
  const std::string computed = sha.HexDigest();
  if (!sha256.empty() && sha256 != computed) {
    return FailedPrecondition(
        absl::StrCat("program ", id.number(), ": totals say sha256 ", sha256, ", stored is ", computed),
        "TOTALS_MISMATCH");
  }
  return Write<ProgramRecord>(Growth::kStays, [&](Connection& c) -> absl::StatusOr<ProgramRecord> {
    ASSIGN_OR_RETURN(const ProgramRecord present, storage::GetProgram(c, id));
    if (present.byte_count != program.byte_count)
      return FailedPrecondition("parts were added while it was finished", "TOTALS_MISMATCH");
    return storage::FinishProgram(c, id, byte_count, computed);
  });
}

void IgnoreFileSizeSignal() {
  struct sigaction present;
  if (sigaction(SIGXFSZ, nullptr, &present) == 0 && present.sa_handler == SIG_DFL) std::signal(SIGXFSZ, SIG_IGN);
}

int64_t FreeBytes(const std::string& path) {
  struct statvfs info;
  // A disk that does not answer is not called full: the write itself will tell.
  if (statvfs(path.c_str(), &info) != 0) return std::numeric_limits<int64_t>::max();
  return static_cast<int64_t>(info.f_bavail) * static_cast<int64_t>(info.f_frsize);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> OpenSqlite(const SqliteOptions& given) {
  SqliteOptions options = given;
  if (!options.free_bytes) options.free_bytes = [path = given.path] { return FreeBytes(path); };
  IgnoreFileSizeSignal();
  ASSIGN_OR_RETURN(FileLock lock, FileLock::Take(options.path + ".lock"));
  RETURN_IF_ERROR(CheckFile(options.path, EmbeddedMigrations()));
  ASSIGN_OR_RETURN(std::unique_ptr<Connection> connection, Connection::Open(options.path, Access::kWrite));
  RETURN_IF_ERROR(base::Within(options.path, Migrate(*connection, EmbeddedMigrations(), options.clock->UtcNow())));
  auto database = std::make_unique<SqliteDatabase>(options, std::move(lock), std::move(connection));
  RETURN_IF_ERROR(database->RescueJobs().status());
  return database;
}

}  // namespace axiscal::storage
