// Two sets of identified errors of one machine: which differ beyond what their uncertainties allow, and what the
// difference does at the tool point over a box of positions. Difference = second - first.
//
// Only what both fits determined is compared. Directions that either fit could not tell (x EX0B - y EX0C) are taken out
// of both; of errors that take part in one there is no difference, but of the combinations that cross none. With d the
// differences and C = C_first + C_second (the fits are taken for independent) the joint statistic is d' C^-1 d, which
// is chi-square distributed where nothing changed. Of single errors it is said which differ after Holm's step-down
// correction for their number (Scand. J. Statist. 6, 1979), so that of two calibrations of one machine 5 % name any.
#ifndef AXISCAL_CORE_COMPARE_COMPARE_H_
#define AXISCAL_CORE_COMPARE_COMPARE_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/compare/side.h"
#include "core/machine/machine.h"
#include "core/predict/box_poses.h"

namespace axiscal::compare {

enum class Verdict {
  kAgrees,         // within 95 % of what the uncertainties allow
  kMayDiffer,      // beyond 95 % by itself, not once the number of comparisons is counted
  kDiffers,        // beyond it
  kNotDetermined,  // at least one fit could not tell it from others
  kOnlyOne,        // the other's model does not have it
  kNoUncertainty   // no uncertainty is stated: a difference without a verdict
};

// Of a number of the errors ("EX0C", "EBB:harmonic(45).cos"), or of a combination that both fits determined.
struct Difference {
  std::string name, unit;
  // In `unit`; NaN where there is none.
  double first = 0.0, second = 0.0, difference = 0.0, sigma = 0.0;
  double probability = 0.0;  // of a difference as large where nothing changed; NaN where there is no verdict
  Verdict verdict = Verdict::kAgrees;
  std::string reason;  // of a verdict that needs one: "the first could not tell it from others"
  // What this difference alone does to the tool point over the box, mm; NaN of combinations and without a box.
  double rms_mm = 0.0;
};

struct Joint {
  double chi2 = 0.0;
  int degrees_of_freedom = 0;
  double probability = 1.0;
};

struct Where {
  std::vector<double> positions;  // of each axis, mm or rad
  Eigen::Vector3d difference_mm = Eigen::Vector3d::Zero(), sigma_mm = Eigen::Vector3d::Zero();  // table's frame
  std::vector<std::string> by;  // errors whose differences make most of it there, the largest first
};

// The difference of the tool point's error over the poses, mm.
struct Size {
  double rms_mm = 0.0, max_mm = 0.0;
  Where where;  // of max
  // What the uncertainties of both would make of a machine that did not change: exceeded in 5 of 100. NaN without
  // uncertainties.
  double chance_rms_mm = 0.0, chance_max_mm = 0.0;
};

struct ToolPointDifference {
  int poses = 0;
  Size as_programmed;  // with the same work offset and tool data
  Size set_anew;       // less the work offset and the tool's length and centre that suit all poses best
  double tilt_rms_rad = 0.0, tilt_max_rad = 0.0;
  std::vector<std::string> unknown;  // directions that a fit could not tell and that move the tool point in the box
};

struct Comparison {
  std::vector<Difference> errors, combinations;
  Joint joint;
  std::vector<std::string> not_comparable;  // directions of which the difference is not known
  std::optional<ToolPointDifference> tool_point;
  std::vector<std::string> notes;
};

// `workspace`: where the tool point is compared. INVALID_ARGUMENT where a report's directions cannot be read.
absl::StatusOr<Comparison> Compare(const machine::Machine& machine, const Side& first, const Side& second,
                                   const std::optional<predict::Workspace>& workspace);

}  // namespace axiscal::compare

#endif  // AXISCAL_CORE_COMPARE_COMPARE_H_
