#include "core/figures/line.h"

#include <Eigen/Dense>
#include <algorithm>

namespace axiscal::figures {
namespace {

// Intercept and slope over the positions, per row of `values`.
Eigen::MatrixX2d FitOver(const std::vector<double>& positions_mm, const Eigen::MatrixXd& values) {
  const auto count = static_cast<Eigen::Index>(positions_mm.size());
  const Eigen::Map<const Eigen::VectorXd> at(positions_mm.data(), count);
  const double mean = at.mean();
  const Eigen::VectorXd centred = at.array() - mean;
  Eigen::MatrixX2d out(values.rows(), 2);
  out.col(1) = values * centred / centred.squaredNorm();
  out.col(0) = values.rowwise().mean() - mean * out.col(1);
  return out;
}

}  // namespace

Line LineOf(const std::vector<double>& positions_mm, const Eigen::Matrix3Xd& points_mm) {
  const Eigen::MatrixX2d fitted = FitOver(positions_mm, points_mm);
  Line line;
  line.along = fitted.col(1).normalized();
  const Eigen::RowVectorXd along_mm = line.along.transpose() * points_mm;
  double mean = 0.0;
  for (size_t i = 0; i < positions_mm.size(); ++i) {
    line.deviation_mm.push_back(along_mm[static_cast<Eigen::Index>(i)] - positions_mm[i]);
    mean += line.deviation_mm.back() / static_cast<double>(positions_mm.size());
  }
  for (double& one : line.deviation_mm) one -= mean;
  return line;
}

double StraightnessOf(const std::vector<double>& positions_mm, const std::vector<double>& across_mm) {
  const Eigen::Map<const Eigen::RowVectorXd> values(across_mm.data(), static_cast<Eigen::Index>(across_mm.size()));
  const Eigen::MatrixX2d fitted = FitOver(positions_mm, values);
  double low = INFINITY, high = -INFINITY;
  for (size_t i = 0; i < across_mm.size(); ++i) {
    const double left = across_mm[i] - fitted(0, 0) - fitted(0, 1) * positions_mm[i];
    low = std::min(low, left);
    high = std::max(high, left);
  }
  return high - low;
}

}  // namespace axiscal::figures
