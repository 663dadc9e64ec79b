// A box of axis positions, poses in it, and what uncertain errors do to the tool point over them: in use wherever
// something is said of a whole work space before it is known which part of it a program goes through.
#ifndef AXISCAL_CORE_PREDICT_BOX_POSES_H_
#define AXISCAL_CORE_PREDICT_BOX_POSES_H_

#include <Eigen/Core>
#include <vector>

#include "core/base/status.h"
#include "core/machine/error_covariance.h"
#include "core/machine/machine.h"
#include "core/shapes/state.h"

namespace axiscal::predict {

// Least and greatest position of each axis of the machine, mm or rad.
struct Box {
  std::vector<double> low, high;
};

// Travel of the machine's axes, a full turn of a rotary axis that states none. INVALID_ARGUMENT naming a linear axis
// without travel.
absl::StatusOr<Box> BoxOfTravel(const machine::Machine& machine);

// Where and in which state the tool point is looked at.
struct Workspace {
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();  // nominal, at home, machine frame
  Box box;
  int poses = 400;
  double time_s = 0.0;
  double temperature_celsius = 20.0;
};

// States at the corners of the box (of up to eight axes that move) and at Workspace::poses drawn from it, each axis at
// rest after a move of either sense. The same workspace gives the same states.
class BoxPoses {
 public:
  // `workspace` must outlive it.
  explicit BoxPoses(const Workspace& workspace);

  int count() const { return static_cast<int>(states_.size() / axes_); }
  const double* PositionsOf(int pose) const { return positions_.data() + static_cast<size_t>(pose) * axes_; }
  shapes::State At(int pose) const;

 private:
  const Workspace& workspace_;
  const size_t axes_;  // at least 1
  std::vector<double> positions_;
  std::vector<shapes::AxisState> states_;
};

// Vectors of the tool point at poses stand one below the other: rows 3 k .. 3 k + 2 are those of pose k, mm.

// Root of the mean square of their lengths.
double RmsOver(const Eigen::VectorXd& mm);
// The pose of the longest.
int LongestAt(const Eigen::VectorXd& mm);

// The tool-point error's derivatives by the numbers of `covariance` (table's frame), times its root: the product with
// standard normal numbers is what the uncertainties do. 3 poses x columns of the root.
Eigen::MatrixXd SpreadOver(const machine::Machine& machine, const machine::ErrorModel& model,
                           const machine::ErrorCovariance& covariance, const BoxPoses& poses,
                           const Eigen::Vector3d& tip_mm);

// What such a spread makes of the rms over the poses and of the longest vector: exceeded in 5 of 100 cases, mm.
struct ChanceOver {
  double rms_mm = 0.0, max_mm = 0.0;
};
ChanceOver ChanceOf(const Eigen::MatrixXd& spread);

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_BOX_POSES_H_
