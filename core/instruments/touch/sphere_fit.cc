#include "core/instruments/touch/sphere_fit.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace axiscal::touch {

std::optional<Sphere> FitSphere(const std::vector<Eigen::Vector3d>& points_mm) {
  constexpr size_t kMinTouches = 5;  // four fit any sphere
  if (points_mm.size() < kMinTouches) return std::nullopt;
  // First |p|^2 = 2 p.c + k, linear; then Gauss-Newton on the distances.
  Eigen::MatrixX4d rows(points_mm.size(), 4);
  Eigen::VectorXd misses(points_mm.size());
  double size_mm = 0.0;
  for (const Eigen::Vector3d& point_mm : points_mm) size_mm = std::max(size_mm, (point_mm - points_mm[0]).norm());
  if (!(size_mm > 0.0)) return std::nullopt;
  for (size_t k = 0; k < points_mm.size(); ++k) {
    const Eigen::Vector3d near = (points_mm[k] - points_mm[0]) / size_mm;
    rows.row(k) << near.transpose(), 1.0;
    misses[k] = near.squaredNorm();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixX4d> qr(rows);
  qr.setThreshold(0.01);
  if (qr.rank() < 4) return std::nullopt;
  const Eigen::Vector4d start = qr.solve(misses);
  Sphere sphere;
  sphere.centre_mm = points_mm[0] + size_mm * start.head<3>() / 2.0;
  sphere.radius_mm = size_mm * std::sqrt(std::max(0.0, start[3] + start.head<3>().squaredNorm() / 4.0));
  constexpr int kSteps = 5;  // quadratic from micrometres away
  for (int step = 0; step <= kSteps; ++step) {
    for (size_t k = 0; k < points_mm.size(); ++k) {
      const Eigen::Vector3d off_mm = points_mm[k] - sphere.centre_mm;
      misses[k] = off_mm.norm() - sphere.radius_mm;
      rows.row(k) << off_mm.normalized().transpose(), 1.0;
    }
    if (step == kSteps) break;
    const Eigen::Vector4d change = rows.householderQr().solve(misses);
    sphere.centre_mm += change.head<3>();
    sphere.radius_mm += change[3];
  }
  sphere.rms_mm = std::sqrt(misses.squaredNorm() / static_cast<double>(misses.size()));
  sphere.max_mm = misses.cwiseAbs().maxCoeff();
  return sphere;
}

}  // namespace axiscal::touch
