// The store, in core types. Every call is safe from any thread and blocks until it is done; a write that returned OK is
// durable (on disk, fsync).
//
// Failures carry base::ErrorDetail; apart from those named below any call may return
//   RESOURCE_EXHAUSTED DISK_LOW (refused before the disk is full) or DISK_FULL, UNAVAILABLE STORE_BUSY / STORE_DOWN
//   (try again), FAILED_PRECONDITION STORE_READ_ONLY, DATA_LOSS STORE_DAMAGED / CHUNK_DAMAGED.
//   MACHINE_, SESSION_, CALIBRATION_DAMAGED: the row read is not the one that was stored. A failed write changed
//   nothing. NOT_FOUND comes with MACHINE_, SESSION_, JOB_, CALIBRATION_, PROGRAM_NOT_FOUND; a bad page with
//   INVALID_ARGUMENT PAGE_INVALID. A request_id seen before with another body: INVALID_ARGUMENT REQUEST_ID_REUSED; with
//   the same body: the row made then.
#ifndef AXISCAL_SERVER_STORAGE_DATABASE_H_
#define AXISCAL_SERVER_STORAGE_DATABASE_H_

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/records/chunk.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// How an attempt at a job ended without success.
enum class JobEnd {
  kFailed,     // for good
  kCancelled,  // as asked
  kRetry,      // QUEUED again after `retry_after`; DEAD when the attempts are used up
  kParked,     // QUEUED again and the attempt not counted: the server is shutting down
};

class Database {
 public:
  virtual ~Database() = default;

  // ---- machines
  // The same id with the same description gives the machine that is there; with another one ALREADY_EXISTS
  // MACHINE_EXISTS.
  virtual absl::StatusOr<MachineRecord> CreateMachine(const MachineId& id, const std::string& description_json,
                                                      const Caller& caller) = 0;
  // The current revision, its checksum compared (DATA_LOSS MACHINE_DAMAGED; not in lists); also of a deleted machine,
  // whose history stays readable.
  virtual absl::StatusOr<MachineRecord> GetMachine(const MachineId& id) = 0;
  virtual absl::StatusOr<MachineRecord> GetMachineRevision(const MachineId& id, int64_t revision) = 0;
  // `expected_revision` 0: whatever it is; otherwise ABORTED ETAG_MISMATCH when it is another.
  virtual absl::StatusOr<MachineRecord> UpdateMachine(const MachineId& id, int64_t expected_revision,
                                                      const std::string& description_json, const Caller& caller) = 0;
  // Hides it from lists and takes no new sessions for it (FAILED_PRECONDITION MACHINE_DELETED). Repeating is OK.
  virtual absl::StatusOr<MachineRecord> DeleteMachine(const MachineId& id, int64_t expected_revision,
                                                      const Caller& caller) = 0;
  virtual absl::StatusOr<Page<MachineRecord>> ListMachines(const PageRequest& page, const Visible& visible) = 0;
  absl::StatusOr<Page<MachineRecord>> ListMachines(const PageRequest& page) { return ListMachines(page, Visible()); }

  // ---- sessions
  // A session is its machine and content: the same request id and body give the same session, whoever asks, unless it
  // was given up (ABORTED, EXPIRED) or anything of it is damaged, which is looked for; then they make a new one.
  virtual absl::StatusOr<SessionRecord> CreateSession(const NewSession& session) = 0;
  virtual absl::StatusOr<SessionRecord> GetSession(SessionId id) = 0;
  // `visible` counts where the filter names no machine; so in the lists below.
  virtual absl::StatusOr<Page<SessionRecord>> ListSessions(const SessionFilter& filter, const PageRequest& page,
                                                           const Visible& visible) = 0;
  absl::StatusOr<Page<SessionRecord>> ListSessions(const SessionFilter& filter, const PageRequest& page) {
    return ListSessions(filter, page, Visible());
  }

  // Appends a chunk with the session's columns, in its order; seq runs from 0 without gaps. Returns when the chunk is
  // durable; concurrent calls share a commit.
  //   other columns: INVALID_ARGUMENT CHUNK_INVALID; seq too large: OUT_OF_RANGE SEQ_GAP (fact next_seq); seq there
  //   with other content: ALREADY_EXISTS CHUNK_CONFLICT; session not open: FAILED_PRECONDITION SESSION_CLOSED.
  // A repeat with equal content is OK, also after the session is complete, unless what is stored is damaged: DATA_LOSS
  // CHUNK_DAMAGED.
  virtual absl::StatusOr<AppendResult> AppendChunk(SessionId id, const records::Chunk& chunk) = 0;
  // The same without waiting, so that one stream can keep several chunks under way: encodes at once, then `done` is
  // called exactly once, with what AppendChunk would return, in order of the calls, on the writer's thread (or on the
  // caller's when it fails at once). `done` must be quick and must not call the database. Blocks only while too many
  // writes wait already.
  virtual void AppendChunkAsync(SessionId id, const records::Chunk& chunk,
                                std::function<void(absl::StatusOr<AppendResult>)> done) = 0;
  // Checks the totals (else FAILED_PRECONDITION TOTALS_MISMATCH) and makes the session COMPLETE and immutable.
  // Repeating with the same totals is OK.
  virtual absl::StatusOr<SessionRecord> FinishSession(SessionId id, const SessionTotals& totals) = 0;
  // Drops the chunks; the row stays as ABORTED. A complete session is refused (SESSION_CLOSED); repeating is OK.
  virtual absl::StatusOr<SessionRecord> AbortSession(SessionId id) = 0;
  // Open sessions that were left for longer than `idle` become EXPIRED, their chunks dropped. How many. Only time that
  // the file was open counts: neither a night without power nor a clock that was set. Saves how much that is: a crash
  // loses what went by since this or ExpirePrograms() was called last.
  virtual absl::StatusOr<int> ExpireSessions(std::chrono::microseconds idle) = 0;

  // Only complete sessions have data: else FAILED_PRECONDITION SESSION_NOT_COMPLETE. Every chunk's checksum is
  // verified; a damaged one is DATA_LOSS CHUNK_DAMAGED (facts session, seq).
  virtual absl::StatusOr<session::Session> ReadSession(SessionId id) = 0;
  // The same chunk by chunk from `first_seq`; an error from `visit` ends it and is returned. Holds no lock while
  // `visit` runs. Also of an open session, as far as it is durable: a resumed upload is checked against what stands.
  virtual absl::Status ReadChunks(SessionId id, int64_t first_seq,
                                  const std::function<absl::Status(const records::Chunk&)>& visit) = 0;

  // ---- jobs (use jobs::JobRunner: it tells watchers; these calls do not)
  // RESOURCE_EXHAUSTED QUEUE_FULL when `max_queued` jobs wait.
  virtual absl::StatusOr<JobRecord> CreateJob(const NewJob& job, int max_queued) = 0;
  virtual absl::StatusOr<JobRecord> GetJob(JobId id) = 0;
  // Without `result`.
  virtual absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter, const PageRequest& page,
                                                   const Visible& visible) = 0;
  absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter, const PageRequest& page) {
    return ListJobs(filter, page, Visible());
  }
  // The best waiting job whose time has come and whose params are those that were stored (others FAIL with
  // JOB_DAMAGED), now RUNNING as a new attempt (ClaimOf), or nothing.
  virtual absl::StatusOr<std::optional<JobRecord>> ClaimJob(std::chrono::microseconds lease) = 0;
  // How long from now until a waiting job may be claimed; nothing when none waits.
  virtual absl::StatusOr<std::optional<std::chrono::microseconds>> NextJobWait() = 0;
  // Prolongs the lease and stores the progress. The record tells whether to cancel.
  virtual absl::StatusOr<JobRecord> HeartbeatJob(const JobClaim& claim, std::chrono::microseconds lease,
                                                 const JobProgress& progress) = 0;
  // Stores all that the job made and its success, or nothing of it.
  virtual absl::StatusOr<JobRecord> SucceedJob(const JobClaim& claim, const JobProduct& product) = 0;
  virtual absl::StatusOr<JobRecord> EndJob(const JobClaim& claim, JobEnd end, const JobError& error,
                                           std::chrono::microseconds retry_after) = 0;
  // A waiting job is CANCELLED at once, a running one gets cancel_requested, a finished one is returned as it is.
  virtual absl::StatusOr<JobRecord> CancelJob(JobId id, const Caller& caller) = 0;
  // FAILED, CANCELLED or DEAD: QUEUED again with all attempts. Others: FAILED_PRECONDITION JOB_NOT_ENDED.
  virtual absl::StatusOr<JobRecord> RequeueJob(JobId id, int max_queued, const Caller& caller) = 0;
  // RUNNING jobs whose lease is over go back to QUEUED, or DEAD after max_attempts. What changed. (Jobs of a dead
  // process are rescued on open.)
  virtual absl::StatusOr<std::vector<JobRecord>> RescueJobs() = 0;

  // ---- calibrations
  virtual absl::StatusOr<CalibrationRecord> CreateCalibration(const NewCalibration& calibration) = 0;
  virtual absl::StatusOr<CalibrationRecord> GetCalibration(CalibrationId id) = 0;
  // The approved one; NOT_FOUND CALIBRATION_NOT_FOUND when the machine has none.
  virtual absl::StatusOr<CalibrationRecord> GetApprovedCalibration(const MachineId& machine) = 0;
  // Both compare the checksum of all that was stored and of the machine's description that was fitted: DATA_LOSS
  // CALIBRATION_DAMAGED (facts calibration, machine). Lists and history, which move no machine, do not.
  // In lists `content` comes without model_json, options_json, report_json.
  virtual absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter,
                                                                   const PageRequest& page,
                                                                   const Visible& visible) = 0;
  absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter, const PageRequest& page) {
    return ListCalibrations(filter, page, Visible());
  }
  // A candidate, or a retired one (roll back), becomes the approved one; the machine's former one retires.
  // `expected_etag` 0: whatever it is, else ABORTED ETAG_MISMATCH. Repeating is OK.
  virtual absl::StatusOr<CalibrationRecord> ApproveCalibration(CalibrationId id, int64_t expected_etag,
                                                               const Caller& caller) = 0;
  virtual absl::StatusOr<CalibrationRecord> RetireCalibration(CalibrationId id, int64_t expected_etag,
                                                              const Caller& caller) = 0;

  // ---- history
  // Of all calibrations but candidates that were retired without ever having been approved. At most max_points points
  // per symbol, in order of symbol; an unknown symbol has no series. Unknown machine: NOT_FOUND.
  virtual absl::StatusOr<std::vector<DriftSeries>> QueryDrift(const DriftQuery& query) = 0;
  // The newest estimate of each symbol (empty: all) of each machine, a page of machines at a time; of calibrations that
  // are approved or candidates, never of retired ones.
  virtual absl::StatusOr<Page<FleetRow>> LatestFleet(const std::vector<std::string>& symbols, const PageRequest& page,
                                                     const Visible& visible) = 0;
  absl::StatusOr<Page<FleetRow>> LatestFleet(const std::vector<std::string>& symbols, const PageRequest& page) {
    return LatestFleet(symbols, page, Visible());
  }

  // ---- programs: begin, append parts at increasing offsets, finish; never the whole in memory
  // The same request gives the same program, unless it was given up or is damaged, which is looked for: then a new one,
  // whose parts the damaged one gets when it is finished.
  virtual absl::StatusOr<ProgramRecord> BeginProgram(const NewProgram& program) = 0;
  // `bytes`: 1 .. 4 MiB. `offset` beyond byte_count: OUT_OF_RANGE OFFSET_GAP (fact next_offset); a repeat of a stored
  // part is OK, other content there is ALREADY_EXISTS PART_CONFLICT. Complete: FAILED_PRECONDITION PROGRAM_CLOSED.
  // Returns the record with the new byte_count.
  virtual absl::StatusOr<ProgramRecord> AppendProgram(ProgramId id, int64_t offset, const std::string& bytes) = 0;
  // Checks the size and, unless empty, `sha256` (TOTALS_MISMATCH). When the same content is stored already that program
  // is returned and this one is dropped: use the returned id. Repeating is OK.
  virtual absl::StatusOr<ProgramRecord> FinishProgram(ProgramId id, int64_t byte_count, const std::string& sha256) = 0;
  // For an id that was merged into equal content, the program that has it.
  virtual absl::StatusOr<ProgramRecord> GetProgram(ProgramId id) = 0;
  virtual absl::StatusOr<Page<ProgramRecord>> ListPrograms(const ProgramFilter& filter, const PageRequest& page,
                                                           const Visible& visible) = 0;
  absl::StatusOr<Page<ProgramRecord>> ListPrograms(const ProgramFilter& filter, const PageRequest& page) {
    return ListPrograms(filter, page, Visible());
  }
  // The bytes from `offset` to the end in pieces, checksums verified (DATA_LOSS PART_DAMAGED). Only complete programs
  // (PROGRAM_NOT_COMPLETE).
  virtual absl::Status ReadProgram(ProgramId id, int64_t offset,
                                   const std::function<absl::Status(const std::string& bytes)>& visit) = 0;

  // Open programs that were left for longer than `idle` are given up, their parts dropped. How many; what counts is as
  // for sessions.
  virtual absl::StatusOr<int> ExpirePrograms(std::chrono::microseconds idle) = 0;

  // ---- access: who may do what (server/access decides; here it is written down)
  // The same name and note again give what is there; another note, or a name that was revoked: ALREADY_EXISTS
  // PRINCIPAL_EXISTS. A name that is none: INVALID_ARGUMENT NAME_INVALID; so of groups.
  virtual absl::StatusOr<PrincipalRecord> CreatePrincipal(const std::string& name, const std::string& note,
                                                          const Caller& caller) = 0;
  // With its tokens. Repeating is OK. NOT_FOUND PRINCIPAL_NOT_FOUND.
  virtual absl::StatusOr<PrincipalRecord> RevokePrincipal(const std::string& name, const Caller& caller) = 0;
  virtual absl::StatusOr<Page<PrincipalRecord>> ListPrincipals(const PageRequest& page) = 0;
  // FAILED_PRECONDITION PRINCIPAL_REVOKED.
  virtual absl::StatusOr<TokenRecord> CreateToken(const NewToken& token, const Caller& caller) = 0;
  // Repeating is OK. NOT_FOUND TOKEN_NOT_FOUND.
  virtual absl::StatusOr<TokenRecord> RevokeToken(int64_t id, const Caller& caller) = 0;
  // It was used now.
  virtual absl::Status TouchToken(int64_t id) = 0;
  virtual absl::StatusOr<PrincipalRecord> ChangeRole(const std::string& principal, const Grant& grant, bool holds,
                                                     const Caller& caller) = 0;
  virtual absl::StatusOr<MachineAccess> ChangeGroup(const std::string& group, const MachineId& machine, bool belongs,
                                                    const Caller& caller) = 0;
  virtual absl::StatusOr<MachineAccess> SetFourEyes(const MachineId& machine, bool four_eyes, const Caller& caller) = 0;
  virtual absl::StatusOr<Page<MachineAccess>> ListMachineAccess(const PageRequest& page) = 0;
  // Nothing when nobody has that token, or that name.
  virtual absl::StatusOr<std::optional<Holder>> FindHolderOfToken(const std::string& sha256) = 0;
  virtual absl::StatusOr<std::optional<Holder>> FindHolderOfName(const std::string& name) = 0;
  // NOT_FOUND as Missing() has it.
  virtual absl::StatusOr<Belonging> WhereBelongs(const Resource& resource, const std::string& principal) = 0;

  // ---- audit: append only. Changes of machines, calibrations and jobs by callers are entered by the store itself.
  virtual absl::Status AppendAudit(const AuditEntry& entry) = 0;
  virtual absl::StatusOr<Page<AuditEntry>> ListAudit(const PageRequest& page) = 0;

  // Schema version of the file, for GetServerInfo.
  virtual int schema_version() const = 0;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_DATABASE_H_
