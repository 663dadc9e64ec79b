// The tool-point error at every row of a file of poses (docs/formats.md, "Poses"), written as a file of its own.
#ifndef AXISCAL_CORE_PREDICT_POSES_H_
#define AXISCAL_CORE_PREDICT_POSES_H_

#include <functional>
#include <string>

#include "core/predict/tool_point.h"

namespace axiscal::predict {

struct PredictedPoses {
  size_t rows = 0;
  double rms_mm = 0.0, max_mm = 0.0;    // of the tool point's error, its length
  double rms_rad = 0.0, max_rad = 0.0;  // of the tilt
  bool has_sigma = false;
};

// Reads `poses` twice, row by row: time grows with the rows, memory does not, but for the temperatures where an error
// remembers them. `output` gets a line of column names,
// then a line per row: ex_um,ey_um,ez_um,ea_urad,eb_urad,ec_urad, then ex_sigma_um ... ec_sigma_urad, empty without a
// covariance. Frames and signs: tool_point.h. `progress`: share of the work, 0 to 1.
// Errors of PoseReader and AtomicFile, INVALID_ARGUMENT where an error depends on a column that is not there or is not
// finite at a row; `output` is then what it was.
absl::StatusOr<PredictedPoses> PredictPoses(const std::string& poses, const std::string& output,
                                            const machine::Machine& machine, const machine::KnownErrors& errors,
                                            const Eigen::Vector3d& tip_mm,
                                            const std::function<void(double fraction)>& progress = {});

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_POSES_H_
