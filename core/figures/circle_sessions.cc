#include "core/figures/circle_sessions.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "core/base/units.h"
#include "core/figures/noise.h"
#include "core/machine/chain.h"

namespace axiscal::figures {
namespace {

using instruments::MeasuringRun;

struct Plane {
  std::string name;  // "XY"
  Eigen::Vector3d first, second;
};

// The plane of two axes, in the order in which a right-handed turn takes one to the other: XY, YZ, ZX.
Plane PlaneOf(const Eigen::Vector3d& normal) {
  int at = 0;
  normal.cwiseAbs().maxCoeff(&at);
  static const char* const kNames[] = {"YZ", "ZX", "XY"};
  return {kNames[at], Eigen::Vector3d::Unit((at + 1) % 3), Eigen::Vector3d::Unit((at + 2) % 3)};
}

std::string Key(const MeasuringRun& run, const std::string& plane) {
  return absl::StrFormat("%s %.3f %.3f %.3f %.3f %.3f %.3f %.3f", plane, run.bar_length_mm, run.ball_mm.x(),
                         run.ball_mm.y(), run.ball_mm.z(), run.tip_mm.x(), run.tip_mm.y(), run.tip_mm.z());
}

void AddEnvelope(const std::optional<Envelope>& envelope, const std::string& suffix, const std::string& words,
                 bool is_one_sense, std::vector<Figure>* figures) {
  if (!envelope) return;
  figures->push_back({"G" + suffix, "circular deviation, " + words, envelope->width_mm});
  if (is_one_sense) {
    figures->push_back({"F" + suffix + " max", "radial deviation, largest, " + words, envelope->max_mm});
    figures->push_back({"F" + suffix + " min", "radial deviation, least, " + words, envelope->min_mm});
  } else {
    figures->push_back({"D", "mean radius of both senses less the nominal one", envelope->mean_mm});
  }
}

// From the table ball to the tool ball at each reading, table's frame, of the nominal machine.
std::vector<Eigen::Vector3d> BarsOf(const machine::Machine& machine, const MeasuringRun& run) {
  std::vector<Eigen::Vector3d> bars;
  for (int k = 0; k < run.reading_count(); ++k) {
    const auto pose = machine::EvaluateChain<double>(machine, run.PositionsOf(k), machine::JointErrors<double>());
    bars.push_back(machine::TipInTable(pose, run.tip_mm) - run.ball_mm);
  }
  return bars;
}

void AddReadings(const MeasuringRun& run, const std::vector<Eigen::Vector3d>& bars, const Plane& plane,
                 Circle* circle) {
  circle->radius_mm = run.bar_length_mm;
  circle->runs.push_back(&run);
  const auto angle_of = [&](int k) { return std::atan2(bars[k].dot(plane.second), bars[k].dot(plane.first)); };
  for (int k = 0; k < run.reading_count(); ++k) {
    // The way to this reading, of the first one the way from it.
    const int to = std::max(1, k);
    const double turn = std::remainder(angle_of(to) - angle_of(to - 1), 2.0 * M_PI);
    const int sense = turn >= 0.0 ? 0 : 1;
    circle->of_sense[sense].push_back({angle_of(k), run.measured_mm(0, k)});
    circle->sigma_mm[sense].push_back(run.sigma_mm);
    for (const instruments::StatedEffect& effect : run.stated) {
      std::vector<double>& by_sigma_mm = circle->stated_mm[sense][effect.of];
      by_sigma_mm.resize(circle->sigma_mm[sense].size(), 0.0);
      by_sigma_mm.back() = effect.by_sigma_mm(0, k);
    }
  }
}

}  // namespace

std::optional<std::string> AddCircle(const machine::Machine& machine, const MeasuringRun& run,
                                     std::map<std::string, Circle>* circles) {
  const std::vector<Eigen::Vector3d> bars = BarsOf(machine, run);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  double farthest = 0.0;
  for (const Eigen::Vector3d& bar : bars) {
    const Eigen::Vector3d across = bars.front().cross(bar);
    if (across.norm() > farthest) {
      farthest = across.norm();
      normal = across.normalized();
    }
  }
  constexpr double kSquare = 0.02;  // of the radius that the bar may stand out of the plane
  const Plane plane = PlaneOf(normal);
  for (const Eigen::Vector3d& bar : bars) {
    if (std::abs(bar.dot(plane.first.cross(plane.second))) > kSquare * bar.norm())
      return "the bar does not stay in a plane of two machine axes";
  }
  Circle& circle = (*circles)[Key(run, plane.name)];
  circle.plane = plane.name;
  AddReadings(run, bars, plane, &circle);
  return std::nullopt;
}

std::optional<std::string> AddCone(const machine::Machine& machine, const MeasuringRun& run,
                                   std::map<std::string, Circle>* circles) {
  const std::vector<Eigen::Vector3d> bars = BarsOf(machine, run);
  // The ends of the bar lie in a plane across the cone's axis: the direction in which they scatter least.
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& bar : bars) mean += bar.normalized() / static_cast<double>(bars.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& bar : bars) {
    const Eigen::Vector3d off = bar.normalized() - mean;
    scatter += off * off.transpose();
  }
  Eigen::Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  // Away from the ball on the table where the bar opens that way; else along the machine axis that is nearest.
  constexpr double kFlat = 0.01;
  int nearest = 0;
  axis.cwiseAbs().maxCoeff(&nearest);
  const double along = std::abs(mean.dot(axis)) > kFlat ? mean.dot(axis) : axis[nearest];
  if (along < 0.0) axis = -axis;
  constexpr double kSame = 0.02;  // of the bar's length: a degree
  for (const Eigen::Vector3d& bar : bars) {
    if (std::abs(bar.normalized().dot(axis) - mean.dot(axis)) > kSame)
      return "the bar does not go round at a constant angle to an axis of the table";
  }
  const double half_deg = std::acos(std::clamp(mean.dot(axis), -1.0, 1.0)) * base::kDegPerRad;
  constexpr double kLeastDeg = 1.0;
  if (half_deg < kLeastDeg || mean.norm() > std::cos(kLeastDeg * base::kRadPerDeg))
    return "the bar does not go round as the table sees it";
  const Eigen::Vector3d first = (bars.front() - bars.front().dot(axis) * axis).normalized();
  const Eigen::Vector3d shown = (axis * 100.0).array().round().matrix() / 100.0 + Eigen::Vector3d::Zero();
  const std::string name = absl::StrFormat("half angle %.0f deg about (%.2f %.2f %.2f)", half_deg, shown.x() + 0.0,
                                           shown.y() + 0.0, shown.z() + 0.0);
  Circle& circle = (*circles)[Key(run, name)];
  circle.plane = name;
  circle.is_cone = true;
  AddReadings(run, bars, {name, first, axis.cross(first)}, &circle);
  return std::nullopt;
}

MeasuredTest CircleTest(const Circle& circle) {
  MeasuredTest test;
  test.kind = circle.is_cone ? "cone" : "circle";
  test.what = absl::StrFormat(circle.is_cone ? "cone of %s, bar %g mm" : "circle %s, radius %g mm", circle.plane,
                              circle.radius_mm);
  for (const MeasuringRun* run : circle.runs) test.sessions.push_back(run->session);
  test.temperature_celsius = MeanTemperature(circle.runs);
  NoteStated(circle.runs, &test.notes);
  constexpr double kWhole = 0.99;  // of a turn
  static const char* const kWords[] = {"counter-clockwise", "clockwise"};
  bool is_whole[2];
  for (int sense = 0; sense < 2; ++sense) {
    const double span = SpanOf(circle.of_sense[sense]);
    is_whole[sense] = span >= kWhole;
    if (!is_whole[sense] && !circle.of_sense[sense].empty())
      test.notes.push_back(absl::StrFormat("%s: the readings span %.0f deg, and figures are of a whole turn: none",
                                           kWords[sense], 360.0 * span));
    if (circle.of_sense[sense].empty()) test.notes.push_back(absl::StrCat("not measured ", kWords[sense]));
  }
  test.figures = WithNoise([&](const std::function<double()>& noise, bool is_alone) {
    std::vector<CirclePoint> drawn[2];
    std::map<std::string, double> stated;  // each fact is off by so many standard uncertainties, in both senses alike
    for (const auto& of_sense : circle.stated_mm)
      for (const auto& [of, by_sigma_mm] : of_sense) stated.try_emplace(of, 0.0);
    for (auto& [of, off] : stated) off = noise();
    for (int sense = 0; sense < 2; ++sense) {
      if (!is_whole[sense]) continue;
      drawn[sense] = circle.of_sense[sense];
      for (size_t i = 0; i < drawn[sense].size(); ++i) {
        double& d = drawn[sense][i].deviation_mm;
        d = (is_alone ? 0.0 : d) + circle.sigma_mm[sense][i] * noise();
        for (const auto& [of, by_sigma_mm] : circle.stated_mm[sense])
          if (i < by_sigma_mm.size()) d += stated.at(of) * by_sigma_mm[i];
      }
    }
    const Circular circular = CircularOf(drawn[0], drawn[1]);
    std::vector<Figure> figures;
    AddEnvelope(circular.ccw, " ccw", "counter-clockwise", true, &figures);
    AddEnvelope(circular.cw, " cw", "clockwise", true, &figures);
    AddEnvelope(circular.both, "(b)", "both senses", false, &figures);
    return figures;
  });
  return test;
}

}  // namespace axiscal::figures
