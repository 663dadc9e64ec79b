// The history of a machine: the calibrations that count and the marks of people, gone through by core/drift in the
// order of time. It is gone through anew whenever it is asked for: that takes 0.1 ms a calibration beside reading it,
// so no state is stored that could be stale when a calibration comes late, is approved or retired.
#ifndef AXISCAL_SERVER_INPUTS_MACHINE_HISTORY_H_
#define AXISCAL_SERVER_INPUTS_MACHINE_HISTORY_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/drift/finding.h"
#include "core/drift/state.h"
#include "server/storage/database.h"

namespace axiscal::inputs {

// The calibrations that count are one for each measured set (the same sessions): that which was approved last. Of sets
// of which none was ever approved it is the newest candidate that a routine has made, or that anybody has made where
// candidates count; else none. Of several that were measured at the same moment it is the newest.
struct MachineHistory {
  // A calibration that should count and cannot be followed: which, and why.
  struct LeftOut {
    CalibrationId id;
    std::string text;
  };

  std::vector<drift::Finding> findings;             // in order of time
  std::vector<records::CalibrationRecord> counted;  // the oldest first, without JSON texts
  // The newest one, approved or a candidate, whether it counts or not.
  std::optional<CalibrationId> newest;
  std::vector<records::Mark> marks;  // that count, the oldest first
  std::vector<LeftOut> left_out;
  int64_t calibrations = 0;  // that the machine has in all
  drift::State state;        // behind all of them: what forecasts start from
};

// CANCELLED CALLER_GONE as soon as `is_cancelled` says so.
absl::StatusOr<MachineHistory> FollowHistory(storage::Database& database, const MachineId& machine,
                                             bool counts_candidates, const std::function<bool()>& is_cancelled);

// "2026-05-12" (UTC).
std::string DayText(base::UtcTime at);

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_MACHINE_HISTORY_H_
