// The volumetric error of a machine over the box of axis positions that sessions covered: the root mean square of the
// tool point's error (tool_point.h) at poses anywhere in the box, less the work offset (a shift in the table's frame)
// and the tool's length and centre (a shift in the tool's frame) that suit all poses best. These two are set anew
// before a part is cut, and no sessions tell them from the errors.
#ifndef AXISCAL_CORE_PREDICT_VOLUMETRIC_H_
#define AXISCAL_CORE_PREDICT_VOLUMETRIC_H_

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/instruments/run.h"
#include "core/predict/box_poses.h"
#include "core/predict/tool_point.h"

namespace axiscal::predict {

// Root of the expected mean square, and the 95 % interval, mm.
struct RootMeanSquare {
  double expected_mm = 0.0, low_mm = 0.0, high_mm = 0.0;
};

// An error that the readings do not tell from others: one of these models may hold in place of what was found.
struct OpenChoice {
  struct Rival {
    machine::ErrorModel model;
    double odds = 0.0;  // against what was found
  };
  std::string name;              // of the error that was found; "": of several at once
  machine::ErrorModel as_found;  // what the rivals were fitted beside
  std::vector<Rival> rivals;
  // Choices by their names that are none where a rival of this one holds: it lacks the errors that they are of. One
  // choice at most has some.
  std::vector<std::string> overrules;
};

struct VolumetricError {
  Box box;
  int poses = 0;
  // Of the machine as it is; where it is corrected for the errors of `before`, whose values count as they are; where it
  // is corrected for those that were found and have a name. Their covariance and the open choices are what the
  // expectation is over: what they do not model is in none of these.
  RootMeanSquare uncorrected, before, after;
  // The interval of the difference of `before` and `after` is above zero.
  bool is_gain_held = false;
  // Numbers (machine::NameNumber) whose uncertainty makes most of `after`, each a quarter of its square or more; the
  // largest first. Of the open choices the same.
  std::vector<std::string> weakest, undecided;
  // Of the numbers `unknown`: those that move the tool point over the box. What they do is in none of the figures.
  std::vector<std::string> unknown;
};

// What no draw of errors and choices holds. Standard deviations: of what the true forms of errors leave over the box
// beside the forms that were found, mm rms; of the logarithm of all that is left else, as standard uncertainties are
// themselves known to a share.
struct Unsure {
  double form_mm = 0.0, sigma_share = 0.0;
};

// Worse than before: by more than this share, and by more than this, mm rms.
struct Worse {
  double share = 0.0, mm = 0.0;
};

// What correcting a machine does to the tool point over the box of measured positions, for all that the machine may be:
// its errors drawn from their covariance and from the open choices. What the errors do not model is in none of it.
class BoxOdds {
 public:
  // `before`: the errors that would be corrected without those that were found. `found`: errors with their covariance,
  // as they were fitted to `runs`. `choices`: which rival acts is drawn by its odds, each choice by itself. Null where
  // there is no covariance or the runs moved no axis. The machine and the runs must outlive it.
  static std::unique_ptr<const BoxOdds> Over(const machine::Machine& machine,
                                             const std::vector<instruments::MeasuringRun>& runs,
                                             const machine::ErrorModel& before, machine::KnownErrors found,
                                             const std::vector<OpenChoice>& choices = {});
  ~BoxOdds();

  // Probability that a machine corrected for `after` is worse than one corrected for `before`.
  double ProbabilityOf(const Worse& worse, const machine::ErrorModel& after) const;
  // The same of the model that would have been fitted without these terms of `found`, to first order.
  double ProbabilityWithout(const std::vector<int>& terms, const Worse& worse) const;

  // `after`: the errors that are corrected. `unknown`: names (machine::NameNumber) of numbers of `found` that nothing
  // is known of. `unsure` widens the intervals; whether a gain is held does not hang on it, as before and after are of
  // the same machine.
  VolumetricError Figures(const machine::ErrorModel& after, const std::vector<std::string>& unknown = {},
                          const Unsure& unsure = {}) const;

 private:
  class Drawn;
  BoxOdds(std::unique_ptr<const Drawn> drawn);

  std::unique_ptr<const Drawn> drawn_;
};

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_VOLUMETRIC_H_
