#include "core/information/information.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace axiscal::information {

Information OfRows(const Eigen::MatrixXd& whitened) {
  return {whitened.transpose() * whitened, whitened.colwise().squaredNorm().transpose()};
}

Eigen::MatrixXd CovarianceOf(const Information& information, const std::vector<int>& free) {
  // Scaled to unit diagonal: errors in mm and rad differ by their levers.
  Eigen::VectorXd scale(free.size());
  for (size_t i = 0; i < free.size(); ++i)
    scale[i] = 1.0 / std::sqrt(std::max(information.matrix(free[i], free[i]), 1e-300));
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information.matrix(free, free) * scale.asDiagonal();
  const Eigen::MatrixXd inverse = scaled.ldlt().solve(Eigen::MatrixXd::Identity(scale.size(), scale.size()));
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

}  // namespace axiscal::information
