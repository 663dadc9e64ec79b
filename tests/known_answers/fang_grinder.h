// Probe and rotary axes of a six-axis belt grinder from one sphere (Fang 2022, ch. 4): the thesis' exact model in
// closed form, and the same errors as the one engine writes them. mm, rad; the thesis' angles in deg.
#ifndef AXISCAL_TESTS_KNOWN_ANSWERS_FANG_GRINDER_H_
#define AXISCAL_TESTS_KNOWN_ANSWERS_FANG_GRINDER_H_

#include <Eigen/Geometry>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "core/base/units.h"
#include "core/machine/chain.h"
#include "core/session/session.h"
#include "tests/known_answers/published_machine.h"

namespace axiscal::known_answers::grinder {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Unknowns = Eigen::Matrix<double, 11, 1>;

// Order of the unknowns: lengths mm, angles deg.
enum { kDrpx, kDrpy, kDrpz, kExob, kEzob, kEaob, kEcob, kExoc, kEyoc, kEaoc, kEboc };
inline constexpr const char* kNames[] = {"d_rpx", "d_rpy", "d_rpz", "E_XOB", "E_ZOB", "E_AOB",
                                         "E_COB", "E_XOC", "E_YOC", "E_AOC", "E_BOC"};
inline bool IsAngleOf(int unknown) { return unknown == kEaob || unknown == kEcob || unknown >= kEaoc; }

// "given" of Table 4.7.
inline Unknowns Given() {
  Unknowns given;
  given << 85.557, 287.435, 454.22, -0.417, 0.532, -0.2669, -0.1839, 0.23, 0.367, 0.0434, 0.0121;
  return given;
}

// The design. That of the probe is printed; that of the axes is not, and these numbers stand in for it.
struct Design {
  double rbx = 0, rbz = 500, rcx = 0, rcy = 250;
};
inline const Vector3d kDesignProbeMm(85, -286, -457), kBallMm(-184.183, 0, 15.5);

// Two lines and a point at home: all that the model is made of.
struct Lines {
  Vector3d point_of_b, b, point_of_c, c, probe;
};

inline Lines LinesOf(const Unknowns& u, const Design& design = {}) {
  const auto tangent = [&](int unknown) { return std::tan(u[unknown] * base::kRadPerDeg); };
  return {{design.rbx + u[kExob], 0, -(design.rbz + u[kEzob])},
          Vector3d(-tangent(kEcob), 1, tangent(kEaob)).normalized(),
          {design.rcx + u[kExoc], design.rcy + u[kEyoc], 0},
          Vector3d(tangent(kEboc), -tangent(kEaoc), 1).normalized(),
          {u[kDrpx], -u[kDrpy], -u[kDrpz]}};
}

// w of the exact model, and the linear commands at which the probe stands on the sphere.
inline Vector3d ProbeAt(const Lines& lines, double b_deg, double c_deg) {
  const Matrix3d turn_b = Eigen::AngleAxisd(b_deg * base::kRadPerDeg, lines.b).toRotationMatrix();
  const Matrix3d turn_c = Eigen::AngleAxisd(c_deg * base::kRadPerDeg, lines.c).toRotationMatrix();
  return lines.point_of_b + turn_b * (lines.point_of_c - lines.point_of_b + turn_c * (lines.probe - lines.point_of_c));
}
inline Vector3d CommandsAt(const Lines& lines, double b_deg, double c_deg) {
  return kBallMm - ProbeAt(lines, b_deg, c_deg);
}

// Order of the branches: Y Z B C | X A.
inline constexpr int kJointB = 2, kJointC = 3;

struct InEngine {
  machine::JointErrors<double> errors;
  Vector3d tip_mm;
};

// The poses composed exactly: E_B takes the design's B line to the real one, E_B E_C the design's C line, and the tip
// is the probe as C's carrier sees it.
inline InEngine ToEngine(const Lines& lines, const Design& design = {}) {
  InEngine out;
  const Vector3d point_b(design.rbx, 0, -design.rbz), point_c(design.rcx, design.rcy, 0);
  const double a_b = std::atan2(lines.b.z(), lines.b.y());
  const double c_b = std::atan2(-lines.b.x(), std::hypot(lines.b.y(), lines.b.z()));
  out.errors[kJointB] << lines.point_of_b - point_b, a_b, 0, c_b;
  const auto error_b = machine::ErrorTransform<double>(out.errors[kJointB], point_b);
  const Vector3d direction = error_b.rotation.transpose() * lines.c;
  const double a_c = std::atan2(-direction.y(), direction.z());
  const double b_c = std::atan2(direction.x(), std::hypot(direction.y(), direction.z()));
  Vector3d on_line = error_b.Inverse() * lines.point_of_c;
  on_line -= direction * (on_line.z() / direction.z());
  out.errors[kJointC] << on_line - point_c, a_c, b_c, 0;
  const auto error_c = machine::ErrorTransform<double>(out.errors[kJointC], point_c);
  out.tip_mm = (error_b * error_c).Inverse() * lines.probe;
  return out;
}

// The other way round, near the design.
inline Unknowns FromEngine(const machine::ErrorVector<double>& of_b, const machine::ErrorVector<double>& of_c,
                           const Vector3d& tip_mm, const Design& design = {}) {
  const auto error_b = machine::ErrorTransform<double>(of_b, Vector3d(design.rbx, 0, -design.rbz));
  const auto both = error_b * machine::ErrorTransform<double>(of_c, Vector3d(design.rcx, design.rcy, 0));
  const Vector3d b = error_b.rotation.col(1), c = both.rotation.col(2), probe = both * tip_mm;
  Vector3d point_b = error_b * Vector3d(design.rbx, 0, -design.rbz);
  point_b -= b * (point_b.y() / b.y());
  Vector3d point_c = both * Vector3d(design.rcx, design.rcy, 0);
  point_c -= c * (point_c.z() / c.z());
  const auto deg = [](double tangent) { return std::atan(tangent) * base::kDegPerRad; };
  Unknowns u;
  u << probe.x(), -probe.y(), -probe.z(), point_b.x() - design.rbx, -point_b.z() - design.rbz, deg(b.z() / b.y()),
      deg(-b.x() / b.y()), point_c.x() - design.rcx, point_c.y() - design.rcy, deg(-c.y() / c.z()), deg(c.x() / c.z());
  return u;
}

struct RotaryPose {
  double b_deg, c_deg;
};
inline std::vector<RotaryPose> PatternOne() {
  std::vector<RotaryPose> poses;
  for (int c_deg = 0; c_deg <= 90; c_deg += 5) poses.push_back({0, double(c_deg)});
  return poses;
}
inline std::vector<RotaryPose> PatternTwo() {
  std::vector<RotaryPose> poses;
  for (int b_deg = -20; b_deg <= 45; b_deg += 5) poses.push_back({double(b_deg), 90});
  return poses;
}

inline const machine::Machine& Machine() {
  static const auto& machine = *new machine::Machine(PublishedMachine("fang-grinder/machine.json"));
  return machine;
}

// Sphere centres at these poses, without readings. The design probe is what the control has; the sphere is known to
// `ball_sigma_um` (its certificate), or, without, stands where it was put by hand.
inline session::Session CentresSession(const std::string& name, const std::vector<RotaryPose>& poses,
                                       double start_s = 0.0, std::optional<double> ball_sigma_um = 1e-3,
                                       const std::string& tip_mm = "85 -286 -457") {
  session::Session session;
  session.header = {{"machine", "belt-grinder"}, {"session", name},
                    {"instrument", "centres"},   {"sigma_um", "4"},  // three uniform errors of +-4 um
                    {"tool_tip_mm", tip_mm},     {"table_ball_mm", "-184.183 0 15.5"},
                    {"setup", "sphere"}};
  if (ball_sigma_um) {
    for (const char* key : {"ball_x_sigma_um", "ball_y_sigma_um", "ball_z_sigma_um"})
      session.header.push_back({key, absl::StrCat(*ball_sigma_um)});
  }
  session.columns = {{"t_s", {}, {}}, {"A_deg", {}, {}}, {"B_deg", {}, {}}, {"C_deg", {}, {}}};
  constexpr double kSecondsPerCentre = 60.0;  // seven touches
  for (size_t k = 0; k < poses.size(); ++k) {
    session.columns[0].values.push_back(start_s + kSecondsPerCentre * static_cast<double>(k));
    session.columns[1].values.push_back(0.0);
    session.columns[2].values.push_back(poses[k].b_deg);
    session.columns[3].values.push_back(poses[k].c_deg);
  }
  return session;
}

}  // namespace axiscal::known_answers::grinder

#endif  // AXISCAL_TESTS_KNOWN_ANSWERS_FANG_GRINDER_H_
