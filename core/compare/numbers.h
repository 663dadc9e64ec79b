// The numbers of two sets of errors side by side, in the units of files.
#ifndef AXISCAL_CORE_COMPARE_NUMBERS_H_
#define AXISCAL_CORE_COMPARE_NUMBERS_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/compare/side.h"

namespace axiscal::compare {

struct Number {
  std::string name, unit;
  double factor = 1.0;                  // mm or rad per unit
  machine::ErrorCovariance::Number of;  // in `both`
  bool is_in[2] = {false, false};       // in which models
  bool has_sigma[2] = {false, false};   // whose covariance names it
  double value[2] = {0.0, 0.0};         // 0 where the model does not have it
};

struct Numbers {
  std::vector<Number> all;
  machine::ErrorModel both;       // every term of either model
  Eigen::MatrixXd covariance[2];  // all x all, zero where nothing is known; sigmas widened by the coverage factor
  // Directions (rows, of all numbers) that one of the fits could not tell: reduced, row k has 1 at pivots[k], where all
  // other rows have 0.
  Eigen::MatrixXd unknown;
  std::vector<int> pivots;
};

// INVALID_ARGUMENT where a direction cannot be read.
absl::StatusOr<Numbers> SideBySide(const machine::Machine& machine, const Side& first, const Side& second);

// "EX0C - 0.1 EB0C": coefficients in files' units over that of number `carrier`, which stands first; zeros and rounding
// left out.
std::string CombinationText(const std::vector<Number>& numbers, const Eigen::VectorXd& coefficients,
                            Eigen::Index carrier);

}  // namespace axiscal::compare

#endif  // AXISCAL_CORE_COMPARE_NUMBERS_H_
