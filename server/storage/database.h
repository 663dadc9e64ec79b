// The store, in core types. Every call is safe from any thread and blocks until it is done; a write that returned OK is
// durable (on disk, fsync).
//
// Failures carry base::ErrorDetail; apart from those named below any call may return
//   RESOURCE_EXHAUSTED DISK_LOW (refused before the disk is full) or DISK_FULL, UNAVAILABLE STORE_BUSY / STORE_DOWN
//   (try again), FAILED_PRECONDITION STORE_READ_ONLY, DATA_LOSS STORE_DAMAGED / CHUNK_DAMAGED.
//   MACHINE_, SESSION_, CALIBRATION_DAMAGED: the row read is not the one that was stored. A failed write changed
//   nothing. NOT_FOUND comes with MACHINE_, SESSION_, JOB_, CALIBRATION_, PROGRAM_, MARK_, EVENT_, ROUTINE_NOT_FOUND; a
//   bad page with INVALID_ARGUMENT PAGE_INVALID. A request_id seen before with another body: INVALID_ARGUMENT
//   REQUEST_ID_REUSED; with the same body: the row made then.
#ifndef AXISCAL_SERVER_STORAGE_DATABASE_H_
#define AXISCAL_SERVER_STORAGE_DATABASE_H_

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <utility>
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
  kRetry,      // QUEUED again after `retry_after`; DEAD when max_attempts have ended so
  kParked,     // QUEUED again after `retry_after`, and the attempt not counted: nothing speaks against the job
};

// What other processes that have the same store may have done since one heard last, and this one, too.
struct News {
  bool jobs = false;                      // one was created, claimed, cancelled, has ended ...
  bool events = false;                    // or a webhook was changed
  bool routines = false;                  // of all machines
  std::optional<MachineId> machine = {};  // to be looked at: TellOthers()
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
  // Replaces note and labels of a complete session (else FAILED_PRECONDITION SESSION_NOT_COMPLETE). `expected_etag` 0:
  // whatever is there; otherwise ABORTED ETAG_MISMATCH when the remark is another.
  virtual absl::StatusOr<SessionRecord> AnnotateSession(SessionId id, const std::string& note,
                                                        const std::vector<std::string>& labels, int64_t expected_etag,
                                                        const Caller& caller) = 0;
  // Whether a complete session counts, and why. Repeating is OK; the first reason stays.
  virtual absl::StatusOr<RejectedSession> RejectSession(SessionId id, bool is_rejected, const std::string& reason,
                                                        const Caller& caller) = 0;
  // Open sessions that were left for longer than `idle` become EXPIRED, their chunks dropped. How many. Only time that
  // the file was open counts: neither a night without power nor a clock that was set. Saves how much that is: a crash
  // loses what went by since this or ExpirePrograms() was called last.
  virtual absl::StatusOr<int> ExpireSessions(std::chrono::microseconds idle) = 0;

  // Complete sessions of at least this age become EXPIRED and their chunks go, except where a calibration stands on
  // them or a job of their machine has not ended. How many. Age is as in ExpireAudit().
  virtual absl::StatusOr<int> ExpireReadings(std::chrono::microseconds age) = 0;

  // Only complete sessions have data: else FAILED_PRECONDITION SESSION_NOT_COMPLETE. Every chunk's checksum is
  // verified; a damaged one is DATA_LOSS CHUNK_DAMAGED (facts session, seq).
  virtual absl::StatusOr<session::Session> ReadSession(SessionId id) = 0;
  // The same chunk by chunk from `first_seq`; an error from `visit` ends it and is returned. Holds no lock while
  // `visit` runs. Also of an open session, as far as it is durable: a resumed upload is checked against what stands.
  virtual absl::Status ReadChunks(SessionId id, int64_t first_seq,
                                  const std::function<absl::Status(const records::Chunk&)>& visit) = 0;

  // ---- jobs (use jobs::JobRunner: it tells watchers; these calls do not)
  // RESOURCE_EXHAUSTED QUEUE_FULL where there is no room for it.
  virtual absl::StatusOr<JobRecord> CreateJob(const NewJob& job, const JobRoom& room) = 0;
  virtual absl::StatusOr<JobRecord> GetJob(JobId id) = 0;
  // Without `result`.
  virtual absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter, const PageRequest& page,
                                                   const Visible& visible) = 0;
  absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter, const PageRequest& page) {
    return ListJobs(filter, page, Visible());
  }
  // Of the principals that have waiting jobs of the highest priority, the one with the fewest that run, and of these
  // the one whose turn was longest ago, has its turn: its first waiting job whose time has come and whose params are
  // those that were stored (others FAIL with JOB_DAMAGED, those of a principal that was revoked with
  // PRINCIPAL_REVOKED), now RUNNING as a new attempt (ClaimOf), or nothing.
  virtual absl::StatusOr<std::optional<JobRecord>> ClaimJob(std::chrono::microseconds lease) = 0;
  // How long from now until a waiting job may be claimed; nothing when none waits.
  virtual absl::StatusOr<std::optional<std::chrono::microseconds>> NextJobWait() = 0;
  virtual absl::StatusOr<JobQueue> CountJobs() = 0;
  // JobRecord::version of those that are there: whether anything has happened to them.
  virtual absl::StatusOr<std::vector<std::pair<JobId, int64_t>>> JobVersions(const std::vector<JobId>& ids) = 0;
  // Prolongs the lease and stores the progress. The record tells whether to cancel.
  virtual absl::StatusOr<JobRecord> HeartbeatJob(const JobClaim& claim, std::chrono::microseconds lease,
                                                 const JobProgress& progress) = 0;
  // Stores all that the job made and its success, or nothing of it. PERMISSION_DENIED PRINCIPAL_REVOKED where whoever
  // created it was revoked meanwhile.
  virtual absl::StatusOr<JobRecord> SucceedJob(const JobClaim& claim, const JobProduct& product) = 0;
  virtual absl::StatusOr<JobRecord> EndJob(const JobClaim& claim, JobEnd end, const JobError& error,
                                           std::chrono::microseconds retry_after) = 0;
  // A waiting job is CANCELLED at once, a running one gets cancel_requested, a finished one is returned as it is.
  virtual absl::StatusOr<JobRecord> CancelJob(JobId id, const Caller& caller) = 0;
  // FAILED, CANCELLED or DEAD: QUEUED again with all attempts. Others: FAILED_PRECONDITION JOB_NOT_ENDED.
  virtual absl::StatusOr<JobRecord> RequeueJob(JobId id, const JobRoom& room, const Caller& caller) = 0;
  // RUNNING jobs whose lease is over go back to QUEUED, from the third such loss on with a growing wait, or DEAD after
  // kMostLostAttempts (jobs.h); QUEUED ones whose deadline is over are FAILED. What changed. (Jobs of a dead process
  // are rescued on open, unless another one has the store, too: then when their lease is over. Attempts of an earlier
  // boot of this machine are not counted: whatever ended it took all with it.)
  virtual absl::StatusOr<std::vector<JobRecord>> RescueJobs() = 0;

  // ---- calibrations
  virtual absl::StatusOr<CalibrationRecord> CreateCalibration(const NewCalibration& calibration) = 0;
  virtual absl::StatusOr<CalibrationRecord> GetCalibration(CalibrationId id) = 0;
  // What people decided of it, newest first, as the audit has it: at most `limit`, of those that its retention left.
  virtual absl::StatusOr<std::vector<records::Decision>> ListDecisions(CalibrationId id, int limit) = 0;
  // The approved one; NOT_FOUND CALIBRATION_NOT_FOUND when the machine has none.
  virtual absl::StatusOr<CalibrationRecord> GetApprovedCalibration(const MachineId& machine) = 0;
  // That which a person put in use last: the one in use, or what routines have replaced since. NOT_FOUND where none
  // was.
  virtual absl::StatusOr<CalibrationRecord> GetApprovedByPerson(const MachineId& machine) = 0;
  // The one that this one took the place of when it was approved last, or would take now; nothing where none was in
  // use.
  virtual absl::StatusOr<std::optional<CalibrationId>> GetFormerOf(CalibrationId id) = 0;
  // Those that give a record compare the checksum of all that was stored and of the machine's description that was
  // fitted: DATA_LOSS CALIBRATION_DAMAGED (facts calibration, machine). Lists and history, which move no machine, do
  // not. In lists `content` comes without model_json, options_json, report_json.
  virtual absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter,
                                                                   const PageRequest& page, const Visible& visible) = 0;
  absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter, const PageRequest& page) {
    return ListCalibrations(filter, page, Visible());
  }
  // A candidate, or a retired one (roll back), becomes the approved one; the machine's former one retires.
  // `expected_etag` 0: whatever it is, else ABORTED ETAG_MISMATCH. So where `former` is given and another calibration,
  // or none, is in use: it was judged against one that nobody uses any more. Repeating is OK: nothing changes, and the
  // audit gets a reason that it does not have yet.
  virtual absl::StatusOr<CalibrationRecord> ApproveCalibration(CalibrationId id, int64_t expected_etag,
                                                               std::optional<CalibrationId> former,
                                                               const Caller& caller) = 0;
  absl::StatusOr<CalibrationRecord> ApproveCalibration(CalibrationId id, int64_t expected_etag, const Caller& caller) {
    return ApproveCalibration(id, expected_etag, std::nullopt, caller);
  }
  virtual absl::StatusOr<CalibrationRecord> RetireCalibration(CalibrationId id, int64_t expected_etag,
                                                              const Caller& caller) = 0;

  // ---- history
  // Of all calibrations but candidates that were retired unapproved, and not what is damaged. At most max_points points
  // per symbol, in order of symbol; an unknown symbol has no series. Unknown machine: NOT_FOUND.
  virtual absl::StatusOr<std::vector<DriftSeries>> QueryDrift(const DriftQuery& query) = 0;
  // The newest estimate of each symbol (empty: all) of each machine, a page of machines at a time; of calibrations that
  // are approved or candidates, never of retired ones; not of a symbol where it is damaged.
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
  // Newest first.
  virtual absl::StatusOr<Page<AuditEntry>> ListAudit(const AuditFilter& filter, const PageRequest& page) = 0;
  absl::StatusOr<Page<AuditEntry>> ListAudit(const PageRequest& page) { return ListAudit(AuditFilter(), page); }
  // Compares every entry with its hash, which covers those before it. DATA_LOSS AUDIT_DAMAGED (fact audit) names the
  // first that was changed or is missing.
  virtual absl::StatusOr<AuditHead> CheckAudit() = 0;
  // Removes the oldest entries, of at least this age, some at a time; how many, 0 when there are none. The chain keeps
  // its anchor. Age is time that the file was open, in days: marks are made by ExpireSessions().
  virtual absl::StatusOr<int> ExpireAudit(std::chrono::microseconds age) = 0;

  // A copy of what the database is now, in a new file, synced and looked through, while others go on reading and
  // writing. `go_on`, which may be empty, is asked between pieces: an error ends the copying, and is returned. Where
  // something is damaged the copy is made, and the damages are named. ALREADY_EXISTS where there is a file,
  // FAILED_PRECONDITION FOLDER_NOT_WRITABLE; on failure there is none.
  virtual absl::StatusOr<BackupResult> Backup(const std::string& path, const std::function<absl::Status()>& go_on) = 0;

  // Whether something can be written now. UNAVAILABLE STORE_DOWN, RESOURCE_EXHAUSTED DISK_FULL ...
  virtual absl::Status TryWrite() = 0;

  // Whether something can be read now from where it is kept: by a connection of its own, as one that is open may answer
  // for long from what it has in memory. UNAVAILABLE STORE_DOWN, DATA_LOSS STORE_DAMAGED.
  virtual absl::Status TryReadAnew() = 0;

  // ---- several processes on one store: PostgreSQL. A file has one, which is the caretaker and hears of nobody.
  virtual bool is_shared() const = 0;
  // From now on takes part in choosing a caretaker, and calls `heard`, on threads of the store's, soon after something
  // was told: within milliseconds, or, where words were lost, kNewsWithin. Once.
  virtual void Follow(std::function<void(const News&)> heard) = 0;
  // Ends that: when it returns no call is under way, and another process becomes the caretaker. Repeating is harmless.
  virtual void StopFollowing() = 0;
  // Whether this process is the one that does what one alone has to do: look at machines, run routines, send webhooks.
  // Each such step is sound in the store where two believe it for a moment.
  virtual bool IsCaretaker() = 0;
  // Has all processes hear of a machine that must be looked at; without one: of all routines. Never waits for the
  // store.
  virtual void TellOthers(const std::optional<MachineId>& machine) = 0;

  // Schema version of the file, for GetServerInfo.
  virtual int schema_version() const = 0;

  // ---- marks of people in histories
  // Repeatable by its request id. INVALID_ARGUMENT MARK_INVALID: a time before 1970 or in the future.
  virtual absl::StatusOr<Mark> PutMark(const NewMark& mark, const Caller& caller) = 0;
  // It counts no more, and stays in lists. Repeating is OK. NOT_FOUND MARK_NOT_FOUND.
  virtual absl::StatusOr<Mark> WithdrawMark(MarkId id, const Caller& caller) = 0;
  // Newest first, withdrawn ones too.
  virtual absl::StatusOr<Page<Mark>> ListMarks(const MachineId& machine, const PageRequest& page) = 0;

  // ---- compensation tables that controls may have
  // A table of the calibration was handed out to the caller; the newest of a format stands for those before. NOT_FOUND
  // CALIBRATION_NOT_FOUND.
  virtual absl::Status NoteHandedTable(CalibrationId calibration, const std::string& format, const Caller& caller) = 0;
  // Of all calibrations of the machine, retired ones too: in their order, those of one by name of the format.
  // NOT_FOUND MACHINE_NOT_FOUND.
  virtual absl::StatusOr<std::vector<HandedTable>> ListHandedTables(const MachineId& machine) = 0;

  // ---- cells beside machines
  // The newest report of a machine and name stands for those before. RESOURCE_EXHAUSTED TOO_MANY_CELLS: 16 of a
  // machine.
  virtual absl::StatusOr<CellRecord> ReportCell(const CellReport& report, const Caller& caller) = 0;
  // Newest first; of no machine that was deleted.
  virtual absl::StatusOr<Page<CellRecord>> ListCells(const std::optional<MachineId>& machine, const PageRequest& page,
                                                     const Visible& visible) = 0;
  // NOT_FOUND CELL_NOT_FOUND.
  virtual absl::Status ForgetCell(const MachineId& machine, const std::string& name, const Caller& caller) = 0;
  virtual absl::StatusOr<CellSums> SumCells() = 0;

  // ---- what is expected of machines, and events (only server/watch raises and clears them)
  // Of a machine for which none were set: empty, etag 0.
  virtual absl::StatusOr<ExpectationsRecord> GetExpectations(const MachineId& machine) = 0;
  // ABORTED ETAG_MISMATCH unless `expected_etag` is 0 or what is there. The same again changes nothing.
  virtual absl::StatusOr<ExpectationsRecord> SetExpectations(const Expectations& expected, int64_t expected_etag,
                                                             const Caller& caller) = 0;
  // NOT_FOUND EVENT_NOT_FOUND.
  virtual absl::StatusOr<Event> GetEvent(EventId id) = 0;
  virtual absl::StatusOr<Page<Event>> ListEvents(const EventFilter& filter, const PageRequest& page,
                                                 const Visible& visible) = 0;
  // How many events of a machine stand that are neither shelved nor acknowledged: of the machines with most of them.
  virtual absl::StatusOr<std::vector<std::pair<MachineId, int64_t>>> MachinesWithEvents(int most) = 0;
  // Those that are not cleared, and steps that a person's word has cleared.
  virtual absl::StatusOr<std::vector<Event>> StandingEvents(const MachineId& machine) = 0;
  // The first word stays: repeating is OK and changes nothing. A step, which stays in the history, is cleared by it.
  virtual absl::StatusOr<Event> AcknowledgeEvent(EventId id, const std::string& note, const Caller& caller) = 0;
  // Until then, or back at once where `until` is absent. INVALID_ARGUMENT EVENT_INVALID: a time that is over, or more
  // than a year ahead; FAILED_PRECONDITION EVENT_CLEARED.
  virtual absl::StatusOr<Event> ShelveEvent(EventId id, std::optional<UtcTime> until, const std::string& note,
                                            const Caller& caller) = 0;
  // Those whose time on the shelf is over; how many.
  virtual absl::StatusOr<int> BringBackEvents() = 0;
  // How many events it has changed: what was cleared or raised meanwhile is passed over.
  virtual absl::StatusOr<int> ChangeEvents(const EventChanges& changes) = 0;
  // In order, from the first after `after` on. OUT_OF_RANGE CHANGE_UNKNOWN where there was never so great a number: the
  // database is an older one than that which gave it.
  virtual absl::StatusOr<EventChangePage> ReadEventChanges(int64_t after, const std::optional<MachineId>& machine,
                                                           const Visible& visible) = 0;
  // The number of the newest; 0: there is none.
  virtual absl::StatusOr<int64_t> LastEventChange() = 0;
  virtual absl::StatusOr<LookStand> GetLookStand(const MachineId& machine) = 0;
  // What there is to say of each machine at a glance, in the order of their names; no deleted ones.
  virtual absl::StatusOr<Page<MachineCare>> ListCare(const PageRequest& page, const Visible& visible) = 0;
  // Machines that have changed since they were looked at last, or were looked at by another version than this, and
  // those of which sessions or young calibrations are expected. No deleted ones.
  virtual absl::StatusOr<std::vector<MachineId>> MachinesToLookAt(const std::string& version) = 0;
  // When the newest complete session of that name was measured, or came where its file does not say; nothing where
  // there is none.
  virtual absl::StatusOr<std::optional<UtcTime>> NewestSession(const MachineId& machine, const std::string& name) = 0;

  // ---- routines (docs/routines.md; server/routines runs them)
  // Makes one, or replaces the one of that name; an equal one stays as it is. `expected_etag` 0: whatever is there,
  // else ABORTED ETAG_MISMATCH. Sessions that were begun before a routine was made, enabled again, or given another
  // scope or other sessions are none of its business. NOT_FOUND PRINCIPAL_NOT_FOUND, MACHINE_NOT_FOUND, GROUP_NOT_FOUND
  // (a group without a machine is none), FAILED_PRECONDITION PRINCIPAL_REVOKED, RESOURCE_EXHAUSTED TOO_MANY_ROUTINES.
  virtual absl::StatusOr<RoutineRecord> PutRoutine(const Routine& routine, int64_t expected_etag,
                                                   const Caller& caller) = 0;
  // Its runs stay; its name is free again. As it was. NOT_FOUND ROUTINE_NOT_FOUND; so below.
  virtual absl::StatusOr<RoutineRecord> RemoveRoutine(const std::string& name, int64_t expected_etag,
                                                      const Caller& caller) = 0;
  // Whether a routine begins nothing on one machine. Repeating is OK.
  virtual absl::StatusOr<RoutineRecord> StopRoutine(const std::string& name, const MachineId& machine, bool stops,
                                                    const std::string& note, const Caller& caller) = 0;
  // All, in order of names: those that work for a machine that may be seen.
  virtual absl::StatusOr<std::vector<RoutineRecord>> ListRoutines(const Visible& visible) = 0;
  // Those for which an enabled routine works, and those on which a run is open.
  virtual absl::StatusOr<std::vector<MachineId>> MachinesWithRoutines() = 0;
  // Those that work for this machine, enabled, stopped or not.
  virtual absl::StatusOr<std::vector<RoutineRecord>> RoutinesOf(const MachineId& machine) = 0;
  // The newest run of each routine on this machine, and what is open of routines that were removed.
  virtual absl::StatusOr<std::vector<RoutineRun>> NewestRuns(const MachineId& machine) = 0;
  // The newest complete session of that name that a routine has not used yet, and that is not older than it.
  virtual absl::StatusOr<std::optional<NamedSession>> NewSessionFor(RoutineId routine, const MachineId& machine,
                                                                    const std::string& name) = 0;
  // A run that waits, of the routine as it stands: ABORTED ETAG_MISMATCH where it has changed.
  virtual absl::StatusOr<RoutineRun> BeginRun(const RoutineRecord& routine, const MachineId& machine,
                                              const std::vector<SessionId>& sessions,
                                              const std::vector<SessionId>& check_sessions) = 0;
  virtual absl::StatusOr<RoutineRun> ChangeRun(const RunChange& change) = 0;
  // A new run on the sessions of the newest one. FAILED_PRECONDITION RUN_NOT_FAILED unless that failed or was stopped.
  virtual absl::StatusOr<RoutineRun> RetryRoutine(const std::string& name, const MachineId& machine,
                                                  const Caller& caller) = 0;
  // Newest first.
  virtual absl::StatusOr<Page<RoutineRun>> ListRuns(const RunFilter& filter, const PageRequest& page,
                                                    const Visible& visible) = 0;

  // ---- webhooks (docs/events.md; server/webhooks sends)
  // Makes one, which begins with what happens after that, or changes the one of that name; an equal one stays as it is.
  // `expected_etag` as in PutRoutine(). NOT_FOUND MACHINE_NOT_FOUND, GROUP_NOT_FOUND, RESOURCE_EXHAUSTED
  // TOO_MANY_WEBHOOKS.
  virtual absl::StatusOr<WebhookRecord> PutWebhook(const Webhook& webhook, const NewSecret& secret,
                                                   int64_t expected_etag, const Caller& caller) = 0;
  // With its dead letters. As it was. NOT_FOUND WEBHOOK_NOT_FOUND; so below.
  virtual absl::StatusOr<WebhookRecord> RemoveWebhook(const std::string& name, int64_t expected_etag,
                                                      const Caller& caller) = 0;
  virtual absl::StatusOr<WebhookRecord> GetWebhook(const std::string& name) = 0;
  // All, in order of names.
  virtual absl::StatusOr<std::vector<WebhookRecord>> ListWebhooks() = 0;
  // Whether it was written down: not where the webhook was changed or removed meanwhile, or is elsewhere already.
  virtual absl::StatusOr<bool> StepWebhook(const WebhookStep& step) = 0;
  // Newest first.
  virtual absl::StatusOr<Page<DeadLetter>> ListDeadLetters(const std::string& name, const PageRequest& page) = 0;
  // That one, or all of them, shall be tried once more; how many. NOT_FOUND DEAD_LETTER_NOT_FOUND.
  virtual absl::StatusOr<int64_t> ResendDeadLetters(const std::string& name, std::optional<int64_t> change,
                                                    const Caller& caller) = 0;
  // The oldest dead letter that shall be tried once more, if there is one.
  virtual absl::StatusOr<std::optional<EventChange>> WantedLetter(WebhookId webhook) = 0;
  // What came of that; `error` empty: it was taken, and is no dead letter any more.
  virtual absl::StatusOr<bool> EndWantedLetter(WebhookId webhook, int64_t change, const std::string& error) = 0;

  // ---- after the store went away
  // RUNNING jobs that were claimed here and are none of `held` go back to QUEUED at once, the attempt not counted: the
  // answer to the claim, or the outcome, was lost on its way. What changed.
  virtual absl::StatusOr<std::vector<JobRecord>> ReturnJobs(const std::vector<JobClaim>& held) = 0;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_DATABASE_H_
