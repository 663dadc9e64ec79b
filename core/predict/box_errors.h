// The error that a user cares about: how far the tool point is from where it should be, anywhere in a box of axis
// positions. Of the machine as it is, corrected for one model, corrected for another; less what work offset and tool
// centre take up (over_poses.h). What the models do not hold is in none of the figures.
#ifndef AXISCAL_CORE_PREDICT_BOX_ERRORS_H_
#define AXISCAL_CORE_PREDICT_BOX_ERRORS_H_

#include <optional>
#include <string>
#include <vector>

#include "core/predict/volumetric.h"

namespace axiscal::predict {

// Over the models' uncertainty: the mean, and the 95 % interval, mm.
struct Figure {
  double expected_mm = 0.0, low_mm = 0.0, high_mm = 0.0;
};

// Of the length of the tool point's error over poses drawn evenly from a box.
struct LengthFigures {
  Figure rms, median, p95, max;
  // The pose with the largest expected square; axis positions, mm or rad.
  std::vector<double> largest_at;
};

struct BoxErrors {
  Box box, measured;
  int poses = 0;
  // Share of the poses within the measured positions, each axis by itself. Elsewhere nobody has looked: the models say
  // what they say, with sigmas that open as the shapes of their errors do.
  double known_share = 1.0;
  LengthFigures uncorrected, after;
  std::optional<LengthFigures> before;             // with a model `before`
  std::optional<LengthFigures> after_where_known;  // of those poses alone, where there are some of both kinds
  // As of a VolumetricError.
  std::vector<std::string> weakest, unknown;
};

// `found`: errors with their covariance, as they were fitted to `runs`; after: corrected for those of them that have a
// name. `before`: errors that are corrected before, whose values count as they are. `unknown`: names of numbers of
// `found` that nothing is known of. `box`: without it, that of the runs. Nothing without a covariance, or where the
// runs, or the box, move no axis.
std::optional<BoxErrors> ErrorsOverBox(const machine::Machine& machine,
                                       const std::vector<instruments::MeasuringRun>& runs,
                                       const std::optional<machine::ErrorModel>& before,
                                       const machine::KnownErrors& found, const std::vector<std::string>& unknown,
                                       const std::optional<Box>& box = {});

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_BOX_ERRORS_H_
