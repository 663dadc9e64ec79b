// The path of a run whose eccentricity was measured: one rotary axis turns, the linear axes keep the bar at its length.
#ifndef AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_PATH_H_
#define AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_PATH_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/machine/machine.h"

namespace axiscal::instruments {
struct MeasuringRun;
}

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

// The text that ParsePath reads.
std::string ToText(const machine::Machine& machine, const Path& path);

// The path that a measured ball-bar run went, named after its session: one rotary axis turns, the bar's direction stays
// or turns with it. INVALID_ARGUMENT with what does not fit.
absl::StatusOr<Path> PathOf(const machine::Machine& machine, const instruments::MeasuringRun& run);

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
Eigen::Matrix3Xd PolarDirections(const machine::Machine& machine, const Path& path, const std::vector<double>& angles);
// Least squares of dL = r0 + e . p(q) with a free radius: e = weights dL, 3 x angles; the row that the axis does not
// show is zero. `radius`, where asked: the weights of r0, 1 x angles.
Eigen::Matrix3Xd CentreWeights(const machine::Machine& machine, const Path& path, const std::vector<double>& angles,
                               Eigen::RowVectorXd* radius = nullptr);
// Whether the run's axis shows component 0 1 2 (x y z): those of its polar plane.
bool Shows(const machine::Machine& machine, const Path& path, int component);

}  // namespace axiscal::eccentricity

#endif  // AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_PATH_H_
