// Errors of the tool point over many poses, as columns of numbers.
#ifndef AXISCAL_CORE_PREDICT_OVER_POSES_H_
#define AXISCAL_CORE_PREDICT_OVER_POSES_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/predict/taken_up.h"
#include "core/predict/volumetric.h"

namespace axiscal::predict {

// Less of a sum of squares is no reason that a reader should look at.
inline constexpr double kWeak = 0.25;
// Ends of 95 % intervals.
inline constexpr double kLowQuantile = 0.025, kHighQuantile = 0.975;

// Reorders `values`, at least one.
double Quantile(std::vector<double>* values, double share);

// Errors of all poses, less what work offset and tool centre take up. Rows 3 k .. 3 k + 2 are of pose k, mm.
class OverPoses {
 public:
  // `machine` and `states` must outlive it.
  OverPoses(const machine::Machine& machine, const BoxStates& states, const Eigen::Vector3d& tip_mm);

  Eigen::Index rows() const { return 3 * states_.count(); }
  // Of a machine with these errors, mm.
  Eigen::VectorXd ErrorsOf(const machine::ErrorModel& model) const;
  // By each number of the covariance, with what work offset and tool centre take up.
  Eigen::MatrixXd ByNumber(const machine::KnownErrors& errors) const;
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
  const BoxStates& states_;
  const Eigen::Vector3d tip_mm_;
  Eigen::MatrixXd taken_up_;
};

}  // namespace axiscal::predict

#endif  // AXISCAL_CORE_PREDICT_OVER_POSES_H_
