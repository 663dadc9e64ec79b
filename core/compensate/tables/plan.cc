#include "core/compensate/tables/plan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/compensate/tables/text.h"
#include "core/machine/redundant_facts.h"
#include "core/shapes/depends_on.h"

namespace axiscal::tables {
namespace {

using compensate::CorrectionTarget;
using compensate::Positions;
using machine::ErrorTerm;
using machine::Machine;

// Fewer points per period than this follow a harmonic worse than leaving it out: at three a chord halves it.
constexpr double kLeastPointsPerPeriod = 4.0;
constexpr int kProbes = 401;  // positions at which a function is tried for whether there is anything to correct
constexpr double kLargestPosition = 1e6;

absl::StatusOr<int> Named(const Machine& machine, const std::string& field, const std::string& name) {
  const int axis = machine::FindAxis(machine, name);
  if (axis >= 0) return axis;
  return absl::InvalidArgumentError(
      absl::StrCat(field, ": axis '", name, "', which machine '", machine.id, "' has not"));
}

std::string Shown(const machine::Axis& axis, double position) {
  return absl::StrFormat("%g %s", position / FileUnit(axis), UnitName(axis));
}

absl::Status SetRanges(const TableRequest& request, Plan* plan) {
  const Machine& machine = plan->machine;
  RETURN_IF_ERROR(machine::CheckToolTip(machine, request.state.tool_tip_mm));
  for (int i = 0; i < machine.axis_count(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    if (axis.min_position && axis.max_position && *axis.min_position < *axis.max_position)
      plan->ranges[i] = {true, *axis.min_position, *axis.max_position};
  }
  std::array<bool, machine::kMaxAxes> seen{};
  for (const AxisRange& range : request.ranges) {
    ASSIGN_OR_RETURN(const int i, Named(machine, "range", range.axis));
    const machine::Axis& axis = machine.axes[i];
    if (seen[i]) return absl::InvalidArgumentError("range: " + range.axis + " stands twice");
    seen[i] = true;
    const bool is_sane = std::abs(range.min) <= kLargestPosition && std::abs(range.max) <= kLargestPosition;
    if (!is_sane || !(range.max - range.min >= 10.0 * plan->position_step(i))) {
      return absl::InvalidArgumentError(absl::StrCat("range: ", range.axis, " from ", Shown(axis, range.min), " to ",
                                                     Shown(axis, range.max), ", must rise by at least ",
                                                     Shown(axis, 10.0 * plan->position_step(i)), " within +-1e6"));
    }
    constexpr double kRounding = 1e-9;
    if (range.min < axis.min_position.value_or(range.min) - kRounding ||
        range.max > axis.max_position.value_or(range.max) + kRounding) {
      return absl::InvalidArgumentError(absl::StrCat("range: ", range.axis, " from ", Shown(axis, range.min), " to ",
                                                     Shown(axis, range.max), " is beyond the travel in machine.json"));
    }
    plan->ranges[i] = {true, range.min, range.max};
  }
  return absl::OkStatus();
}

absl::Status SetReference(const TableRequest& request, Plan* plan) {
  const Machine& machine = plan->machine;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const compensate::TableRange& range = plan->ranges[i];
    if (range.is_set) plan->reference.position[i] = std::clamp(0.0, range.min, range.max);
  }
  std::array<bool, machine::kMaxAxes> seen{};
  for (const AxisPosition& position : request.reference) {
    ASSIGN_OR_RETURN(const int i, Named(machine, "reference", position.axis));
    const compensate::TableRange& range = plan->ranges[i];
    if (seen[i]) return absl::InvalidArgumentError("reference: " + position.axis + " stands twice");
    seen[i] = true;
    if (!(std::abs(position.position) <= kLargestPosition) ||
        (range.is_set && (position.position < range.min || position.position > range.max))) {
      return absl::InvalidArgumentError(absl::StrCat("reference: ", position.axis, " = ",
                                                     Shown(machine.axes[i], position.position),
                                                     ", must lie in the axis' range"));
    }
    plan->reference.position[i] = position.position;
  }
  return absl::OkStatus();
}

absl::Status RequireRange(const Plan& plan, int axis) {
  if (plan.ranges[axis].is_set) return absl::OkStatus();
  const machine::Axis& described = plan.machine.axes[axis];
  return absl::InvalidArgumentError(absl::StrCat("range: axis ", described.name, " has none: state it (",
                                                 described.name, "=MIN:MAX in ", UnitName(described), "), or travel_",
                                                 UnitName(described), " in machine.json"));
}

// "Y(X)": the correction of Y over X.
absl::StatusOr<Function> ParseFunction(const Plan& plan, const std::string& text) {
  const size_t open = text.find('(');
  Function function;
  ASSIGN_OR_RETURN(function.corrected, Named(plan.machine, "axis", text.substr(0, open)));
  function.argument = function.corrected;
  if (open != std::string::npos) {
    if (text.back() != ')') return absl::InvalidArgumentError("axis: '" + text + "', expected X or Y(X)");
    ASSIGN_OR_RETURN(function.argument, Named(plan.machine, "axis", text.substr(open + 1, text.size() - open - 2)));
  }
  if (function.argument != function.corrected && plan.format.layout == Layout::kOwnAxis) {
    return absl::InvalidArgumentError(
        absl::StrCat("axis: '", text, "': ", plan.format.name, " corrects an axis over its own position only"));
  }
  const bool is_rotary = plan.machine.axes[function.corrected].kind == machine::AxisKind::kRotary;
  if (is_rotary && !plan.format.limits.holds_rotary)
    return absl::InvalidArgumentError(absl::StrCat("axis: '", text, "': ", plan.format.name, " holds no rotary axis"));
  RETURN_IF_ERROR(RequireRange(plan, function.argument));
  return function;
}

// Whether the correction differs from zero anywhere by more than the tolerance.
absl::StatusOr<bool> HasContent(const Plan& plan, const CorrectionTarget& target, const Function& function) {
  const compensate::TableRange& range = plan.ranges[function.argument];
  const bool is_angle = plan.machine.axes[function.corrected].kind == machine::AxisKind::kRotary;
  for (int i = 0; i < kProbes; ++i) {
    const double position = range.min + (range.max - range.min) * i / (kProbes - 1);
    for (const double sense : {1.0, -1.0}) {
      ASSIGN_OR_RETURN(const Positions change,
                       target.Along(function.argument, position, plan.format.limits.by_sense ? sense : 0.0));
      if (std::abs(change[function.corrected]) > plan.tolerance(is_angle)) return true;
    }
  }
  return false;
}

absl::Status AllFunctions(Plan* plan) {
  const Machine& machine = plan->machine;
  for (int i = 0; i < machine.axis_count(); ++i) {
    plan->corrected_rotary[i] = plan->format.limits.holds_rotary && plan->ranges[i].is_set &&
                                machine.axes[i].kind == machine::AxisKind::kRotary;
  }
  ASSIGN_OR_RETURN(const CorrectionTarget target, plan->Target(plan->carried));
  std::vector<std::string> without_range;
  for (int argument = 0; argument < machine.axis_count(); ++argument) {
    if (!plan->ranges[argument].is_set) {
      without_range.push_back(machine.axes[argument].name);
      continue;
    }
    for (int corrected = 0; corrected < machine.axis_count(); ++corrected) {
      if (corrected != argument && plan->format.layout == Layout::kOwnAxis) continue;
      ASSIGN_OR_RETURN(const bool has_content, HasContent(*plan, target, {corrected, argument}));
      if (has_content) plan->functions.push_back({corrected, argument});
    }
  }
  if (!plan->functions.empty()) return absl::OkStatus();
  std::string text = "nothing to correct that " + plan->format.name + " can carry";
  if (!without_range.empty()) {
    absl::StrAppend(&text, "; without a range (state one, or the travel in machine.json): ");
    for (const std::string& name : without_range) absl::StrAppend(&text, name == without_range[0] ? "" : ", ", name);
  }
  return absl::FailedPreconditionError(text);
}

absl::Status SetFunctions(const TableRequest& request, Plan* plan) {
  for (const std::string& text : request.axes) {
    ASSIGN_OR_RETURN(const Function function, ParseFunction(*plan, text));
    if (std::find(plan->functions.begin(), plan->functions.end(), function) != plan->functions.end())
      return absl::InvalidArgumentError("axis: '" + text + "' stands twice");
    plan->functions.push_back(function);
    if (plan->machine.axes[function.corrected].kind == machine::AxisKind::kRotary)
      plan->corrected_rotary[function.corrected] = true;
  }
  if (plan->functions.empty()) RETURN_IF_ERROR(AllFunctions(plan));
  if (plan->format.limits.one_axis && plan->functions.size() > 1) {
    std::string names;
    for (const Function& function : plan->functions)
      absl::StrAppend(&names, names.empty() ? "" : ", ", plan->machine.axes[function.corrected].name);
    return absl::InvalidArgumentError(
        absl::StrCat("axis: a file of ", plan->format.name, " holds one axis; choose one of ", names));
  }
  for (const Function& function : plan->functions) {
    if (std::find(plan->arguments.begin(), plan->arguments.end(), function.argument) == plan->arguments.end())
      plan->arguments.push_back(function.argument);
    // A file with one axis does not correct the other rotary axes.
    if (plan->format.limits.one_axis) plan->corrected_rotary.fill(false);
  }
  for (const Function& function : plan->functions) {
    if (plan->machine.axes[function.corrected].kind == machine::AxisKind::kRotary)
      plan->corrected_rotary[function.corrected] = true;
  }
  return absl::OkStatus();
}

absl::Status SetArguments(const TableRequest& request, Plan* plan) {
  const Machine& machine = plan->machine;
  if (!request.axes.empty() && (plan->format.layout != Layout::kComponents || plan->format.limits.whole_axes))
    return absl::InvalidArgumentError(absl::StrCat("axis: ", plan->format.name, " holds all axes, none can be chosen"));
  for (const std::string& name : request.axes) {
    ASSIGN_OR_RETURN(const int axis, Named(machine, "axis", name));
    if (std::find(plan->together.begin(), plan->together.end(), axis) != plan->together.end())
      return absl::InvalidArgumentError("axis: '" + name + "' stands twice");
    plan->together.push_back(axis);
  }
  for (int i = 0; i < machine.axis_count(); ++i) {
    const bool is_linear = machine.axes[i].kind == machine::AxisKind::kLinear;
    bool is_argument =
        plan->format.layout == Layout::kGrid ? is_linear : plan->format.layout == Layout::kPoints && !is_linear;
    if (plan->format.layout == Layout::kComponents) {
      for (const ErrorTerm& term : plan->carried.terms) is_argument |= shapes::VariableAxis(term.shape) == i;
    }
    is_argument |= std::find(plan->together.begin(), plan->together.end(), i) != plan->together.end();
    if (!is_argument) continue;
    RETURN_IF_ERROR(RequireRange(*plan, i));
    plan->arguments.push_back(i);
  }
  if (plan->format.layout == Layout::kGrid && plan->arguments.size() != 3) {
    return absl::FailedPreconditionError(absl::StrCat(plan->format.name, " needs three linear axes, machine '",
                                                      machine.id, "' has ", plan->arguments.size()));
  }
  return absl::OkStatus();
}

// Harmonics that the format's points cannot follow are left out, and so is backlash without a sense of motion.
void SetSampled(Plan* plan) {
  const Machine& machine = plan->machine;
  for (const ErrorTerm& term : plan->carried.terms) {
    const std::string name = machine::NameOf(machine, term);
    if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape);
        harmonic != nullptr && plan->ranges[harmonic->axis].is_set && plan->max_points > 0) {
      const compensate::TableRange& range = plan->ranges[harmonic->axis];
      const double period = 2.0 * std::numbers::pi / std::abs(harmonic->frequency);
      const double points = period / (range.max - range.min) * (plan->max_points - 1);
      if (points < kLeastPointsPerPeriod) {
        plan->not_carried.push_back(
            absl::StrFormat("%s: %d points over the range of %s are %.2g per period, %g are needed", name,
                            plan->max_points, machine.axes[harmonic->axis].name, points, kLeastPointsPerPeriod));
        continue;
      }
    }
    if (shapes::SecondAxis(term.shape)) {
      plan->not_carried.push_back(name + ": over two axes");
      continue;
    }
    if (shapes::DependsOnSense(term.shape) && !plan->format.limits.by_sense) {
      plan->not_carried.push_back(name + ": " + plan->format.name + " knows no sense of motion");
      continue;
    }
    if (plan->format.limits.whole_axes) {
      const std::optional<int> axis = shapes::VariableAxis(term.shape);
      if (term.joint >= machine.axis_count()) {
        plan->not_carried.push_back(name + ": " + plan->format.name + " holds errors of axes only");
        continue;
      }
      if (axis && *axis != term.joint) {
        plan->not_carried.push_back(name + ": " + plan->format.name +
                                    " holds the errors of an axis over its own position");
        continue;
      }
    }
    plan->sampled.terms.push_back(term);
  }
}

absl::Status CheckNumbers(const Format& format, const TableRequest& request) {
  const Limits& limits = format.limits;
  if (!(request.tolerance_mm >= 1e-6 && request.tolerance_mm <= 1.0)) {
    return absl::InvalidArgumentError(
        absl::StrFormat("tolerance = %g um, must be 0.001 to 1000", request.tolerance_mm * base::kUmPerMm));
  }
  if (request.max_points && (limits.max_points == 0 || *request.max_points < std::max(2, limits.min_points) ||
                             *request.max_points > limits.max_points)) {
    if (limits.max_points == 0)
      return absl::InvalidArgumentError("points: " + format.name + " has no points along an axis");
    return absl::InvalidArgumentError(absl::StrCat("points = ", *request.max_points, ", ", format.name, " takes ",
                                                   std::max(2, limits.min_points), " to ", limits.max_points));
  }
  if (!std::isfinite(request.state.time_s.value_or(0.0)))
    return absl::InvalidArgumentError(absl::StrCat("time = ", *request.state.time_s, " s, must be finite"));
  if (!std::isfinite(request.state.temperature_celsius.value_or(0.0))) {
    return absl::InvalidArgumentError(
        absl::StrCat("temperature = ", *request.state.temperature_celsius, " C, must be finite"));
  }
  if (request.resolution && !limits.is_resolution_free)
    return absl::InvalidArgumentError("resolution: that of " + format.name + " is fixed");
  if (request.resolution && !(*request.resolution >= 1e-6 && *request.resolution <= 0.1))
    return absl::InvalidArgumentError(
        absl::StrFormat("resolution = %g, must be 1e-6 to 0.1 mm or deg", *request.resolution));
  return absl::OkStatus();
}

}  // namespace

double Plan::value_step(int axis) const {
  const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
  const double step = is_rotary ? format.limits.value_step_deg : format.limits.value_step_mm;
  return request.resolution.value_or(step) * FileUnit(machine.axes[axis]);
}

double Plan::position_step(int axis) const {
  const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
  const double step = is_rotary ? format.limits.position_step_deg : format.limits.position_step_mm;
  return step * FileUnit(machine.axes[axis]);
}

double Plan::tolerance(bool is_angle) const { return is_angle ? request.tolerance_mm * 1e-3 : request.tolerance_mm; }

absl::StatusOr<CorrectionTarget> Plan::Target(const machine::ErrorModel& errors) const {
  return CorrectionTarget::Create(machine, errors, request.state, reference, corrected_rotary);
}

absl::StatusOr<Plan> MakePlan(const Machine& machine, const machine::ErrorModel& errors, const Format& format,
                              const TableRequest& request) {
  RETURN_IF_ERROR(CheckNumbers(format, request));
  ASSIGN_OR_RETURN(const auto compensator, compensate::Compensator::Create(machine, errors, request.state));
  Plan plan{machine, format, request};
  plan.carried = compensator.carried();
  plan.not_carried = compensator.not_carried();
  plan.max_points = request.max_points.value_or(format.limits.max_points);
  RETURN_IF_ERROR(SetRanges(request, &plan));
  RETURN_IF_ERROR(SetReference(request, &plan));
  if (format.layout == Layout::kOwnAxis || format.layout == Layout::kAnyAxis)
    RETURN_IF_ERROR(SetFunctions(request, &plan));
  else
    RETURN_IF_ERROR(SetArguments(request, &plan));
  SetSampled(&plan);
  return plan;
}

}  // namespace axiscal::tables
