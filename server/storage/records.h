// What the store is given and answers beside the records of core/records: who asks, what is new, the right to write a
// running job. Texts named `..._json` and byte strings named `params`, `result` are opaque to it.
#ifndef AXISCAL_SERVER_STORAGE_RECORDS_H_
#define AXISCAL_SERVER_STORAGE_RECORDS_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/access.h"
#include "core/records/calibration.h"
#include "core/records/care.h"
#include "core/records/cell.h"
#include "core/records/drift.h"
#include "core/records/event.h"
#include "core/records/history.h"
#include "core/records/job.h"
#include "core/records/machine.h"
#include "core/records/mark.h"
#include "core/records/page.h"
#include "core/records/program.h"
#include "core/records/routine.h"
#include "core/records/session.h"
#include "core/records/table.h"
#include "core/records/webhook.h"
#include "core/session/session.h"

namespace axiscal::storage {

using base::UtcTime;
// Inside the store they go by their bare names.
using records::CalibrationFilter;
using records::CalibrationRecord;
using records::CalibrationState;
using records::CellRecord;
using records::CellReport;
using records::ColumnSpec;
using records::DeadLetter;
using records::DriftKind;
using records::DriftPoint;
using records::DriftQuery;
using records::DriftSeries;
using records::Estimate;
using records::EstimateUnit;
using records::Event;
using records::EventChange;
using records::EventChangeKind;
using records::EventContent;
using records::EventFilter;
using records::EventKind;
using records::Expectations;
using records::ExpectationsRecord;
using records::FleetRow;
using records::Grant;
using records::HandedTable;
using records::IsTerminal;
using records::JobError;
using records::JobProgress;
using records::JobRecord;
using records::JobState;
using records::LatestEstimate;
using records::MachineAccess;
using records::MachineCare;
using records::MachineRecord;
using records::Mark;
using records::NewCalibration;
using records::NewMark;
using records::Page;
using records::PageRequest;
using records::PrincipalRecord;
using records::ProgramRecord;
using records::ProgramState;
using records::Routine;
using records::RoutineRecord;
using records::RoutineRun;
using records::RoutineStop;
using records::RunFilter;
using records::RunState;
using records::SessionRecord;
using records::SessionState;
using records::SessionTotals;
using records::StandingFinding;
using records::TimeSpan;
using records::TokenRecord;
using records::Webhook;
using records::WebhookRecord;

// When something happens: for people, by a clock that may be set; and for how long, as microseconds that a server has
// had the file open (up_time.h).
struct Moment {
  UtcTime utc;
  int64_t up_us = 0;
};

// Who asks: `principal` scopes request ids (of jobs and programs; a session is the same for all) and is written to the
// audit; `request_id` (any text, best a UUID) makes a call repeatable. An empty request_id means that every call is a
// new one.
struct Caller {
  std::string principal;
  std::string request_id;
  std::string peer = {};    // from where, for the audit
  std::string reason = {};  // why, in the caller's words, for the audit
};

// ---- sessions

struct NewSession {
  MachineId machine;
  std::string name;        // the user's own name of the session ("CR"); need not be unique
  std::string instrument;  // "ballbar", "centres", ...
  std::vector<session::HeaderEntry> header;
  std::vector<ColumnSpec> columns;
  std::optional<UtcTime> measured_at;  // when it was measured, if the file says so
  Caller caller;
};

struct AppendResult {
  int64_t next_seq = 0;    // the first seq that is not durable yet
  bool duplicate = false;  // this chunk was there already, with equal content
};

// A session of which a person has said whether it counts, and the calibrations that stand on it.
struct RejectedSession {
  SessionRecord session;
  std::vector<CalibrationId> calibrations;
};

struct SessionFilter {
  std::optional<MachineId> machine;
  std::optional<SessionState> state;
  TimeSpan measured = {};       // or created, where its file does not say
  std::string instrument = {};  // empty: any
  std::string name = {};        // empty: any
  std::string label = {};       // empty: any
};

// ---- jobs

struct NewJob {
  std::string kind;                      // "identify", "compensate", ...
  std::optional<MachineId> machine;      // the machine it works on, for lists
  std::optional<ProgramId> program;      // that it rewrites: whoever sees the machine sees it from then on
  std::string params;                    // what the kind's function needs, opaque
  std::string input_hash;                // of all inputs and the engine's version; empty: not comparable
  int priority = 0;                      // larger runs first
  int max_attempts = 3;                  // that fail; those lost with their process are not among them
  std::optional<UtcTime> deadline = {};  // what has not ended by then fails
  Caller caller;
  std::string trace = {};  // traceparent of the call that creates it; empty: none
};

// Jobs of this moment.
struct JobQueue {
  int64_t queued = 0, running = 0;
  std::optional<UtcTime> oldest_queued;  // when the oldest of the waiting ones was created
};

// Cells beside machines, of this moment; one that serves several machines counts once.
struct CellSums {
  int64_t well = 0, silent = 0, with_problem = 0;                       // a silent one is not asked for its problem
  int64_t waiting_files = 0, waiting_bytes = 0, quarantined_files = 0;  // of all spools
};

// How many jobs there may be. More are refused with RESOURCE_EXHAUSTED QUEUE_FULL.
struct JobRoom {
  JobRoom(int waiting, int principal = 0, int machine = 0)  // NOLINT: a number alone is how many may wait
      : max_waiting(waiting), max_of_principal(principal), max_of_machine(machine) {}

  int max_waiting;       // of all
  int max_of_principal;  // of one principal, waiting and running; 0: no limit. Logins ("local:ann") have none.
  int max_of_machine;    // of one machine, waiting and running; 0: no limit
};

// The right to write a running job: a stale token is refused with ABORTED, LEASE_LOST.
struct JobClaim {
  JobId id;
  int64_t lease_token = 0;  // JobRecord::running_attempt of the attempt that holds the lease
};
inline JobClaim ClaimOf(const JobRecord& job) { return {job.id, job.running_attempt}; }

struct JobFilter {
  std::optional<MachineId> machine;
  std::optional<JobState> state;
  std::string input_hash;  // empty: any
  TimeSpan created = {};
  std::string kind = {};  // empty: any
};

// ---- programs

struct NewProgram {
  std::string kind;  // as of a ProgramRecord
  std::string name;  // file name, informative
  Caller caller;
  std::optional<MachineId> machine = std::nullopt;  // whoever sees it sees the program
};

struct ProgramFilter {
  std::string kind;  // empty: any
};

// What a job leaves behind, stored with its success in one transaction.
struct JobProduct {
  std::string result;
  std::optional<NewCalibration> calibration;
  std::vector<ProgramId> programs;  // complete ones
};

// ---- access

// What a list may show. By default everything; else rows of the machines in these scopes, and programs that this
// principal sent.
struct Visible {
  bool everything = true;
  std::vector<records::Scope> scopes;
  std::string principal;
};

struct NewToken {
  std::string principal;
  std::string sha256;  // of the token, which is not stored
  std::string note;
  std::optional<UtcTime> expires_at;
};

// Whom a token or the name of a certificate stands for.
struct Holder {
  std::string principal;
  bool is_revoked = false;  // it, or its token
  std::vector<Grant> grants;
  std::optional<int64_t> token;
  std::optional<UtcTime> token_expires_at, token_last_used_at;
};

enum class ResourceKind { kMachine, kSession, kJob, kCalibration, kProgram, kMark, kEvent };

// One row, as a call names it: a machine by its name, others by their number.
struct Resource {
  ResourceKind kind = ResourceKind::kMachine;
  std::string name;
  int64_t number = 0;

  auto operator<=>(const Resource&) const = default;
};

// To which machines a row belongs: a program to those that it was rewritten for, others to theirs.
struct Belonging {
  std::vector<MachineAccess> machines;
  bool is_own = false;     // a program that the principal sent
  std::string created_by;  // of sessions, jobs and calibrations
};

// ---- events

// How a machine stands for whoever looks for events: how often what they follow from has changed, and how often it had
// when it was looked at last, by which version.
struct LookStand {
  int64_t changes = 0, looked_at = 0;
  std::string looked_by;
};

// What a look at a machine has found, stored in one transaction.
struct EventChanges {
  struct Update {
    EventId event;
    EventContent content;
  };
  struct Clearing {
    EventId event;
    std::string why;
  };
  MachineId machine;
  std::vector<EventContent> raised = {};
  std::vector<Update> updated = {};
  std::vector<Clearing> cleared = {};
  // That it was looked at as it stood then, and by which version; absent: only time has passed.
  std::optional<int64_t> looked_at = {};
  std::string looked_by = {};
  // What it has found besides, in place of what the look before has: read where looked_at is there.
  std::vector<StandingFinding> findings = {};

  bool empty() const { return raised.empty() && updated.empty() && cleared.empty() && !looked_at; }
};

// Of a new webhook; of one that is there it takes the place of the present one where `replaces`.
struct NewSecret {
  std::string text;
  bool replaces = false;
};

// What came of a try to bring the next change of events to an address, or that there was none for it.
struct WebhookStep {
  struct Dead {
    int64_t change = 0;
    int tries = 0;
    std::string error;
  };
  WebhookId webhook;
  int64_t etag = 0;  // as it was when it was tried
  int64_t from = 0;  // its after_change, likewise
  int64_t to = 0;    // from now on
  int tries = 0;     // of the change after `to`
  std::optional<UtcTime> next_try_at = {};
  std::string error = {};
  bool is_sent = false;
  std::optional<Dead> dead = {};
};

// Some changes in order. All that the asker may see up to `up_to` are in it or were before it.
struct EventChangePage {
  std::vector<EventChange> changes;
  int64_t up_to = 0;
  bool is_last = false;  // there were no more when it was read
};

// ---- routines

// A complete session, when it was measured (or came, where its file does not say, or says a later time), and when it
// was complete.
struct NamedSession {
  SessionId id;
  UtcTime measured_at, came_at;
};

// What has become of a run.
struct RunChange {
  RunId run;
  RunState state = RunState::kRunning;
  std::optional<JobId> job = {};
  std::optional<CalibrationId> calibration = {};
  std::string text = {};
};

// ---- audit

struct AuditEntry {
  int64_t id = 0;  // 1, 2, ... without gaps
  UtcTime at;
  std::string principal;
  std::string peer;         // from where
  std::string action;       // "calibration.approve"; "denied Jobs.CreateJob" of calls that were refused
  std::string resource;     // "calibrations/12"; may be empty
  std::string outcome;      // "OK" or the name of the status code
  std::string was, became;  // what the resource was before, and what it is after; may be empty
  std::string detail;
};

struct AuditFilter {
  std::optional<UtcTime> from, to;          // at or after, before
  std::string principal;                    // empty: any
  std::string resource;                     // empty: any
  std::array<std::string, 2> actions = {};  // either; both empty: any
};

// The last entry and its hash: who notes them elsewhere can tell later whether all before it is as it was.
struct AuditHead {
  int64_t id = 0;  // 0: there is none
  std::string sha256;
};

// ---- what is looked through, and copies

// Something that is not what was stored.
struct Damage {
  std::string resource;  // "sessions/12/chunks/3", "calibrations/4", "audit"; "file": structure or references
  std::string text;      // for people
};

struct CheckReport {
  static constexpr size_t kMaxDamages = 1000;

  int schema_version = 0;
  // How many were compared with their checksums.
  int64_t descriptions = 0, sessions = 0, chunks = 0, jobs = 0, calibrations = 0, programs = 0;
  AuditHead audit;
  int64_t damage_count = 0;     // 0: the database is whole
  std::vector<Damage> damages;  // the first kMaxDamages
};

// Of a copy.
struct BackupResult {
  int64_t bytes = 0;
  std::string sha256;  // hex
  CheckReport report;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_RECORDS_H_
