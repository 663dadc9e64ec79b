// The error of the tool of a machine whose errors are constant, in closed form: a turn about a unit vector k by the
// angle a is 1 + sin(a) K + (1 - cos(a)) K^2 with K the cross product by k, so whatever the folded chain
// (folded_chain.h) makes of the tool is, with two rotary axes at most, a sum of nine constant vectors times products of
//   (1, sin(a1), 1 - cos(a1))  and  (1, sin(a2), 1 - cos(a2)),
// and affine in the linear axes. The difference of two chains is formed from these constants, before positions come in:
// so no digits are lost to large positions.
#ifndef AXISCAL_CORE_COMPENSATE_ERROR_POLYNOMIAL_H_
#define AXISCAL_CORE_COMPENSATE_ERROR_POLYNOMIAL_H_

#include <Eigen/Core>
#include <optional>

#include "core/compensate/folded_chain.h"

namespace axiscal::compensate {

// In the table frame, at a pose of the rotary axes.
struct ToolErrors {
  Eigen::Vector3d tip_per_mm[3];    // of the actual chain, per linear axis
  Eigen::Vector3d error_per_mm[3];  // actual - nominal
  Eigen::Vector3d tip_error_mm;     // actual - nominal, the linear axes at zero
  Eigen::Vector3d direction_error;  // actual - nominal, of unit vectors
};

class ErrorPolynomial {
 public:
  // Nothing where there are more than two turns, or another number of linear axes than three. The chains are of one
  // machine.
  static std::optional<ErrorPolynomial> Create(const FoldedChain& nominal, const FoldedChain& actual,
                                               const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& tool_direction);

  void Evaluate(const Turns& turns, ToolErrors* errors) const;

 private:
  static constexpr int kProducts = 9, kNumbers = sizeof(ToolErrors) / sizeof(double);

  int axis_[2] = {-1, -1};  // of the turns; -1: none
  double sign_[2] = {0, 0};
  double factors_[kProducts][kNumbers] = {};
};

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_ERROR_POLYNOMIAL_H_
