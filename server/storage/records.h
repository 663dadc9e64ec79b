// What the store keeps, as plain structs of core types. New... is what a caller gives, ...Record what the store
// answers. Texts named `..._json` and byte strings named `params`, `result` are opaque to the store.
#ifndef AXISCAL_SERVER_STORAGE_RECORDS_H_
#define AXISCAL_SERVER_STORAGE_RECORDS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/session/session.h"

namespace axiscal::storage {

using base::UtcTime;

// Who asks: `principal` scopes request ids and is written to the audit; `request_id` (any text, best a UUID) makes a
// call repeatable. An empty request_id means that every call is a new one.
struct Caller {
  std::string principal;
  std::string request_id;
};

// ---- machines

struct MachineRecord {
  MachineId id;
  int64_t revision = 0;          // 1, 2, ...: the etag; every description stays readable by its revision
  std::string description_json;  // machine.json of this revision
  UtcTime created_at, updated_at;
  std::optional<UtcTime> deleted_at;
};

// ---- sessions

// Never renumber.
enum class SessionState { kOpen = 1, kComplete = 2, kAborted = 3, kExpired = 4 };

struct ColumnSpec {
  std::string name;      // with its unit as in the file: X_mm, t_s, feature
  bool is_text = false;  // texts instead of numbers

  bool operator==(const ColumnSpec&) const = default;
};

struct NewSession {
  MachineId machine;
  std::string name;        // the user's own name of the session ("CR"); need not be unique
  std::string instrument;  // "ballbar", "centres", ...
  std::vector<session::HeaderEntry> header;
  std::vector<ColumnSpec> columns;
  std::optional<UtcTime> measured_at;  // when it was measured, if the file says so
  Caller caller;
};

struct SessionRecord {
  SessionId id;
  MachineId machine;
  std::string name;
  std::string instrument;
  std::vector<session::HeaderEntry> header;
  std::vector<ColumnSpec> columns;
  std::optional<UtcTime> measured_at;
  SessionState state = SessionState::kOpen;
  int64_t next_seq = 0;       // chunks 0 .. next_seq - 1 are durable
  int64_t reading_count = 0;  // readings in them
  std::string hash;           // session::SessionHash of its chunks, once complete; else empty
  std::string created_by;
  UtcTime created_at;
  UtcTime last_seen_at;  // of the last chunk
  std::optional<UtcTime> closed_at;
};

// Totals with which the uploader closes a session.
struct SessionTotals {
  int64_t chunk_count = 0;
  int64_t reading_count = 0;
  std::string hash;  // session::SessionHash
};

struct AppendResult {
  int64_t next_seq = 0;    // the first seq that is not durable yet
  bool duplicate = false;  // this chunk was there already, with equal content
};

struct SessionFilter {
  std::optional<MachineId> machine;
  std::optional<SessionState> state;
  std::string instrument;  // empty: any
};

// ---- jobs

// Never renumber.
enum class JobState { kQueued = 1, kRunning = 2, kSucceeded = 3, kFailed = 4, kCancelled = 5, kDead = 6 };

inline bool IsTerminal(JobState state) { return state != JobState::kQueued && state != JobState::kRunning; }

struct JobProgress {
  std::string stage;      // "fit", "write program"
  double fraction = 0.0;  // 0 .. 1 of the whole job
  std::string detail;     // "iteration 4, rms 2.97 um"

  bool operator==(const JobProgress&) const = default;
};

struct JobError {
  absl::StatusCode code = absl::StatusCode::kUnknown;
  std::string reason;  // "RANK_DEFICIENT", "DEADLINE", "OWNER_LOST" ...; may be empty
  std::string message;
};

struct NewJob {
  std::string kind;                  // "identify", "compensate", ...
  std::optional<MachineId> machine;  // the machine it works on, for lists
  std::string params;                // what the kind's function needs, opaque
  std::string input_hash;            // of all inputs and the engine's version; empty: not comparable
  int priority = 0;                  // larger runs first
  int max_attempts = 3;
  Caller caller;
};

struct JobRecord {
  JobId id;
  std::string kind;
  std::optional<MachineId> machine;
  std::string params;
  std::string input_hash;
  int priority = 0;
  JobState state = JobState::kQueued;
  int attempt = 0;  // counted when claimed
  int max_attempts = 3;
  int64_t lease_token = 0;  // of the running attempt; 0 when not running
  bool cancel_requested = false;
  JobProgress progress;
  std::string result;                        // of a succeeded job
  std::optional<CalibrationId> calibration;  // that it made
  std::vector<ProgramId> programs;           // that it made
  std::optional<JobError> error;             // of the last attempt that failed
  std::string created_by;
  UtcTime created_at;
  UtcTime run_after;                            // not claimed before (backoff)
  std::optional<UtcTime> started_at, ended_at;  // of the last attempt
  int64_t version = 0;                          // grows with every change of the row
};

// The right to write a running job: a stale token is refused with ABORTED, LEASE_LOST.
struct JobClaim {
  JobId id;
  int64_t lease_token = 0;
};

struct JobFilter {
  std::optional<MachineId> machine;
  std::optional<JobState> state;
  std::string kind;        // empty: any
  std::string input_hash;  // empty: any
};

// ---- calibrations and their estimates

// Never renumber.
enum class CalibrationState { kCandidate = 1, kApproved = 2, kRetired = 3 };
// Never renumber.
enum class EstimateUnit { kUm = 1, kUrad = 2 };

// One identified error. What the data could not tell has no value and no sigma.
struct Estimate {
  std::string symbol;  // "EA0B", or with its shape "EBB:harmonic:45"
  EstimateUnit unit = EstimateUnit::kUm;
  bool identifiable = true;
  std::optional<double> value;  // um or urad
  std::optional<double> sigma;  // 1 standard uncertainty, um or urad

  bool operator==(const Estimate&) const = default;
};

struct NewCalibration {
  MachineId machine;
  int64_t machine_revision = 0;     // whose description was fitted
  std::vector<SessionId> sessions;  // that it came from, in order; all complete and of this machine
  UtcTime measured_at;              // the time of its estimates in the history
  std::string model_json;           // the error model: what compensation uses
  std::string options_json;         // how it was asked
  std::string report_json;          // what came out, as identify::ToJson
  std::string engine_version;
  int rank = 0;
  std::optional<double> condition;  // of the scaled Jacobian
  std::optional<double> chi2_per_dof;
  std::optional<double> rms_before_um, rms_after_um;
  std::vector<Estimate> estimates;
  std::string created_by;
};

struct CalibrationRecord {
  CalibrationId id;
  int64_t version = 0;  // 1, 2, ... of its machine
  CalibrationState state = CalibrationState::kCandidate;
  int64_t etag = 0;  // grows with every change of state
  std::optional<JobId> job;
  NewCalibration content;
  UtcTime created_at;
  std::string approved_by;
  std::optional<UtcTime> approved_at, retired_at;
};

struct CalibrationFilter {
  std::optional<MachineId> machine;
  std::optional<CalibrationState> state;
};

// ---- history

struct DriftQuery {
  MachineId machine;
  std::vector<std::string> symbols;  // empty: all that the machine has
  UtcTime from;                      // included
  UtcTime to;                        // excluded
  int max_points = 500;              // per symbol, 1 .. 100'000
};

// Estimates of one bucket of time. With count = 1 it is that very estimate: min = max = mean, with its own sigma and
// calibration.
struct DriftPoint {
  UtcTime first_at, last_at;
  int64_t count = 0;
  double min = 0.0, max = 0.0, mean = 0.0;  // in the unit of the series
  std::optional<double> sigma;              // of the last estimate in the bucket
  CalibrationId last_calibration;
};

struct DriftSeries {
  std::string symbol;
  EstimateUnit unit = EstimateUnit::kUm;
  std::vector<DriftPoint> points;      // in time order; only estimates that have a value
  int64_t not_identifiable_count = 0;  // calibrations in the range that could not tell this error
};

struct LatestEstimate {
  Estimate estimate;
  UtcTime measured_at;
  CalibrationId calibration;
};

struct FleetRow {
  MachineId machine;
  std::vector<LatestEstimate> latest;  // one per symbol that the machine has, in order of symbol
};

// ---- programs (NC programs, tables, reports: byte strings named by their content)

// Never renumber.
enum class ProgramState { kOpen = 1, kComplete = 2, kMerged = 3, kExpired = 4 };

struct NewProgram {
  std::string kind;  // "nc", "table", "report"
  std::string name;  // file name, informative
  Caller caller;
};

struct ProgramRecord {
  ProgramId id;
  std::string kind;
  std::string name;
  ProgramState state = ProgramState::kOpen;
  int64_t byte_count = 0;  // durable so far: the offset of the next part
  std::string sha256;      // hex, once complete
  std::string created_by;
  UtcTime created_at;
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

// ---- audit

struct AuditEntry {
  UtcTime at;
  std::string principal;
  std::string action;    // "calibration.approve"
  std::string resource;  // "calibrations/12"
  std::string outcome;   // "OK" or the name of the status code
  std::string detail;
};

// ---- pages

struct PageRequest {
  int size = 0;       // 0: 50; at most 1000 are given
  std::string token;  // from the page before; empty: the first
};

// Pages stay stable: rows made later never shift rows already listed. Newest first, machines by name.
template <typename Row>
struct Page {
  std::vector<Row> rows;
  std::string next_token;  // empty: this was the last page
};

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_RECORDS_H_
