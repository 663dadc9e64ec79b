// What a new calibration says against the one in use, and whether anything speaks against putting it in use without a
// person: docs/routines.md has the rules.
#ifndef AXISCAL_SERVER_ROUTINES_JUDGE_H_
#define AXISCAL_SERVER_ROUTINES_JUDGE_H_

#include <optional>
#include <string>
#include <vector>

#include "core/compare/compare.h"
#include "core/records/drift.h"
#include "core/reports/calibration.h"
#include "server/storage/database.h"

namespace axiscal::routines {

struct Judgement {
  // The calibration in use that it was compared with; absent: with none. Approving must ask for it again.
  std::optional<CalibrationId> in_use;
  // Both say the same within their uncertainties.
  bool agrees = false;
  // The largest change of the tool point over the measured positions, with the same work offset and tool data, um;
  // absent where it is not known.
  std::optional<double> largest_change_um;
  // The same against the calibration that a person put in use last; absent where that is in use, or it is not known.
  std::optional<double> largest_change_since_person_um;
  // What speaks against approving it without a person, whatever the change is; a sentence each.
  std::vector<std::string> doubts;
  // The comparison, in words.
  std::string text;
};

// Facts alone. `comparison`: of the calibration in use (first) with the new one; absent: nothing is in use.
Judgement JudgeComparison(const std::optional<compare::Comparison>& comparison,
                          const std::optional<CalibrationId>& in_use);
// The new one by itself: its report's warnings, what the loop could not explain, tolerances that it does not keep.
std::vector<std::string> DoubtsOf(const records::CalibrationRecord& candidate,
                                  const std::optional<reports::CalibrationReport>& report,
                                  const std::vector<records::DriftLimit>& tolerances);

// Of a stored candidate. What cannot be compared is a doubt; only what may pass (UNAVAILABLE, ABORTED ...) is a
// failure.
absl::StatusOr<Judgement> Judge(storage::Database& database, const records::CalibrationRecord& candidate);

// Whether the same call may succeed later by itself.
bool MayPass(const absl::Status& status);

}  // namespace axiscal::routines

#endif  // AXISCAL_SERVER_ROUTINES_JUDGE_H_
