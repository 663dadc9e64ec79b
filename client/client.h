// The client library of Axiscal, for shop-floor cells, MES systems and the command line: core types in and out.
//
//   ASSIGN_OR_RETURN(client::Client client, client::Client::Connect("axiscal.shop:7410", {.user = "cell-7"}));
//   ASSIGN_OR_RETURN(client::UploadResult upload, client.Upload(MachineId("mt"), session));
//
// Every call has a deadline, waits for the server to be there, and is tried again with backoff while the answer is
// UNAVAILABLE. A failed call changed nothing. Errors are the server's: code, text, and base::GetErrorDetail with its
// reason (SEQ_GAP) and facts (field, next_seq); texts end in "[REASON]". No connection: UNAVAILABLE, reason
// NO_CONNECTION. An answer that cannot be read: INTERNAL. Calls that create take a request_id: the same id again
// returns what was made then, so a call may be repeated after a crash. An empty one is made up for the call. Safe from
// any thread. All calls block.
#ifndef AXISCAL_CLIENT_CLIENT_H_
#define AXISCAL_CLIENT_CLIENT_H_

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "client/options.h"
#include "core/base/ids.h"
#include "core/base/status.h"
#include "core/records/access.h"
#include "core/records/calibration.h"
#include "core/records/care.h"
#include "core/records/cell.h"
#include "core/records/diagnosis.h"
#include "core/records/drift.h"
#include "core/records/event.h"
#include "core/records/history.h"
#include "core/records/job.h"
#include "core/records/job_params.h"
#include "core/records/log.h"
#include "core/records/machine.h"
#include "core/records/mark.h"
#include "core/records/page.h"
#include "core/records/program.h"
#include "core/records/routine.h"
#include "core/records/session.h"
#include "core/records/table.h"
#include "core/records/volumetric.h"
#include "core/records/webhook.h"
#include "core/session/session.h"

namespace grpc {
class Channel;
}

namespace axiscal::client {

// Of a record, fields that do not travel are left empty.
using records::CalibrationFilter;
using records::CalibrationRecord;
using records::DriftQuery;
using records::DriftSeries;
using records::FleetRow;
using records::JobRecord;
using records::JobState;
using records::MachineAccess;
using records::MachineRecord;
using records::Page;
using records::PageRequest;
using records::PrincipalRecord;
using records::ProgramRecord;
using records::SessionRecord;
using records::TokenRecord;

// A token's secret is handed out once.
struct NewToken {
  std::string secret;
  TokenRecord record;
};

struct NewWebhook {
  records::WebhookRecord record;
  std::string secret;  // that letters are signed with, shown once; empty where it is not new
};

// An entry of the audit, texts as proto/axiscal/v1/access_service.proto has them.
struct AuditEntry {
  int64_t number = 0;
  base::UtcTime at;
  std::string principal, peer, action, resource, outcome, was, became, detail;
};

struct AuditFilter {
  std::optional<base::UtcTime> from, to;  // at or after, before
  std::string principal, resource;        // empty: any
};

// The last entry's number and hash.
struct AuditHead {
  int64_t last_entry = 0;
  std::string sha256;
};

// A copy of the server's database.
struct Backup {
  std::string file;  // its name in the server's folder; empty when it was sent
  int64_t size_bytes = 0;
  std::string sha256;
  int64_t damage_count = 0;                                  // 0: it is whole
  std::vector<std::pair<std::string, std::string>> damages;  // the first: what, and what is wrong with it
};

struct UploadResult {
  SessionRecord session;         // COMPLETE
  bool was_there = false;        // the same session had been uploaded before: nothing was sent
  int64_t duplicate_chunks = 0;  // sent again although the server had them
  int interruptions = 0;
};

struct SessionFilter {
  std::optional<MachineId> machine;
  std::optional<records::SessionState> state;
  records::TimeSpan measured = {};  // or created, where its file does not say
  std::string instrument = {};      // empty: any
  std::string name = {};            // empty: any
  std::string label = {};           // empty: any
};

struct JobUrgency {
  int priority = 0;                            // -10 .. 10, higher ones first
  std::optional<base::UtcTime> deadline = {};  // what has not ended by then fails
};

struct JobFilter {
  std::optional<MachineId> machine;
  std::optional<JobState> state;
  records::TimeSpan created = {};
  std::string kind = {};  // "identify", "close_loop", "compensate", "tool_setter"; empty: any
};

struct Diagnosis {
  std::vector<records::Finding> findings;
  base::UtcTime now;  // of the server's clock
};

struct ServerInfo {
  std::string software_version;
  int schema_version = 0;
  int open_uploads = 0, max_uploads = 0;
  int workers = 0;
  bool draining = false;
};

class Client {
 public:
  // `address` as gRPC takes it: "127.0.0.1:7410", "unix:/run/axiscal.sock". UNAVAILABLE (NO_CONNECTION) when the server
  // is not there in time.
  static absl::StatusOr<Client> Connect(const std::string& address, const Options& options = {});
  // Over a channel to a server in this process.
  static absl::StatusOr<Client> InProcess(std::shared_ptr<grpc::Channel> channel, const Options& options = {});
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;
  ~Client();

  // ---- machines; descriptions are machine.json texts
  // The same description again returns the stored machine; another one under the same id is ALREADY_EXISTS
  // MACHINE_EXISTS.
  absl::StatusOr<MachineRecord> CreateMachine(const std::string& description_json);
  absl::StatusOr<MachineRecord> GetMachine(const MachineId& id);
  // An earlier revision of its description: what a calibration was fitted with.
  absl::StatusOr<MachineRecord> GetMachineRevision(const MachineId& id, int64_t revision);
  absl::StatusOr<Page<MachineRecord>> ListMachines(const PageRequest& page = {});
  // `etag` is the revision that was edited; ABORTED ETAG_MISMATCH when it is no longer the present one.
  absl::StatusOr<MachineRecord> UpdateMachine(const std::string& description_json, int64_t etag);
  absl::StatusOr<MachineRecord> DeleteMachine(const MachineId& id, int64_t etag);

  // ---- sessions
  // Stores a whole session durably: chunks as options say, resumed where the server stands when the stream breaks. The
  // request id is the session's content, so the same session is stored once, whoever crashed in between. `progress` is
  // called on this thread.
  absl::StatusOr<UploadResult> Upload(const MachineId& machine, const session::Session& session,
                                      const ProgressCallback& progress = nullptr);
  // A controller's log as it is: reduced by the server, and kept there beside its session. `name` is its file's,
  // without folders. The request id is the content, so that the same log is stored once. INVALID_ARGUMENT LOG_INVALID,
  // with line and column as facts, where it is wrong; nothing is stored then.
  absl::StatusOr<records::StoredLog> PutLog(const MachineId& machine, const std::string& name, const std::string& bytes,
                                            const records::LogForm& form);
  // With header and columns.
  absl::StatusOr<SessionRecord> GetSession(SessionId id);
  // Newest first, without header and columns.
  absl::StatusOr<Page<SessionRecord>> ListSessions(const SessionFilter& filter = {}, const PageRequest& page = {});
  absl::StatusOr<SessionRecord> AbortSession(SessionId id);
  // Replaces note and labels. `etag`: of the remark as it was read, 0: whatever is there.
  absl::StatusOr<SessionRecord> AnnotateSession(SessionId id, const std::string& note,
                                                const std::vector<std::string>& labels, int64_t etag = 0);
  // Whether it counts, and why. What stands on it is marked.
  struct RejectedSession {
    SessionRecord session;
    std::vector<CalibrationId> calibrations;
  };
  absl::StatusOr<RejectedSession> RejectSession(SessionId id, bool is_rejected, const std::string& reason);
  absl::StatusOr<session::Session> DownloadSession(SessionId id);

  // ---- jobs
  absl::StatusOr<JobRecord> CreateJob(const records::JobParams& params, const std::string& request_id = "",
                                      const JobUrgency& urgency = {});
  absl::StatusOr<JobRecord> GetJob(JobId id);
  // Newest first.
  // Newest first, without reports (GetJob has them).
  absl::StatusOr<Page<JobRecord>> ListJobs(const JobFilter& filter = {}, const PageRequest& page = {});
  absl::StatusOr<JobRecord> CancelJob(JobId id);
  absl::StatusOr<JobRecord> RequeueJob(JobId id);
  // As it stands when it has ended or `timeout` is over.
  absl::StatusOr<JobRecord> WaitJob(JobId id, std::chrono::milliseconds timeout);
  // Calls `on_change` with the job now and after each change until it has ended; returns it as it ended. `on_change`
  // returning false ends the watch early (the job goes on). Resumes over a restart of the server.
  absl::StatusOr<JobRecord> WatchJob(JobId id, const std::function<bool(const JobRecord&)>& on_change);

  // ---- calibrations
  // Newest first, without JSON texts.
  absl::StatusOr<Page<CalibrationRecord>> ListCalibrations(const CalibrationFilter& filter = {},
                                                           const PageRequest& page = {});
  absl::StatusOr<CalibrationRecord> GetCalibration(CalibrationId id);
  // NOT_FOUND CALIBRATION_NOT_FOUND when the machine has none.
  absl::StatusOr<CalibrationRecord> GetApprovedCalibration(const MachineId& machine);
  // Puts it in use; the machine's former one retires. Approving an older version is the way back. ABORTED
  // ETAG_MISMATCH. `reason`: why, kept in the audit, at most 200 bytes of UTF-8 without control characters; may be
  // empty.
  absl::StatusOr<CalibrationRecord> ApproveCalibration(CalibrationId id, int64_t etag, const std::string& reason = "");
  // Takes it out of use, or gives a candidate up; likewise.
  absl::StatusOr<CalibrationRecord> RetireCalibration(CalibrationId id, int64_t etag, const std::string& reason = "");

  // How far the tool point is off over a box of positions, before and after a calibration: its measured box, `box` of
  // some axes (as of a part), or that in which the program of the COMPENSATE job `job` moves. FAILED_PRECONDITION
  // VOLUMETRIC_UNKNOWN where nothing is known of how good its errors are.
  absl::StatusOr<records::VolumetricError> GetVolumetricError(CalibrationId id,
                                                              const std::vector<records::AxisSpan>& box = {},
                                                              std::optional<JobId> job = {});
  // Of each calibration of a machine that is or was in use or is a candidate, the newest first; 20 on a page, at most
  // 100.
  absl::StatusOr<Page<records::VolumetricError>> ListVolumetricErrors(const MachineId& machine,
                                                                      const std::vector<records::AxisSpan>& box = {},
                                                                      const PageRequest& page = {});

  // ---- programs, byte for byte; resumed when the stream breaks
  absl::StatusOr<ProgramRecord> PutProgram(const std::string& name, const std::string& bytes,
                                           const ProgressCallback& progress = nullptr);
  // From a file, in constant memory. NOT_FOUND when it cannot be read.
  absl::StatusOr<ProgramRecord> PutProgramFile(const std::string& path, const ProgressCallback& progress = nullptr);
  absl::StatusOr<std::string> GetProgram(ProgramId id, const ProgressCallback& progress = nullptr);
  // In constant memory: `take` gets the bytes in order; its error ends the call and is returned. DATA_LOSS when the
  // checksum does not fit at the end: then what was taken must not be used.
  absl::StatusOr<ProgramRecord> GetProgram(ProgramId id,
                                           const std::function<absl::Status(const std::string& bytes)>& take,
                                           const ProgressCallback& progress = nullptr);
  // Rewrites a program for the machine's calibration while it is sent; nothing is stored. `take` gets the rewritten
  // bytes in order, its error ends the call and is returned; they must not be used unless this returns OK. The report,
  // JSON, as a COMPENSATE job's result. FAILED_PRECONDITION with the engine's words when a block cannot be corrected;
  // RESOURCE_EXHAUSTED QUEUE_FULL; DATA_LOSS when what came does not fit its checksum. Not tried again by itself.
  absl::StatusOr<std::string> RewriteProgram(const records::CompensateParams& params, const std::string& bytes,
                                             const std::function<absl::Status(const std::string& bytes)>& take);
  // From a file, in constant memory. NOT_FOUND when it cannot be read.
  absl::StatusOr<std::string> RewriteProgramFile(const records::CompensateParams& params, const std::string& path,
                                                 const std::function<absl::Status(const std::string& bytes)>& take);
  absl::StatusOr<Page<ProgramRecord>> ListPrograms(const PageRequest& page = {});

  // ---- compensation tables, made of the approved calibration or a named one (docs/tables.md)
  absl::StatusOr<records::MadeTable> MakeTable(const records::TableParams& params);
  // The formats that the server knows.
  absl::StatusOr<std::vector<records::TableFormat>> ListTableFormats();

  // ---- history
  absl::StatusOr<std::vector<DriftSeries>> QueryDrift(const DriftQuery& query);
  // What happened to a machine, in words, and when errors leave their limits (docs/drift.md).
  absl::StatusOr<records::DriftReport> FindDrift(const records::DriftSearch& search);
  // What each machine needs, at a glance, in the order of their names.
  absl::StatusOr<Page<records::MachineCare>> ListCare(const PageRequest& page = {});
  // What has happened to a machine, as a person says it: it ends what its history said before.
  absl::StatusOr<records::Mark> PutMark(const records::NewMark& mark, const std::string& request_id = "");
  // Newest first, withdrawn ones too.
  absl::StatusOr<Page<records::Mark>> ListMarks(const MachineId& machine, const PageRequest& page = {});
  // One that was a mistake counts no more.
  absl::StatusOr<records::Mark> WithdrawMark(MarkId id);
  // The newest estimate of each symbol (none named: all) of every machine.
  absl::StatusOr<Page<FleetRow>> LatestFleet(const std::vector<std::string>& symbols, const PageRequest& page = {});

  // ---- what is expected of machines, and events (docs/events.md)
  absl::StatusOr<records::ExpectationsRecord> GetExpectations(const MachineId& machine);
  // Replaces all of it. `etag` is what was edited, 0: whatever is there; ABORTED ETAG_MISMATCH.
  absl::StatusOr<records::ExpectationsRecord> SetExpectations(const records::Expectations& expected, int64_t etag = 0);
  // Newest first.
  absl::StatusOr<Page<records::Event>> ListEvents(const records::EventFilter& filter = {},
                                                  const PageRequest& page = {});
  // Calls `on_news` with every change of an event, once and in order: those after change `after` (0: from the
  // beginning; absent: from now on), of one machine or of all that the caller may see. First, and where nothing has
  // happened for long, without a change: then `up_to` alone is news. Keep it, and go on from it after a crash of your
  // own. Ends when `on_news` returns false; resumes over restarts of the server without a gap and without giving a
  // change twice. OUT_OF_RANGE CHANGE_UNKNOWN where the server's database is older than `after`.
  absl::Status WatchEvents(const std::optional<MachineId>& machine, std::optional<int64_t> after,
                           const std::function<bool(const records::EventNews&)>& on_news);
  // `note` may not be empty.
  absl::StatusOr<records::Event> AcknowledgeEvent(EventId id, const std::string& note);
  // Absent: it is back at once.
  absl::StatusOr<records::Event> ShelveEvent(EventId id, const std::optional<base::UtcTime>& until,
                                             const std::string& note = "");

  // ---- what runs by itself when sessions have come (docs/routines.md)
  // Makes it, or replaces the one of that name. `etag` as in SetExpectations(). For admins of all machines; so the
  // next.
  absl::StatusOr<records::RoutineRecord> PutRoutine(const records::Routine& routine, int64_t etag = 0);
  absl::StatusOr<records::RoutineRecord> RemoveRoutine(const std::string& name, int64_t etag = 0);
  // In order of names: those that work for a machine, or for any that the caller may see.
  absl::StatusOr<std::vector<records::RoutineRecord>> ListRoutines(const std::optional<MachineId>& machine = {});
  // Whether it begins nothing on one machine; what it runs there is stopped.
  absl::StatusOr<records::RoutineRecord> StopRoutine(const std::string& name, const MachineId& machine, bool stopped,
                                                     const std::string& note = "");
  // Again on the sessions of its newest run there, which failed or was stopped; else FAILED_PRECONDITION
  // RUN_NOT_FAILED.
  absl::StatusOr<records::RoutineRun> RetryRoutine(const std::string& name, const MachineId& machine);
  // Newest first.
  absl::StatusOr<Page<records::RoutineRun>> ListRoutineRuns(const records::RunFilter& filter = {},
                                                            const PageRequest& page = {});

  // ---- addresses that are told of events (docs/events.md); all for admins of all machines
  // Makes it, or changes the one of that name; `new_secret`: another one takes the place of its secret.
  absl::StatusOr<NewWebhook> PutWebhook(const records::Webhook& webhook, bool new_secret = false, int64_t etag = 0);
  absl::StatusOr<records::WebhookRecord> RemoveWebhook(const std::string& name, int64_t etag = 0);
  // In order of names; without ids and secrets.
  absl::StatusOr<std::vector<records::WebhookRecord>> ListWebhooks();
  // Sends a test letter and says what came of it.
  absl::StatusOr<records::WebhookTrial> TestWebhook(const std::string& name);
  // Newest first.
  absl::StatusOr<Page<records::DeadLetter>> ListDeadLetters(const std::string& name, const PageRequest& page = {});
  // That one, or all, are tried once more; how many.
  absl::StatusOr<int64_t> ResendDeadLetters(const std::string& name, std::optional<int64_t> change = {});

  // ---- who may do what: all but GetIdentity() for admins of all machines
  // Whom the server takes this client for: name and roles.
  absl::StatusOr<PrincipalRecord> GetIdentity();
  absl::StatusOr<PrincipalRecord> CreatePrincipal(const std::string& name, const std::string& note = "");
  // With its tokens, for ever.
  absl::StatusOr<PrincipalRecord> RevokePrincipal(const std::string& name);
  absl::StatusOr<Page<PrincipalRecord>> ListPrincipals(const PageRequest& page = {});
  absl::StatusOr<NewToken> CreateToken(const std::string& principal, const std::string& note = "",
                                       const std::optional<base::UtcTime>& expires_at = std::nullopt);
  absl::StatusOr<TokenRecord> RevokeToken(int64_t id);
  absl::StatusOr<PrincipalRecord> ChangeRole(const std::string& principal, const records::Grant& grant, bool holds);
  absl::StatusOr<MachineAccess> ChangeGroup(const std::string& group, const MachineId& machine, bool belongs);
  // Whether another person must approve a calibration of the machine than the one that identified it.
  absl::StatusOr<MachineAccess> SetFourEyes(const MachineId& machine, bool four_eyes);
  absl::StatusOr<Page<MachineAccess>> ListMachineAccess(const PageRequest& page = {});
  // Who changed what, and which calls were denied; newest first.
  absl::StatusOr<Page<AuditEntry>> ListAudit(const AuditFilter& filter = {}, const PageRequest& page = {});
  // DATA_LOSS AUDIT_DAMAGED names the first entry that was changed or is missing.
  absl::StatusOr<AuditHead> CheckAudit();

  // ---- the server
  absl::StatusOr<ServerInfo> GetServerInfo();
  // What is well on the server's side and what is not. For viewers of all machines.
  absl::StatusOr<Diagnosis> Diagnose();
  // What is written to the server's log from now on, until its next start; without `level` it stays. What it was, and
  // is.
  absl::StatusOr<std::pair<records::LogLevel, records::LogLevel>> SetLogLevel(std::optional<records::LogLevel> level);

  // ---- cells beside machines (docs/cell.md)
  // How one stands; the newest word of a machine and name counts.
  absl::StatusOr<records::CellRecord> ReportCell(const records::CellReport& report);
  absl::StatusOr<Page<records::CellRecord>> ListCells(const std::optional<MachineId>& machine,
                                                      const PageRequest& page = {});
  // One that is no longer there. NOT_FOUND CELL_NOT_FOUND.
  absl::Status ForgetCell(const MachineId& machine, const std::string& name);

  // Made while others write. With `take`, which gets its bytes in order, it is sent (DATA_LOSS when the checksum does
  // not fit at the end); else it stays in the server's folder. For admins of all machines.
  absl::StatusOr<Backup> MakeBackup(const std::function<absl::Status(const std::string& bytes)>& take = nullptr);
  // OK while the server takes work, UNAVAILABLE (DRAINING) while it stops.
  absl::Status CheckHealth();

 private:
  class Impl;
  explicit Client(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_CLIENT_H_
