// Errors of the tool point over many poses, as columns of numbers.
#ifndef AXISCAL_CORE_PREDICT_OVER_POSES_H_
#define AXISCAL_CORE_PREDICT_OVER_POSES_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/machine/error_covariance.h"
#include "core/machine/machine.h"
#include "core/predict/box_poses.h"

namespace axiscal::predict {

// Less of a sum of squares is no reason that a reader should look at.
inline constexpr double kWeak = 0.25;
// Ends of 95 % intervals.
inline constexpr double kLowQuantile = 0.025, kHighQuantile = 0.975;

// Reorders `values`, at least one.
double Quantile(std::vector<double>* values, double share);

// Vectors of the tool point at poses stand one below the other: rows 3 k .. 3 k + 2 are those of pose k, in the table's
// frame, mm.

// Root of the mean square of their lengths.
double RmsOver(const Eigen::VectorXd& mm);
// The pose of the longest.
int LongestAt(const Eigen::VectorXd& mm);

// What uncertainties make of the rms over the poses and of the longest vector: exceeded in 5 of 100 cases, mm.
struct ChanceOver {
  double rms_mm = 0.0, max_mm = 0.0;
};
// `spread`: its product with standard normal numbers is what the uncertainties do.
ChanceOver ChanceOf(const Eigen::MatrixXd& spread);

// Errors at all poses, as vectors like these.
class OverPoses {
 public:
  // `machine` and `poses` must outlive it. `tip_mm`: nominal, at home, machine frame.
  OverPoses(const machine::Machine& machine, const BoxPoses& poses, const Eigen::Vector3d& tip_mm);

  Eigen::Index rows() const { return 3 * poses_.count(); }
  // Of a machine with these errors, less what work offset and tool centre take up.
  Eigen::VectorXd ErrorsOf(const machine::ErrorModel& model) const;
  // By each number of the covariance, with what work offset and tool centre take up. Times the covariance's root: the
  // product with standard normal numbers is what the uncertainties do.
  Eigen::MatrixXd ByNumber(const machine::KnownErrors& errors) const;
  // Less what work offset (a shift in the table's frame) and the tool's length and centre (a shift in the tool's frame)
  // take up: both are set anew before a part is cut, to suit all poses best.
  template <typename Columns>
  Columns Left(const Columns& columns) const {
    return columns - taken_up_ * (taken_up_.transpose() * columns);
  }
  // Numbers (machine::NameNumber) that make kWeak of the expected square or more, the largest first; `uncertain`:
  // `by_number` times the root of the covariance.
  std::vector<std::string> WeakestOf(const machine::KnownErrors& errors, const Eigen::MatrixXd& by_number,
                                     const Eigen::MatrixXd& uncertain) const;
  // Of the model's numbers by these names: those that move the tool point.
  std::vector<std::string> ActingOf(const machine::ErrorModel& model, const std::vector<std::string>& names) const;

 private:
  const machine::Machine& machine_;
  const BoxPoses& poses_;
  const Eigen::Vector3d tip_mm_;
  Eigen::MatrixXd taken_up_;  // orthonormal
};

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_OVER_POSES_H_
