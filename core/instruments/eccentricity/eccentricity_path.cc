#include "core/instruments/eccentricity/eccentricity_path.h"

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <sstream>

#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/run.h"
#include "core/machine/chain.h"

namespace axiscal::eccentricity {
namespace {

constexpr double kTurnDeg = 360.0;
constexpr double kAlong = 0.999;  // of the axis' direction along x, y or z: otherwise the trace has no ex, ey, ez

absl::StatusOr<int> RotaryAxis(const machine::Machine& machine, const std::string& name) {
  const int axis = machine::FindAxis(machine, name);
  if (axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kRotary) return axis;
  return absl::InvalidArgumentError("machine " + machine.id + " has no rotary axis '" + name + "'");
}

}  // namespace

absl::StatusOr<Path> ParsePath(const machine::Machine& machine, const std::string& name, const std::string& text) {
  const auto refuse = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat("header 'path ", name, ": ", text, "', ", what));
  };
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  Path path;
  path.name = name;
  std::string axis, kind;
  double from_deg = 0.0, to_deg = 0.0;
  if (!(in >> axis >> from_deg >> to_deg >> kind >> path.bar.x() >> path.bar.y() >> path.bar.z()) ||
      (kind != "fixed" && kind != "turning")) {
    return refuse("expected 'AXIS FROM TO fixed|turning UX UY UZ' in deg, such as 'C 0 360 turning -1 0 0'");
  }
  const auto turned = RotaryAxis(machine, axis);
  if (!turned.ok()) return refuse(std::string(turned.status().message()));
  path.axis = *turned;
  path.is_turning = kind == "turning";
  // A quarter turn separates a free radius from an eccentricity well, a few degrees not at all.
  if (!(to_deg - from_deg >= 30.0 && to_deg - from_deg <= kTurnDeg))
    return refuse("expected TO - FROM of 30 to 360 deg");
  path.from_rad = from_deg * base::kRadPerDeg;
  path.to_rad = to_deg * base::kRadPerDeg;
  if (!(path.bar.norm() > 1e-6)) return refuse("expected a direction other than 0 0 0");
  path.bar.normalize();
  if (machine.axes[path.axis].direction.cwiseAbs().maxCoeff() < kAlong)
    return refuse("axis " + axis + " stands along none of x, y and z: its trace has no ex, ey, ez");
  path.at_rest_rad.assign(machine.axis_count(), 0.0);
  double angle_deg = 0.0;
  while (in >> axis) {
    const auto other = RotaryAxis(machine, axis);
    if (!other.ok()) return refuse(std::string(other.status().message()));
    if (*other == path.axis || !(in >> angle_deg)) return refuse("expected other axes as 'AXIS ANGLE' in deg");
    path.at_rest_rad[*other] = angle_deg * base::kRadPerDeg;
  }
  return path;
}

std::vector<double> AnglesOf(const Path& path) {
  const double range = path.to_rad - path.from_rad;
  const int steps = static_cast<int>(std::ceil(range / base::kRadPerDeg - 1e-9));
  const bool is_whole = range > (kTurnDeg - 1e-6) * base::kRadPerDeg;
  std::vector<double> angles;
  for (int k = 0; k < steps + (is_whole ? 0 : 1); ++k) angles.push_back(path.from_rad + range * k / steps);
  return angles;
}

absl::StatusOr<std::vector<double>> CommandsOf(const machine::Machine& machine, const Path& path,
                                               const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm,
                                               double bar_length_mm) {
  std::vector<double> commands;
  for (const double angle_rad : AnglesOf(path)) {
    std::vector<double> positions = path.at_rest_rad;
    positions[path.axis] = angle_rad;
    Eigen::Vector3d bar = path.bar;
    if (path.is_turning) bar = Eigen::AngleAxisd(angle_rad, machine.axes[path.axis].direction) * bar;
    const auto pose = machine::EvaluateChain<double>(machine, positions.data(), {});
    const Eigen::Vector3d target_mm = ball_mm + pose.bed_from_table.rotation.transpose() * (bar_length_mm * bar);
    RETURN_IF_ERROR(centres::SolveNominalCommands(machine, tip_mm, target_mm, positions.data()));
    // Rounded, so that an axis at rest keeps its position to the last digit: differences tell which axes move, and how.
    constexpr double kGridPerMm = 1e9;
    for (const int axis : centres::LinearAxes(machine))
      positions[axis] = std::round(positions[axis] * kGridPerMm) / kGridPerMm;
    commands.insert(commands.end(), positions.begin(), positions.end());
  }
  return commands;
}

Eigen::Matrix3Xd PolarDirections(const machine::Machine& machine, const Path& path, const std::vector<double>& angles) {
  const Eigen::Vector3d& direction = machine.axes[path.axis].direction;
  int along = 0;
  direction.cwiseAbs().maxCoeff(&along);
  const Eigen::Vector3d reference = Eigen::Vector3d::Unit((along + 1) % 3);
  Eigen::Matrix3Xd directions(3, angles.size());
  for (size_t k = 0; k < angles.size(); ++k)
    directions.col(k) = std::cos(angles[k]) * reference + std::sin(angles[k]) * direction.cross(reference);
  directions.row(along).setZero();
  return directions;
}

bool Shows(const machine::Machine& machine, const Path& path, int component) {
  return std::abs(machine.axes[path.axis].direction[component]) < 0.5;
}

Eigen::Matrix3Xd CentreWeights(const machine::Machine& machine, const Path& path, const std::vector<double>& angles,
                               Eigen::RowVectorXd* radius) {
  const Eigen::Matrix3Xd directions = PolarDirections(machine, path, angles);
  Eigen::MatrixX3d design(directions.cols(), 3);
  int components[2], count = 0;
  for (int c = 0; c < 3; ++c) {
    if (Shows(machine, path, c)) components[count++] = c;
  }
  design << Eigen::VectorXd::Ones(directions.cols()), directions.row(components[0]).transpose(),
      directions.row(components[1]).transpose();
  const Eigen::MatrixXd solved = design.completeOrthogonalDecomposition().pseudoInverse();  // 3 x angles
  Eigen::Matrix3Xd weights = Eigen::Matrix3Xd::Zero(3, directions.cols());
  weights.row(components[0]) = solved.row(1);
  weights.row(components[1]) = solved.row(2);
  if (radius != nullptr) *radius = solved.row(0);
  return weights;
}

std::string ToText(const machine::Machine& machine, const Path& path) {
  std::string text = absl::StrFormat("%s %.10g %.10g %s %.6g %.6g %.6g", machine.axes[path.axis].name,
                                     path.from_rad * base::kDegPerRad, path.to_rad * base::kDegPerRad,
                                     path.is_turning ? "turning" : "fixed", path.bar.x() + 0.0, path.bar.y() + 0.0,
                                     path.bar.z() + 0.0);
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (path.at_rest_rad[axis] != 0.0)
      absl::StrAppendFormat(&text, " %s %.10g", machine.axes[axis].name, path.at_rest_rad[axis] * base::kDegPerRad);
  }
  return text;
}

absl::StatusOr<Path> PathOf(const machine::Machine& machine, const instruments::MeasuringRun& run) {
  Path path;
  path.name = run.session;
  path.at_rest_rad.assign(machine.axis_count(), 0.0);
  int turning = 0;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind != machine::AxisKind::kRotary) continue;
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < run.reading_count(); ++k) {
      low = std::min(low, run.PositionsOf(k)[axis]);
      high = std::max(high, run.PositionsOf(k)[axis]);
    }
    constexpr double kStill = 1e-6;
    if (high - low <= kStill) {
      path.at_rest_rad[axis] = low;
      continue;
    }
    ++turning;
    path.axis = axis;
    path.from_rad = low;
    path.to_rad = high;
  }
  if (turning != 1) return absl::InvalidArgumentError("not one rotary axis turns alone");
  // A whole turn whose last reading stands a step before its end.
  constexpr double kWhole = 2.0 * std::numbers::pi;
  const double step = (path.to_rad - path.from_rad) / std::max(1, run.reading_count() / 2);
  if (path.to_rad - path.from_rad > kWhole - 2.0 * step) path.to_rad = path.from_rad + kWhole;
  Eigen::Vector3d fixed = Eigen::Vector3d::Zero(), turned = fixed;
  bool is_fixed = true, is_turned = true;
  for (int k = 0; k < run.reading_count(); ++k) {
    const double angle_rad = run.PositionsOf(k)[path.axis];
    const auto pose = machine::EvaluateChain<double>(machine, run.PositionsOf(k), {});
    const Eigen::Vector3d bar =
        (pose.bed_from_table.rotation * (machine::TipInTable(pose, run.tip_mm) - run.ball_mm)).normalized();
    const Eigen::Vector3d back = Eigen::AngleAxisd(-angle_rad, machine.axes[path.axis].direction) * bar;
    if (k == 0) {
      fixed = bar;
      turned = back;
    }
    constexpr double kSame = 0.01;  // of the bar's length
    is_fixed &= (bar - fixed).norm() < kSame;
    is_turned &= (back - turned).norm() < kSame;
  }
  if (!is_fixed && !is_turned)
    return absl::InvalidArgumentError("the bar's direction neither stays nor turns with " +
                                      machine.axes[path.axis].name);
  path.is_turning = !is_fixed;
  path.bar = path.is_turning ? turned : fixed;
  constexpr double kDigits = 1e4;  // the rounding of commands is no direction
  path.bar = (path.bar * kDigits).array().round().matrix().normalized();
  return ParsePath(machine, path.name, ToText(machine, path));
}

}  // namespace axiscal::eccentricity
