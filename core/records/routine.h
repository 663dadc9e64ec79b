// What runs by itself when sessions have come, and what became of each time it ran (docs/routines.md).
#ifndef AXISCAL_CORE_RECORDS_ROUTINE_H_
#define AXISCAL_CORE_RECORDS_ROUTINE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/access.h"

namespace axiscal::records {

// Never renumber.
enum class RoutineWork { kFit = 1, kLoop = 2 };  // identify, close the loop

struct Routine {
  std::string name;                         // IsAccessName(); of those that are not removed each once
  Scope scope;                              // a machine, or a group as it is at the time; never all
  std::string principal;                    // that it acts as: its jobs are this one's, with this one's rights
  std::vector<std::string> sessions;        // names of the sessions to fit, each once, at least one
  std::vector<std::string> check_sessions;  // of kLoop: to prove on, none of `sessions`
  int within_hours = 24;                    // they are a set when measured within so long, > 0
  // It waits for this minute of a UTC day after the set is complete, 0 .. 1439; absent: it begins at once.
  std::optional<int> at_utc_minute;
  RoutineWork work = RoutineWork::kFit;
  // As in IdentifyParams and CloseLoopParams; `declared` of kFit, `max_effects` of kLoop alone.
  std::vector<std::string> declared;
  std::optional<int> max_effects;
  std::string budget_json;
  std::optional<int> monte_carlo_runs;
  uint64_t monte_carlo_seed = 1;
  // It approves what moves the tool point by at most so much against the approved calibration, um, > 0, where nothing
  // else speaks against it; absent: it proposes.
  std::optional<double> approve_within_um;
  bool is_enabled = true;  // false: it is kept and begins nothing
  std::string note;        // for people
};

// A machine on which a person has stopped a routine.
struct RoutineStop {
  MachineId machine;
  std::string by, note;
  base::UtcTime at;
};

struct RoutineRecord {
  RoutineId id;
  Routine content;
  int64_t etag = 0;  // grows with every change
  std::string created_by, changed_by;
  base::UtcTime created_at, changed_at;
  std::vector<RoutineStop> stops;  // in order of machines
};

// Never renumber.
enum class RunState {
  kWaiting = 1,   // its job is not created yet: the queue is full, or the server has just started
  kRunning = 2,   // its job waits or runs
  kAgrees = 3,    // the result agrees with the approved calibration
  kProposed = 4,  // the result is a candidate that waits for a person
  kApproved = 5,  // the result was put in use
  kFailed = 6,    // `text` says why
  kStopped = 7,   // by a person, who cancelled its job or stopped the routine
};
inline bool IsOpen(RunState state) { return state == RunState::kWaiting || state == RunState::kRunning; }
// "waiting", "running", "agrees", "proposed", "approved", "failed", "stopped"; "state 9" of a newer server's.
std::string NameOf(RunState state);

// A routine that ran, or runs, on a machine.
struct RoutineRun {
  RunId id;
  RoutineId routine_id;
  std::string routine;
  int64_t routine_etag = 0;  // of the routine as it was when it began
  MachineId machine;
  std::string principal;  // that it acts as
  RunState state = RunState::kWaiting;
  std::vector<SessionId> sessions, check_sessions;  // in the order of the routine's names
  std::optional<JobId> job;
  std::optional<CalibrationId> calibration;
  std::string text;  // what came out, or why it failed
  base::UtcTime began_at;
  std::optional<base::UtcTime> ended_at;
};

struct RunFilter {
  std::optional<MachineId> machine;
  std::string routine;  // empty: any
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_ROUTINE_H_
