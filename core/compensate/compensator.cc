#include "core/compensate/compensator.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/units.h"
#include "core/compensate/bend.h"
#include "core/compensate/carried.h"
#include "core/compensate/folded_chain.h"

namespace axiscal::compensate {
namespace {

using machine::ErrorModel;
using machine::ErrorTerm;
using machine::Machine;

constexpr int kMaxIterations = 50;
// Smallest ratio of singular values at which three directions count as reached: a degenerate machine has 1e-16, a
// squareness error of a tenth of a radian 0.9.
constexpr double kRankTolerance = 1e-6;
constexpr double kSmoothTurnRad = 15.0 * base::kRadPerDeg;
constexpr double kSmoothTravelMm = 250.0;  // a quadratic shows in any three samples

std::string PoseText(const Machine& machine, const Pose& pose) {
  std::string text;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
    absl::StrAppendFormat(&text, "%s%s%.4f", text.empty() ? "" : " ", machine.axes[i].name,
                          pose.position[i] * (is_rotary ? base::kDegPerRad : 1.0));
  }
  return text;
}

}  // namespace

struct Compensator::Impl {
  Machine machine;
  Options options;
  ErrorModel carried;
  std::vector<std::string> not_carried;
  std::vector<int> linear_axes;
  std::array<bool, machine::kMaxAxes> uses_sense{};
  bool is_constant = true;  // all carried terms are: the folded chain is exact
  FoldedChain nominal, actual;
  // For DepartureBound: sums of the constant terms' magnitudes, and the terms that are not constant.
  double fixed_lever_mm = 0, translation_errors_mm = 0, angle_errors_rad = 0;
  std::vector<ErrorTerm> varying;
  // The sum of the constant terms, and the joints' maps of it; joints with varying terms get theirs at every pose.
  machine::JointErrors<double> constant;
  JointMaps constant_maps;
  std::vector<int> varying_joints;
  std::array<double, machine::kMaxAxes> smooth_travel{};

  void MeasureErrors() {
    fixed_lever_mm = options.tool_tip_mm.norm();
    for (int i = 0; i < machine.axis_count(); ++i) {
      const machine::Axis& axis = machine.axes[i];
      fixed_lever_mm += 2.0 * axis.point_mm.norm();
      smooth_travel[i] = axis.kind == machine::AxisKind::kRotary ? kSmoothTurnRad : kSmoothTravelMm;
    }
    for (const ErrorTerm& term : carried.terms) {
      if (std::holds_alternative<shapes::Constant>(term.shape)) {
        (machine::IsAngle(term.component) ? angle_errors_rad : translation_errors_mm) += std::abs(term.amplitude[0]);
        constant[term.joint][static_cast<int>(term.component)] += term.amplitude[0];
      } else {
        varying.push_back(term);
        if (std::find(varying_joints.begin(), varying_joints.end(), term.joint) == varying_joints.end())
          varying_joints.push_back(term.joint);
      }
      if (const auto* bump = std::get_if<shapes::Bump>(&term.shape))
        smooth_travel[bump->axis] = std::min(smooth_travel[bump->axis], 0.5 * bump->width);
      if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) {
        constexpr double kShareOfGap = 0.25;  // a map is linear between nodes: what bends is near them
        smooth_travel[map->axis] = std::min(smooth_travel[map->axis], kShareOfGap * GapOf(*map, map->axis));
        if (map->second_axis >= 0)
          smooth_travel[map->second_axis] =
              std::min(smooth_travel[map->second_axis], kShareOfGap * GapOf(*map, map->second_axis));
      }
      if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) {
        const double eighth = 0.25 * std::numbers::pi / std::max(std::abs(harmonic->frequency), 1e-9);
        smooth_travel[harmonic->axis] = std::min(smooth_travel[harmonic->axis], eighth);
      }
    }
  }

  // How far a move turns, twice (the errors' turns and the inverse's), how far it goes, and its longest lever.
  struct Extent {
    double turn_rad = 0, travel_mm = 0, lever_mm = 0;
  };
  Extent ExtentOf(const AxisValues& from, const AxisValues& to) const {
    Extent extent{0, 0, fixed_lever_mm};
    for (int i = 0; i < machine.axis_count(); ++i) {
      const double change = std::abs(to[i] - from[i]);
      if (machine.axes[i].kind == machine::AxisKind::kRotary) {
        extent.turn_rad += 2.0 * change;
      } else {
        extent.travel_mm += change;
        extent.lever_mm += std::max(std::abs(from[i]), std::abs(to[i]));
      }
    }
    return extent;
  }

  // The joints' maps at a pose: only those of varying terms are computed.
  void MapsAt(const Pose& pose, JointMaps* maps) const {
    std::array<shapes::AxisState, machine::kMaxAxes> axes;
    for (int i = 0; i < machine.axis_count(); ++i) {
      axes[i].position = pose.position[i];
      axes[i].sense = pose.sense[i];
    }
    shapes::State state;
    state.axes = {axes.data(), static_cast<size_t>(machine.axis_count())};
    if (options.time_s) state.time_s = *options.time_s;
    if (options.temperature_celsius) state.temperature_celsius = *options.temperature_celsius;
    machine::JointErrors<double> errors;
    for (const int joint : varying_joints) errors[joint] = constant[joint];
    for (const ErrorTerm& term : varying) machine::AddErrors(term, state, &errors);
    for (const int joint : varying_joints) SetMap(machine, joint, errors[joint], maps);
  }

  // How much the tool point's error changes per mm of change of the linear axes near a pose, at most.
  double ErrorSlope(const Pose& pose) const {
    double lever_mm = fixed_lever_mm, slope = 0;
    for (const int axis : linear_axes) lever_mm += std::abs(pose.position[axis]);
    for (const ErrorTerm& term : varying) {
      double amplitude = 0;
      for (int i = 0; i < shapes::BasisCount(term.shape); ++i) amplitude += std::abs(term.amplitude[i]);
      if (machine::IsAngle(term.component)) amplitude *= lever_mm;
      if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) {
        for (const int axis : {map->axis, map->second_axis}) {
          if (axis < 0 || machine.axes[axis].kind == machine::AxisKind::kRotary) continue;
          slope += (map->is_tied ? 2.0 : 1.0) * amplitude / GapOf(*map, axis);
        }
        continue;
      }
      const std::optional<int> axis = shapes::VariableAxis(term.shape);
      if (!axis || machine.axes[*axis].kind == machine::AxisKind::kRotary) continue;  // these stand still
      if (const auto* linear = std::get_if<shapes::Linear>(&term.shape)) {
        slope += amplitude / linear->reference;
      } else if (const auto* quadratic = std::get_if<shapes::Quadratic>(&term.shape)) {
        slope +=
            2.0 * amplitude * (std::abs(pose.position[*axis]) + 1.0) / (quadratic->reference * quadratic->reference);
      } else if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) {
        slope += amplitude * std::abs(harmonic->frequency);
      } else if (const auto* bump = std::get_if<shapes::Bump>(&term.shape)) {
        slope += 0.858 * amplitude / bump->width;
      }
    }
    return slope;
  }

  absl::Status RequireFinite(const Pose& pose) const {
    double nothing = 0;  // not a number when a position is none, or infinite
    for (int i = 0; i < machine.axis_count(); ++i) nothing += 0.0 * pose.position[i];
    if (nothing == 0) return absl::OkStatus();
    for (int i = 0; i < machine.axis_count(); ++i) {
      if (!std::isfinite(pose.position[i])) {
        return absl::InvalidArgumentError(
            absl::StrCat("axis ", machine.axes[i].name, " = ", pose.position[i], ", must be finite"));
      }
    }
    return absl::OkStatus();
  }

  absl::Status RankError(const Pose& pose) const {
    std::string names;
    for (const int axis : linear_axes) absl::StrAppend(&names, names.empty() ? "" : ", ", machine.axes[axis].name);
    return absl::FailedPreconditionError(
        absl::StrCat("machine '", machine.id, "': its linear axes (", names.empty() ? "none" : names,
                     ") cannot move the tool in three directions at ", PoseText(machine, pose)));
  }

  // Commands of the linear axes that move the tool point by `move_mm`; the shortest ones when there are more than three
  // axes.
  absl::Status Solve(const Pose& pose, const Columns& tip_per_mm, const Eigen::Vector3d& move_mm,
                     double* change_mm) const {
    if (tip_per_mm.count == 3) {
      const Eigen::Vector3d &a = tip_per_mm.of_axis[0], &b = tip_per_mm.of_axis[1], &c = tip_per_mm.of_axis[2];
      const Eigen::Vector3d bc = b.cross(c);
      const double volume = a.dot(bc);  // columns are unit vectors: 1 where the axes are square
      if (!(std::abs(volume) > kRankTolerance)) return RankError(pose);
      change_mm[0] = move_mm.dot(bc) / volume;
      change_mm[1] = move_mm.dot(c.cross(a)) / volume;
      change_mm[2] = move_mm.dot(a.cross(b)) / volume;
      return absl::OkStatus();
    }
    Eigen::Matrix3d gram = Eigen::Matrix3d::Zero();
    for (int k = 0; k < tip_per_mm.count; ++k) gram += tip_per_mm.of_axis[k] * tip_per_mm.of_axis[k].transpose();
    if (!(std::abs(gram.determinant()) > kRankTolerance * kRankTolerance)) return RankError(pose);
    const Eigen::Vector3d weights = gram.inverse() * move_mm;
    for (int k = 0; k < tip_per_mm.count; ++k) change_mm[k] = tip_per_mm.of_axis[k].dot(weights);
    return absl::OkStatus();
  }

  // One step at the errors of `commanded`: what the tool point lacks, and the step that would bring it there.
  absl::Status Step(const Pose& pose, const FoldedChain& chain, const Turns& turns, const AffineTip& wanted,
                    Pose* commanded, Eigen::Vector3d* lacking_mm, double* change_mm, AffineTip* found) const {
    double linear_mm[machine::kMaxAxes];
    for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = commanded->position[linear_axes[k]];
    Evaluate(chain, turns, linear_mm, options.tool_tip_mm, machine.tool_direction, true, found);
    *lacking_mm = wanted.tip_in_table_mm - found->tip_in_table_mm;
    return Solve(pose, found->tip_per_mm, *lacking_mm, change_mm);
  }

  void Apply(const double* change_mm, AxisValues* positions) const {
    for (size_t k = 0; k < linear_axes.size(); ++k) (*positions)[linear_axes[k]] += change_mm[k];
  }

  void Finish(const AffineTip& wanted, const AffineTip& found, double after_mm, Correction* correction) const {
    correction->after_mm = after_mm;
    correction->tilt_left_rad = wanted.direction_in_table.cross(found.direction_in_table).norm();
    for (int k = 0; k < found.tip_per_mm.count; ++k) correction->tip_per_mm[k] = found.tip_per_mm.of_axis[k];
  }

  absl::Status Correct(const Pose& pose, const double* near_mm, Correction* correction) const {
    Turns turns;
    EvaluateTurns(machine, pose.position.data(), &turns);
    AffineTip wanted;
    EvaluateNominal(pose, turns, &wanted);
    return Reach(pose, turns, wanted, near_mm, correction);
  }

  void EvaluateNominal(const Pose& pose, const Turns& turns, AffineTip* wanted) const {
    double linear_mm[machine::kMaxAxes];
    for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = pose.position[linear_axes[k]];
    Evaluate(nominal, turns, linear_mm, options.tool_tip_mm, machine.tool_direction, false, wanted);
  }

  absl::Status CorrectTurned(const Pose& pose, const AxisValues& turned, const double* near_mm,
                             Correction* correction) const {
    Turns turns;
    EvaluateTurns(machine, pose.position.data(), &turns);
    AffineTip wanted;
    EvaluateNominal(pose, turns, &wanted);
    FoldedChain varying_chain;
    const FoldedChain& chain = ChainAt(pose, &varying_chain);
    AffineTip found;
    double linear_mm[machine::kMaxAxes];
    for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = pose.position[linear_axes[k]];
    Evaluate(chain, turns, linear_mm, options.tool_tip_mm, machine.tool_direction, false, &found);
    const double before_mm = (wanted.tip_in_table_mm - found.tip_in_table_mm).norm();
    const double tilt_before_rad = wanted.direction_in_table.cross(found.direction_in_table).norm();
    Pose start = pose;
    for (int i = 0; i < machine.axis_count(); ++i) {
      if (machine.axes[i].kind == machine::AxisKind::kRotary) start.position[i] = turned[i];
    }
    EvaluateTurns(machine, start.position.data(), &turns);
    RETURN_IF_ERROR(Reach(start, turns, wanted, near_mm, correction));
    correction->before_mm = before_mm;
    correction->tilt_before_rad = tilt_before_rad;
    return absl::OkStatus();
  }

  // The chain with the errors at a pose.
  const FoldedChain& ChainAt(const Pose& pose, FoldedChain* chain) const {
    if (is_constant) return actual;
    JointMaps maps = constant_maps;
    MapsAt(pose, &maps);
    Fold(machine, linear_axes, maps, chain);
    return *chain;
  }

  void Aim(const Pose& commanded, TurnColumns* columns) const {
    Turns turns;
    EvaluateTurns(machine, commanded.position.data(), &turns);
    double linear_mm[machine::kMaxAxes];
    for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = commanded.position[linear_axes[k]];
    FoldedChain varying_chain;
    EvaluateTurnColumns(ChainAt(commanded, &varying_chain), turns, linear_mm, options.tool_tip_mm,
                        machine.tool_direction, columns);
  }

  // The commands of the linear axes that bring the tool point to `wanted`, the rotary axes being at `pose`.
  absl::Status Reach(const Pose& pose, const Turns& turns, const AffineTip& wanted, const double* near_mm,
                     Correction* correction) const {
    AffineTip found;
    double linear_mm[machine::kMaxAxes];
    for (size_t k = 0; k < linear_axes.size(); ++k) linear_mm[k] = pose.position[linear_axes[k]];
    Eigen::Vector3d lacking_mm;
    double change_mm[machine::kMaxAxes];
    if (is_constant) {
      // The tool point is affine in the linear axes: one step is the answer.
      Evaluate(actual, turns, linear_mm, options.tool_tip_mm, machine.tool_direction, true, &found);
      lacking_mm = wanted.tip_in_table_mm - found.tip_in_table_mm;
      RETURN_IF_ERROR(Solve(pose, found.tip_per_mm, lacking_mm, change_mm));
      correction->corrected = pose.position;
      Apply(change_mm, &correction->corrected);
      correction->before_mm = lacking_mm.norm();
      for (int k = 0; k < found.tip_per_mm.count; ++k) lacking_mm -= found.tip_per_mm.of_axis[k] * change_mm[k];
      Finish(wanted, found, lacking_mm.norm(), correction);
      return absl::OkStatus();
    }
    return Iterate(pose, turns, wanted, near_mm, correction);
  }

  // Errors that vary with the position act at the command that the machine gets: the step is repeated until what the
  // last change of the command may have changed of the errors is below the tolerance. Begins at `near_mm`.
  absl::Status Iterate(const Pose& pose, const Turns& turns, const AffineTip& wanted, const double* near_mm,
                       Correction* correction) const {
    Pose commanded = pose;
    for (const int axis : linear_axes) commanded.position[axis] += near_mm[axis];
    const double slope = ErrorSlope(pose);
    JointMaps maps = constant_maps;
    FoldedChain chain;
    AffineTip found;
    Eigen::Vector3d lacking_mm;
    double change_mm[machine::kMaxAxes];
    for (int iteration = 0; iteration <= kMaxIterations; ++iteration) {
      MapsAt(commanded, &maps);
      Fold(machine, linear_axes, maps, &chain);
      RETURN_IF_ERROR(Step(pose, chain, turns, wanted, &commanded, &lacking_mm, change_mm, &found));
      const double lacking = lacking_mm.norm();
      if (!(lacking < 1e6)) break;
      Apply(change_mm, &commanded.position);
      // The step leaves nothing but the errors' change over it, and rounding.
      double left = 0;
      for (size_t k = 0; k < linear_axes.size(); ++k) left += std::abs(change_mm[k]);
      left = left == 0 ? 0 : left * slope;
      if (left > 0.01 * kToleranceMm) continue;
      Eigen::Vector3d before_mm = Eigen::Vector3d::Zero();
      for (size_t k = 0; k < linear_axes.size(); ++k) {
        const int axis = linear_axes[k];
        before_mm += found.tip_per_mm.of_axis[k] * (commanded.position[axis] - pose.position[axis]);
      }
      correction->before_mm = before_mm.norm();
      correction->corrected = commanded.position;
      Finish(wanted, found, left, correction);
      return absl::OkStatus();
    }
    return absl::FailedPreconditionError(
        absl::StrFormat("no correction found at %s: %.3g um left after %d steps, the errors are too large",
                        PoseText(machine, pose), lacking_mm.norm() * base::kUmPerMm, kMaxIterations));
  }
};

Compensator::Compensator(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Compensator::Compensator(Compensator&&) noexcept = default;
Compensator& Compensator::operator=(Compensator&&) noexcept = default;
Compensator::~Compensator() = default;

absl::StatusOr<Compensator> Compensator::Create(const Machine& machine, const ErrorModel& errors,
                                                const Options& options) {
  RETURN_IF_ERROR(machine::Validate(machine));
  if (!options.tool_tip_mm.allFinite() || options.tool_tip_mm.cwiseAbs().maxCoeff() > 1e6) {
    return absl::InvalidArgumentError("tool tip: every component must be finite, at most 1e6 mm");
  }
  auto impl = std::make_unique<Impl>();
  impl->machine = machine;
  impl->options = options;
  RETURN_IF_ERROR(SelectCarried(machine, errors, options, &impl->carried, &impl->not_carried));
  for (const ErrorTerm& term : impl->carried.terms) {
    impl->is_constant &= std::holds_alternative<shapes::Constant>(term.shape);
    if (const auto* backlash = std::get_if<shapes::Backlash>(&term.shape)) impl->uses_sense[backlash->axis] = true;
  }
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kLinear) impl->linear_axes.push_back(i);
  }
  impl->MeasureErrors();
  Fold(impl->machine, impl->linear_axes, JointMaps(), &impl->nominal);
  for (int joint = 0; joint < machine.joint_count(); ++joint)
    SetMap(impl->machine, joint, impl->constant[joint], &impl->constant_maps);
  if (impl->is_constant) Fold(impl->machine, impl->linear_axes, impl->constant_maps, &impl->actual);
  return Compensator(std::move(impl));
}

absl::StatusOr<Correction> Compensator::Correct(const Pose& pose) const {
  Correction correction;
  RETURN_IF_ERROR(Correct(pose, &correction));
  return correction;
}

absl::Status Compensator::Correct(const Pose& pose, Correction* correction) const {
  static constexpr AxisValues kNothing{};
  return Correct(pose, kNothing, correction);
}

absl::Status Compensator::Correct(const Pose& pose, const AxisValues& near_mm, Correction* correction) const {
  RETURN_IF_ERROR(impl_->RequireFinite(pose));
  return impl_->Correct(pose, near_mm.data(), correction);
}

absl::Status Compensator::CorrectTurned(const Pose& pose, const AxisValues& turned, const AxisValues& near_mm,
                                        Correction* correction) const {
  RETURN_IF_ERROR(impl_->RequireFinite(pose));
  return impl_->CorrectTurned(pose, turned, near_mm.data(), correction);
}

Eigen::Vector3d Compensator::NominalDirection(const Pose& pose) const {
  Turns turns;
  EvaluateTurns(impl_->machine, pose.position.data(), &turns);
  AffineTip wanted;
  impl_->EvaluateNominal(pose, turns, &wanted);
  return wanted.direction_in_table;
}

void Compensator::Aim(const Pose& commanded, TurnColumns* columns) const { impl_->Aim(commanded, columns); }

// The correction is a product of at most two turns per rotary axis (the errors' and the inverse's), linear in the
// linear axes: the second derivative along a move is bounded by the product rule, and a chord departs by at most an
// eighth.
double Compensator::DepartureBound(const AxisValues& from, const AxisValues& to) const {
  constexpr double kSecondOrder = 2.0;  // products of errors, axes out of square
  const auto [turn_rad, travel_mm, lever_mm] = impl_->ExtentOf(from, to);
  const double largest_mm = impl_->translation_errors_mm + impl_->angle_errors_rad * lever_mm;
  double curvature_mm = turn_rad * (turn_rad * largest_mm + 2.0 * impl_->angle_errors_rad * travel_mm);
  for (const ErrorTerm& term : impl_->varying) {
    const Bend bend = BendOf(term, from, to);
    const bool is_angle = machine::IsAngle(term.component);
    const double lever = is_angle ? lever_mm : 1.0, lever_slope = is_angle ? travel_mm : 0.0;
    curvature_mm += bend.curvature * lever + 2.0 * bend.slope * (turn_rad * lever + lever_slope) +
                    bend.size * turn_rad * (turn_rad * lever + 2.0 * lever_slope);
  }
  return kSecondOrder / 8.0 * curvature_mm;
}

// With e the error of direction, |e|, |e'|, |e''| <= E, E T, E T^2 for a turn T, and J the motion of the direction by
// the rotary axes, the change of the commands is d = -J^-1 e. From |J^-1| <= 1/s, |(J^-1)'| <= T/s^2 and
// |(J^-1)''| <= T^2 (1/s^2 + 2/s^3) follows |d''| <= 6 E T^2 / s^3. The linear axes follow on their lever.
double Compensator::TurnDepartureBound(const AxisValues& from, const AxisValues& to, double least_turn,
                                       double* direction_rad) const {
  constexpr double kSecondOrder = 2.0;
  *direction_rad = std::numeric_limits<double>::infinity();
  if (!impl_->is_constant) return std::numeric_limits<double>::infinity();
  const auto [turn_rad, travel_mm, lever_mm] = impl_->ExtentOf(from, to);
  if (turn_rad == 0) {
    *direction_rad = 0;
    return DepartureBound(from, to);
  }
  if (!(least_turn > turn_rad)) return std::numeric_limits<double>::infinity();
  const double least = least_turn - turn_rad, error_rad = impl_->angle_errors_rad;
  const double change_rad = error_rad / least, slope_rad = 2.0 * error_rad * turn_rad / (least * least);
  const double curvature_rad = 6.0 * error_rad * turn_rad * turn_rad / (least * least * least);
  // The lever turns and grows meanwhile.
  const double lever_slope_mm = turn_rad * lever_mm + travel_mm;
  const double lever_curvature_mm = turn_rad * (turn_rad * lever_mm + 2.0 * travel_mm);
  const double follow_mm =
      lever_mm * curvature_rad + 2.0 * lever_slope_mm * slope_rad + lever_curvature_mm * change_rad;
  *direction_rad = kSecondOrder / 8.0 * curvature_rad;
  return DepartureBound(from, to) + kSecondOrder / 8.0 * follow_mm;
}

absl::StatusOr<Compensator> Compensator::WithLongerTool(double length_mm) const {
  Options longer = impl_->options;
  longer.tool_tip_mm += length_mm * impl_->machine.tool_direction;
  return Create(impl_->machine, impl_->carried, longer);
}

double Compensator::smooth_travel(int axis) const { return impl_->smooth_travel[axis]; }
const Machine& Compensator::machine() const { return impl_->machine; }
const std::vector<int>& Compensator::linear_axes() const { return impl_->linear_axes; }
bool Compensator::is_constant() const { return impl_->is_constant; }
bool Compensator::is_null() const { return impl_->carried.terms.empty(); }
bool Compensator::uses_sense(int axis) const { return impl_->uses_sense[axis]; }
const ErrorModel& Compensator::carried() const { return impl_->carried; }
const std::vector<std::string>& Compensator::not_carried() const { return impl_->not_carried; }

}  // namespace axiscal::compensate
