// What is the case with a machine that people should hear of: functions on facts, which say nothing of what was told
// before. docs/events.md has the rules and their numbers.
#ifndef AXISCAL_SERVER_WATCH_CONDITIONS_H_
#define AXISCAL_SERVER_WATCH_CONDITIONS_H_

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/records/cell.h"
#include "core/records/event.h"
#include "core/records/history.h"
#include "core/records/routine.h"
#include "core/reports/calibration.h"
#include "server/inputs/machine_history.h"
#include "server/storage/records.h"

namespace axiscal::watch {

struct Condition {
  records::EventContent content;
  // Clear enough to raise an event; else it only keeps one that stands (hysteresis).
  bool raises = true;
};

// What follows from calibrations, marks and what is expected.
struct HistoryFacts {
  base::UtcTime now;
  records::ExpectationsRecord expected;
  inputs::MachineHistory history;
  // The report of history.newest, where it can be read.
  std::optional<reports::CalibrationReport> newest_report;
  // The newest run of each routine that works for the machine and is not stopped there; of the calibrations that they
  // name those that are still candidates.
  std::vector<records::RoutineRun> runs;
  std::set<CalibrationId> candidates;
  // The calibration in use, where it stands on sessions that were rejected.
  std::optional<records::CalibrationRecord> on_rejected;
  // Of each group of the machine that has others with calibrations: what was identified last of each of these.
  std::map<std::string, std::vector<records::FleetRow>> peers;
};
inline constexpr records::EventKind kOfHistory[] = {
    records::EventKind::kOutOfTolerance,  records::EventKind::kLimitForecast,   records::EventKind::kStep,
    records::EventKind::kSuspect,         records::EventKind::kUnstable,        records::EventKind::kWear,
    records::EventKind::kScatter,         records::EventKind::kModelLacks,      records::EventKind::kRoutineFailed,
    records::EventKind::kRoutineProposes, records::EventKind::kSessionRejected, records::EventKind::kUnlikeGroup};
std::vector<Condition> ConditionsOf(const HistoryFacts& facts);

// What the history, candidates counted, says that a calibration measured at `in_use` (absent: none is in use) cannot
// know of: each jump that stands and came after it, the oldest first; where there is none, that its last calibration is
// doubtful.
std::vector<storage::StandingFinding> StandingFindings(const inputs::MachineHistory& history,
                                                       std::optional<base::UtcTime> in_use);

// What follows from the time.
struct TimeFacts {
  base::UtcTime now;
  records::ExpectationsRecord expected;
  // The calibration in use, and when it was measured.
  std::optional<CalibrationId> approved;
  std::optional<base::UtcTime> approved_measured_at;
  // By name of those that are expected: the newest.
  std::map<std::string, std::optional<base::UtcTime>> newest_sessions;
  // That serve the machine.
  std::vector<records::CellRecord> cells;
};
inline constexpr records::EventKind kOfTime[] = {records::EventKind::kCalibrationOld,
                                                 records::EventKind::kSessionMissed, records::EventKind::kCellSilent,
                                                 records::EventKind::kCellProblem};
std::vector<Condition> ConditionsOf(const TimeFacts& facts);

// Why an event of this kind is over, where nothing of its condition is left.
std::string WhyCleared(records::EventKind kind);

}  // namespace axiscal::watch

#endif  // AXISCAL_SERVER_WATCH_CONDITIONS_H_
