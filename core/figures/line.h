// Figures of a measured line of one linear axis: the points of a target that the axis carries.
//   straightness  the range of the deviations across the motion, in each of two directions, from the least-squares line
//                 over the position. ISO 230-1 allows other reference lines, which give other numbers: *assumed*
//                 (docs/figures.md).
#ifndef AXISCAL_CORE_FIGURES_LINE_H_
#define AXISCAL_CORE_FIGURES_LINE_H_

#include <Eigen/Core>
#include <vector>

namespace axiscal::figures {

struct Line {
  Eigen::Vector3d along = Eigen::Vector3d::Zero();  // unit, of the fitted line, towards rising positions
  std::vector<double> deviation_mm;                 // of each point along it: actual - position, mean zero
};
// Least squares over all points; at least two different positions. `points_mm`: 3 x n.
Line LineOf(const std::vector<double>& positions_mm, const Eigen::Matrix3Xd& points_mm);

// `across_mm` at each position: its range about the least-squares line.
double StraightnessOf(const std::vector<double>& positions_mm, const std::vector<double>& across_mm);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_LINE_H_
