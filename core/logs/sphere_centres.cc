#include "core/logs/sphere_centres.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/units.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/touch/sphere_fit.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/machine/chain.h"

namespace axiscal::logs {
namespace {

// The nominal tool point as a controller reports it: the tip turned by the rotary axes, plus the way of the linear
// ones.
Eigen::Vector3d ReportedPoint(const machine::Machine& machine, const Eigen::Vector3d& tip_mm,
                              const std::vector<double>& positions) {
  const std::vector<int> linear = centres::LinearAxes(machine);
  std::vector<double> rotary = positions;
  for (const int axis : linear) rotary[axis] = 0.0;
  const auto pose = machine::EvaluateChain<double>(machine, rotary.data(), {});
  const Eigen::Matrix3Xd directions = centres::LinearDirections(machine, rotary.data());
  Eigen::Vector3d point_mm = pose.bed_from_tool * tip_mm;
  for (size_t i = 0; i < linear.size(); ++i)
    point_mm += positions[linear[i]] * directions.col(static_cast<Eigen::Index>(i));
  return point_mm;
}

Eigen::Vector3d NominalCentre(const machine::Machine& machine, const Eigen::Vector3d& ball_mm,
                              const TouchedPose& pose) {
  std::vector<double> rotary = pose.touches.front().positions;
  for (const int axis : centres::LinearAxes(machine)) rotary[axis] = 0.0;
  return machine::EvaluateChain<double>(machine, rotary.data(), {}).bed_from_table * ball_mm;
}

std::string Lines(const TouchedPose& pose) {
  return absl::StrCat("lines ", pose.touches.front().line, " to ", pose.touches.back().line);
}

struct Fit {
  double squares_mm2 = 0.0;  // of the touches' distances from the sphere
  int spare = 0;             // touches beyond the four unknowns
  Eigen::Vector3d variance;  // of the centre, per variance of a touch
};

// The sphere through the touches of one pose.
Fit FitPose(const machine::Machine& machine, const TouchedPose& pose, const CentreOptions& options, SphereCentre* out) {
  std::vector<Eigen::Vector3d> points_mm;
  for (const LatchedTouch& touch : pose.touches)
    points_mm.push_back(ReportedPoint(machine, options.tip_mm, touch.positions));
  const std::optional<touch::Sphere> sphere = touch::FitSphere(points_mm);
  if (!sphere) {
    out->why_not = absl::StrCat(points_mm.size(), points_mm.size() == 1 ? " touch does" : " touches do",
                                " not fix its centre and radius, expected five or more all round");
    return {};
  }
  out->centre_mm = sphere->centre_mm;
  out->radius_mm = sphere->radius_mm;
  const auto count = static_cast<Eigen::Index>(points_mm.size());
  Eigen::MatrixX4d rows(count, 4);
  Eigen::VectorXd off_mm(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Vector3d from_centre_mm = points_mm[k] - sphere->centre_mm;
    rows.row(k) << from_centre_mm.normalized().transpose(), 1.0;
    off_mm[k] = from_centre_mm.norm() - sphere->radius_mm;
  }
  const Eigen::Matrix4d covariance = (rows.transpose() * rows).inverse();
  for (Eigen::Index k = 0; k < count; ++k) {
    // What a touch is off the sphere of the others: its distance over the share of it that the fit leaves.
    const double left = 1.0 - rows.row(k) * covariance * rows.row(k).transpose();
    constexpr double kJudged = 0.05;  // below: the others alone fix no sphere against which it stands
    if (left < kJudged || std::abs(off_mm[k]) <= options.gate_mm * left) continue;
    out->why_not = absl::StrFormat(
        "a touch (line %d, or one of the others) is %.1f um off the sphere of the others, "
        "expected within %g um",
        pose.touches[k].line, off_mm[k] / left * base::kUmPerMm, options.gate_mm * base::kUmPerMm);
  }
  return {off_mm.squaredNorm(), static_cast<int>(count) - 4, covariance.diagonal().head<3>()};
}

// Ascending, of the poses that have a centre.
std::vector<double> RadiiOf(const std::vector<SphereCentre>& poses) {
  std::vector<double> radii_mm;
  for (const SphereCentre& pose : poses) {
    if (pose.why_not.empty()) radii_mm.push_back(pose.radius_mm);
  }
  std::sort(radii_mm.begin(), radii_mm.end());
  return radii_mm;
}

absl::Status CheckRadii(const CentreOptions& options, const std::string& log_name, std::vector<SphereCentre>* poses) {
  const std::vector<double> all_mm = RadiiOf(*poses);
  for (SphereCentre& pose : *poses) {
    if (!pose.why_not.empty()) continue;
    const auto first = std::lower_bound(all_mm.begin(), all_mm.end(), pose.radius_mm - options.gate_mm);
    const auto behind = std::upper_bound(first, all_mm.end(), pose.radius_mm + options.gate_mm);
    const auto alike = (behind - first) - 1, others = static_cast<std::ptrdiff_t>(all_mm.size()) - 1;
    if (2 * alike >= others) continue;
    pose.why_not = absl::StrFormat(
        "its radius is %.4f mm, and only %d of the %d other poses have it within %g um: a "
        "touch is wrong",
        pose.radius_mm, alike, others, options.gate_mm * base::kUmPerMm);
  }
  const std::vector<double> radii_mm = RadiiOf(*poses);
  if (radii_mm.empty() || options.contact_mm <= 0.0) return absl::OkStatus();
  const double median_mm = radii_mm[radii_mm.size() / 2];
  if (std::abs(median_mm - options.contact_mm) <= options.gate_mm) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "%s: the touches lie on a radius of %.4f mm, expected %.4f (sphere_radius_mm + stylus_radius_mm) within "
      "radius_gate_um = %g: was it measured with another stylus?",
      log_name, median_mm, options.contact_mm, options.gate_mm * base::kUmPerMm));
}

}  // namespace

absl::StatusOr<SphereCentres> CentresOf(const machine::Machine& machine, const std::vector<TouchedPose>& poses,
                                        const CentreOptions& options, const std::string& log_name) {
  SphereCentres out;
  out.poses.resize(poses.size());
  std::vector<Fit> fits;
  for (size_t k = 0; k < poses.size(); ++k) fits.push_back(FitPose(machine, poses[k], options, &out.poses[k]));
  RETURN_IF_ERROR(CheckRadii(options, log_name, &out.poses));
  size_t bad = 0, first_bad = poses.size();
  double squares_mm2 = 0.0, spare = 0.0;
  Eigen::Vector3d variance = Eigen::Vector3d::Zero();
  for (size_t k = 0; k < poses.size(); ++k) {
    if (!out.poses[k].why_not.empty()) {
      if (bad++ == 0) first_bad = k;
      continue;
    }
    const double off_mm = (out.poses[k].centre_mm - NominalCentre(machine, options.ball_mm, poses[k])).norm();
    if (!(off_mm <= options.off_ball_mm)) {
      return absl::InvalidArgumentError(
          absl::StrFormat("%s: %s: the sphere's centre is %.3f mm off where the header's table_ball_mm puts it, "
                          "expected within %g: was "
                          "another sphere touched, are table_ball_mm and tool_tip_mm right?",
                          log_name, Lines(poses[k]), off_mm, options.off_ball_mm));
    }
    squares_mm2 += fits[k].squares_mm2;
    spare += fits[k].spare;
    variance += fits[k].variance;
  }
  if (bad == poses.size() || touch::AreTooMany(bad, poses.size())) {
    return absl::InvalidArgumentError(absl::StrCat(log_name, ": ", bad, " of ", poses.size(),
                                                   " poses give no centre, such as that of ", Lines(poses[first_bad]),
                                                   ": ", out.poses[first_bad].why_not));
  }
  out.touch_sigma_mm = std::sqrt(squares_mm2 / spare);
  out.centre_sigma_mm = out.touch_sigma_mm * (variance / static_cast<double>(poses.size() - bad)).cwiseSqrt();
  return out;
}

}  // namespace axiscal::logs
