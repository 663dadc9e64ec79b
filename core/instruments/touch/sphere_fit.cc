#include "core/instruments/touch/sphere_fit.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace axiscal::touch {
namespace {

// So many points at most are judged one by one; of more, so many spread evenly give the sphere that judges all.
constexpr size_t kJudged = 64;

double DistanceMm(const Sphere& sphere, const Eigen::Vector3d& point_mm) {
  return std::abs((point_mm - sphere.centre_mm).norm() - sphere.radius_mm);
}

// The points that are farthest from this sphere, kTried of them; all without a sphere. A bad point of many hardly moves
// the sphere, so it is among these; of fewer points each is tried.
std::vector<size_t> FarthestFrom(const std::optional<Sphere>& sphere, const std::vector<Eigen::Vector3d>& points_mm) {
  constexpr size_t kTried = 8;
  std::vector<size_t> order(points_mm.size());
  std::iota(order.begin(), order.end(), size_t{0});
  if (!sphere || order.size() <= kTried) return order;
  std::partial_sort(order.begin(), order.begin() + kTried, order.end(), [&](size_t a, size_t b) {
    return DistanceMm(*sphere, points_mm[a]) > DistanceMm(*sphere, points_mm[b]);
  });
  order.resize(kTried);
  return order;
}

// One after the other: each time the one without which the others agree best.
SphereOfMost JudgeOneByOne(std::vector<Eigen::Vector3d> points_mm, double gate_mm) {
  SphereOfMost out;
  std::vector<size_t> left(points_mm.size());
  std::iota(left.begin(), left.end(), size_t{0});
  const size_t most = points_mm.size() / 3 + 1;
  const auto fit = [&out](const std::vector<Eigen::Vector3d>& of_mm) {
    ++out.fits;
    return FitSphere(of_mm);
  };
  out.sphere = fit(points_mm);
  while (out.off.size() < most) {
    if (out.sphere && out.sphere->max_mm <= 0.25 * gate_mm) break;  // nor is any far off the others'
    std::optional<Sphere> best;
    size_t worst = 0;
    for (const size_t k : FarthestFrom(out.sphere, points_mm)) {
      std::vector<Eigen::Vector3d> fellows_mm = points_mm;
      fellows_mm.erase(fellows_mm.begin() + static_cast<std::ptrdiff_t>(k));
      const std::optional<Sphere> sphere = fit(fellows_mm);
      if (!sphere || (best && sphere->rms_mm >= best->rms_mm)) continue;
      best = sphere;
      worst = k;
    }
    if (!best) break;
    const double off_mm = DistanceMm(*best, points_mm[worst]);
    if (off_mm <= gate_mm) break;
    out.off.push_back({left[worst], off_mm});
    out.sphere = best;
    points_mm.erase(points_mm.begin() + static_cast<std::ptrdiff_t>(worst));
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return out;
}

}  // namespace

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

SphereOfMost FitSphereOfMost(const std::vector<Eigen::Vector3d>& points_mm, double gate_mm) {
  if (points_mm.size() <= kJudged) return JudgeOneByOne(points_mm, gate_mm);
  // By the golden ratio: evenly, and not in step with what repeats each few points.
  std::vector<Eigen::Vector3d> some_mm;
  for (size_t i = 0; i < kJudged; ++i) {
    const double share = std::fmod(static_cast<double>(i) * 0.6180339887498949, 1.0);
    some_mm.push_back(points_mm[static_cast<size_t>(share * static_cast<double>(points_mm.size()))]);
  }
  SphereOfMost out = JudgeOneByOne(some_mm, gate_mm);
  if (!out.sphere) {
    ++out.fits;
    out.sphere = FitSphere(points_mm);
  }
  // First those within the gate of the sphere of some, then those within the gate of theirs.
  for (int round = 0; round < 2 && out.sphere; ++round) {
    std::vector<Eigen::Vector3d> kept_mm;
    for (const Eigen::Vector3d& point_mm : points_mm) {
      if (DistanceMm(*out.sphere, point_mm) <= gate_mm) kept_mm.push_back(point_mm);
    }
    ++out.fits;
    const std::optional<Sphere> sphere = FitSphere(kept_mm);
    if (!sphere) break;
    out.sphere = sphere;
  }
  out.off.clear();
  for (size_t k = 0; out.sphere && k < points_mm.size(); ++k) {
    const double off_mm = DistanceMm(*out.sphere, points_mm[k]);
    if (off_mm > gate_mm) out.off.push_back({k, off_mm});
  }
  std::stable_sort(out.off.begin(), out.off.end(),
                   [](const OffSphere& a, const OffSphere& b) { return a.off_mm > b.off_mm; });
  return out;
}

}  // namespace axiscal::touch
