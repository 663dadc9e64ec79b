#include "core/figures/circular.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace axiscal::figures {
namespace {

struct Extent {
  double low = 0.0, high = 0.0;
  double width() const { return high - low; }
};

// Unit direction and deviation of each point, columns.
using Points = Eigen::Matrix3Xd;

Extent ExtentAbout(const Points& points, double a, double b) {
  Extent extent{INFINITY, -INFINITY};
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const double d = points(2, i) - a * points(0, i) - b * points(1, i);
    extent.low = std::min(extent.low, d);
    extent.high = std::max(extent.high, d);
  }
  return extent;
}

struct Minimum {
  double at = 0.0, value = 0.0;
};

// Minimum of a convex function on [low, high] by golden section.
template <typename F>
Minimum Least(const F& f, double low, double high) {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kSteps = 45;  // 0.618^45 = 4e-10 of the width
  double one = high - kGolden * (high - low), two = low + kGolden * (high - low);
  double f_one = f(one), f_two = f(two);
  for (int i = 0; i < kSteps; ++i) {
    if (f_one < f_two) {
      high = two;
      two = one;
      f_two = f_one;
      one = high - kGolden * (high - low);
      f_one = f(one);
    } else {
      low = one;
      one = two;
      f_one = f_two;
      two = low + kGolden * (high - low);
      f_two = f(two);
    }
  }
  return f_one < f_two ? Minimum{one, f_one} : Minimum{two, f_two};
}

struct Centre {
  double a = 0.0, b = 0.0, width = 0.0;
};

// The width is convex in the centre, and over a whole turn no centre farther than `reach` from this one has less.
Centre LeastOf(const Points& points, const Centre& about, double reach) {
  const auto best_b = [&](double a) {
    return Least([&](double b) { return ExtentAbout(points, a, b).width(); }, about.b - reach, about.b + reach);
  };
  const Minimum a = Least([&](double at) { return best_b(at).value; }, about.a - reach, about.a + reach);
  return {a.at, best_b(a.at).at, a.value};
}

// The centre of the least width: that of a few points that decide it, to which the outermost and the innermost point
// about it are added until none of the others stands out.
Centre LeastWidth(const Points& points, const Centre& start) {
  constexpr double kDone = 1e-7;  // mm
  constexpr int kStart = 8, kMost = 100;
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index i = 0; i < kStart; ++i) chosen.push_back(i * points.cols() / kStart);
  Centre best = start;
  for (int step = 0; step < kMost; ++step) {
    const Points few = points(Eigen::all, chosen);
    const Centre centre = LeastOf(few, start, start.width);
    Eigen::Index highest = 0, lowest = 0;
    const Eigen::RowVectorXd about = points.row(2) - centre.a * points.row(0) - centre.b * points.row(1);
    const double width = about.maxCoeff(&highest) - about.minCoeff(&lowest);
    if (width < best.width) best = {centre.a, centre.b, width};
    if (width - centre.width < kDone) break;
    chosen.push_back(highest);
    chosen.push_back(lowest);
  }
  return best;
}

}  // namespace

Envelope EnvelopeOf(const std::vector<CirclePoint>& circle) {
  Points points(3, static_cast<Eigen::Index>(circle.size()));
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const CirclePoint& point = circle[static_cast<size_t>(i)];
    points.col(i) << std::cos(point.angle_rad), std::sin(point.angle_rad), point.deviation_mm;
  }
  Eigen::MatrixX3d columns = Eigen::MatrixX3d::Ones(points.cols(), 3);
  columns.rightCols<2>() = points.topRows<2>().transpose();
  const Eigen::VectorXd d = points.row(2).transpose();
  const Eigen::Vector3d fitted = columns.colPivHouseholderQr().solve(d);
  const Extent about = ExtentAbout(points, fitted[1], fitted[2]);
  const Centre least = LeastWidth(points, {fitted[1], fitted[2], about.width()});
  return {least.width, about.width(), about.high, about.low, fitted[0]};
}

double SpanOf(const std::vector<CirclePoint>& points) {
  constexpr double kTurn = 2.0 * std::numbers::pi, kGap = 5.0 / 360.0 * kTurn;
  std::vector<double> angles;
  for (const CirclePoint& point : points)
    angles.push_back(point.angle_rad - kTurn * std::floor(point.angle_rad / kTurn));
  if (angles.size() < 2) return 0.0;
  std::sort(angles.begin(), angles.end());
  double missing = std::max(0.0, angles.front() + kTurn - angles.back());
  missing = missing > kGap ? missing : 0.0;
  for (size_t i = 1; i < angles.size(); ++i)
    if (angles[i] - angles[i - 1] > kGap) missing += angles[i] - angles[i - 1];
  return 1.0 - missing / kTurn;
}

Circular CircularOf(const std::vector<CirclePoint>& ccw, const std::vector<CirclePoint>& cw) {
  Circular out;
  if (!ccw.empty()) out.ccw = EnvelopeOf(ccw);
  if (!cw.empty()) out.cw = EnvelopeOf(cw);
  if (ccw.empty() || cw.empty()) return out;
  std::vector<CirclePoint> both = ccw;
  both.insert(both.end(), cw.begin(), cw.end());
  out.both = EnvelopeOf(both);
  return out;
}

}  // namespace axiscal::figures
