// The path of a run whose eccentricity was measured: one rotary axis turns, the linear axes keep the bar at its length.
#ifndef AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_PATH_H_
#define AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_PATH_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/machine/machine.h"

namespace axiscal::eccentricity {

// `# path NAME: AXIS FROM TO fixed|turning UX UY UZ [AXIS ANGLE ...]`, deg: the axis turns from FROM to TO; the tool
// ball stands a bar's length from the table ball along (UX, UY, UZ), which stays fixed to the bed or turns with the
// axis from where it points at 0; other rotary axes stand at the angles named, else at 0.
struct Path {
  std::string name;
  int axis = 0;
  double from_rad = 0.0, to_rad = 0.0;  // from < to
  bool is_turning = false;
  Eigen::Vector3d bar = Eigen::Vector3d::UnitX();  // unit, bed's axes
  std::vector<double> at_rest_rad;                 // per axis; linear ones 0
};

// INVALID_ARGUMENT naming the key, the text and the rule.
absl::StatusOr<Path> ParsePath(const machine::Machine& machine, const std::string& name, const std::string& text);

// The angles at which the trace is taken: every degree or less; a whole turn without its end.
std::vector<double> AnglesOf(const Path& path);

// Axis commands per angle, mm or rad, angle-major; `tip_mm` and `ball_mm` at home, machine frame. FAILED_PRECONDITION
// when the linear axes do not span three directions.
absl::StatusOr<std::vector<double>> CommandsOf(const machine::Machine& machine, const Path& path,
                                               const Eigen::Vector3d& tip_mm, const Eigen::Vector3d& ball_mm,
                                               double bar_length_mm);

// The plane of the polar trace: dL at angle q is drawn in the direction cos q r + sin q (d x r), d the axis' direction
// and r the machine axis after it (C: x, B: z, A: y), so that C has (cos q, sin q) in (x, y) and B (sin q, cos q) in
// (x, z), as Yao 2022 has them. 3 x angles, rows x y z.
Eigen::Matrix3Xd PolarDirections(const machine::Machine& machine, const Path& path);

}  // namespace axiscal::eccentricity

#endif  // AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_PATH_H_
