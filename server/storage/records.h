// What the store is given and answers beside the records of core/records: who asks, what is new, the right to write a
// running job. Texts named `..._json` and byte strings named `params`, `result` are opaque to it.
#ifndef AXISCAL_SERVER_STORAGE_RECORDS_H_
#define AXISCAL_SERVER_STORAGE_RECORDS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/access.h"
#include "core/records/calibration.h"
#include "core/records/history.h"
#include "core/records/job.h"
#include "core/records/machine.h"
#include "core/records/page.h"
#include "core/records/program.h"
#include "core/records/session.h"
#include "core/session/session.h"

namespace axiscal::storage {

using base::UtcTime;
// Inside the store they go by their bare names.
using records::CalibrationFilter;
using records::CalibrationRecord;
using records::CalibrationState;
using records::ColumnSpec;
using records::DriftPoint;
using records::DriftQuery;
using records::DriftSeries;
using records::Estimate;
using records::EstimateUnit;
using records::FleetRow;
using records::Grant;
using records::IsTerminal;
using records::JobError;
using records::JobProgress;
using records::JobRecord;
using records::JobState;
using records::LatestEstimate;
using records::MachineAccess;
using records::MachineRecord;
using records::NewCalibration;
using records::Page;
using records::PageRequest;
using records::PrincipalRecord;
using records::ProgramRecord;
using records::ProgramState;
using records::SessionRecord;
using records::SessionState;
using records::SessionTotals;
using records::TokenRecord;

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

struct SessionFilter {
  std::optional<MachineId> machine;
  std::optional<SessionState> state;
};

// ---- jobs

struct NewJob {
  std::string kind;                  // "identify", "compensate", ...
  std::optional<MachineId> machine;  // the machine it works on, for lists
  std::optional<ProgramId> program;  // that it rewrites: whoever sees the machine sees it from then on
  std::string params;                // what the kind's function needs, opaque
  std::string input_hash;            // of all inputs and the engine's version; empty: not comparable
  int priority = 0;                  // larger runs first
  int max_attempts = 3;
  Caller caller;
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
};

// ---- programs

struct NewProgram {
  std::string kind;  // "nc", "table", "report"
  std::string name;  // file name, informative
  Caller caller;
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

enum class ResourceKind { kMachine, kSession, kJob, kCalibration, kProgram };

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

// ---- audit

struct AuditEntry {
  UtcTime at;
  std::string principal;
  std::string action;    // "calibration.approve"
  std::string resource;  // "calibrations/12"
  std::string outcome;   // "OK" or the name of the status code
  std::string detail;
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_RECORDS_H_
