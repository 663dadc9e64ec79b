#include "core/compensate/tables/sample.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/compensate/nodes.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Curve;
using compensate::Positions;
using compensate::TableBlock;
using compensate::TableColumn;
using machine::ErrorModel;
using machine::ErrorTerm;
using machine::Machine;

constexpr int kLeastSamples = 2000, kMostSamples = 60000;
constexpr double kSamplesPerPeriod = 32.0;
constexpr double kMoreNodes = 1.2;  // growth of the number of equal steps that is tried next

// All columns at a position and sense, mm or rad.
using Evaluator = std::function<absl::Status(double position, double sense, std::vector<double>* values)>;

// The functions of one block over one axis.
struct Sampler {
  const Plan& plan;
  int argument = 0;
  std::vector<double> tolerance;  // per column, mm or rad
  bool by_sense = false;
  Evaluator evaluate;

  size_t sample_count() const {
    const compensate::TableRange& range = plan.ranges[argument];
    double count = kLeastSamples;
    for (const ErrorTerm& term : plan.sampled.terms) {
      const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape);
      if (harmonic == nullptr || harmonic->axis != argument) continue;
      const double periods = (range.max - range.min) * std::abs(harmonic->frequency) / (2.0 * std::numbers::pi);
      count = std::max(count, kSamplesPerPeriod * periods);
    }
    return static_cast<size_t>(std::min<double>(count, kMostSamples));
  }

  // Functions: the columns, forward; then, by sense, the columns, reverse. In units of the tolerance.
  absl::StatusOr<Curve> Sample(const std::vector<double>& positions) const {
    Curve curve;
    curve.position = positions;
    const size_t columns = tolerance.size();
    curve.values.assign(columns * (by_sense ? 2 : 1), {});
    std::vector<double> values(columns);
    for (const double position : positions) {
      for (size_t s = 0; s < (by_sense ? 2u : 1u); ++s) {
        RETURN_IF_ERROR(evaluate(position, !by_sense ? 0.0 : s == 0 ? 1.0 : -1.0, &values));
        for (size_t c = 0; c < columns; ++c) curve.values[s * columns + c].push_back(values[c] / tolerance[c]);
      }
    }
    return curve;
  }

  // Positions of the controller's resolution between `from` and `to`, both included.
  std::vector<double> Even(double from, double to, size_t count, double step) const {
    std::vector<double> positions;
    for (size_t i = 0; i < count; ++i) {
      const double position = Round(from + (to - from) * static_cast<double>(i) / static_cast<double>(count - 1), step);
      if (positions.empty() || position > positions.back()) positions.push_back(position);
    }
    return positions;
  }
};

struct EqualSteps {
  double start = 0.0, step = 0.0;
  size_t count = 0;
};

// At most `points` nodes at equal steps that span the range; with the reference among them where the format asks.
EqualSteps StepsFor(const Plan& plan, int argument, size_t points) {
  const compensate::TableRange& range = plan.ranges[argument];
  const double least = plan.position_step(argument), travel = range.max - range.min;
  constexpr double kRounding = 1e-6;
  const auto whole = [](double steps) { return std::ceil(steps - kRounding); };
  double step = least * std::max(1.0, whole(travel / static_cast<double>(points - 1) / least));
  if (plan.format.limits.power_of_two_steps) step = least * std::exp2(whole(std::log2(step / least)));
  if (!plan.format.limits.from_reference) {
    const double start = least * std::floor(range.min / least + kRounding);
    return {start, step, static_cast<size_t>(std::max(1.0, whole((range.max - start) / step))) + 1};
  }
  // Of all ways to spread the steps over both sides of the reference the one with the shortest step.
  const double reference = Round(plan.reference.position[argument], least);
  const double lower = std::max(0.0, reference - range.min), upper = std::max(0.0, range.max - reference);
  step = std::numeric_limits<double>::infinity();
  for (size_t below = 0; below < points; ++below) {
    const double above = static_cast<double>(points - 1 - below);
    if ((below == 0 && lower > kRounding) || (above == 0 && upper > kRounding)) continue;
    const double longest =
        std::max(below == 0 ? 0.0 : lower / static_cast<double>(below), above == 0 ? 0.0 : upper / above);
    step = std::min(step, least * std::max(1.0, whole(longest / least)));
  }
  const double below = whole(lower / step), above = whole(upper / step);
  return {reference - below * step, step, static_cast<size_t>(below + above) + 1};
}

// Whether increments from node to node stay within what the controller's smallest step allows.
bool IncrementsFit(const Sampler& sampler, const Curve& curve, const std::vector<double>& nodes) {
  const Plan& plan = sampler.plan;
  if (plan.format.limits.most_increments == 0) return true;
  for (size_t f = 0; f < curve.values.size(); ++f) {
    const std::vector<double> values = compensate::FitNodes(curve.position, curve.values[f], nodes);
    const double most = plan.format.limits.most_increments * plan.value_step(sampler.argument) /
                        sampler.tolerance[f % sampler.tolerance.size()];
    for (size_t i = 0; i + 1 < values.size(); ++i) {
      if (std::abs(values[i + 1] - values[i]) > most) return false;
    }
  }
  return true;
}

absl::StatusOr<std::vector<double>> ChooseEqual(const Sampler& sampler) {
  const Plan& plan = sampler.plan;
  const auto most = static_cast<size_t>(plan.max_points);
  size_t points =
      static_cast<size_t>(std::max(plan.format.limits.min_points, plan.format.limits.from_reference ? 3 : 2));
  while (true) {
    points = std::min(points, most);
    const EqualSteps steps = StepsFor(plan, sampler.argument, points);
    std::vector<double> nodes = EqualNodes(steps.start, steps.step, steps.count);
    if (points == most) return nodes;
    ASSIGN_OR_RETURN(const Curve curve,
                     sampler.Sample(sampler.Even(nodes.front(), nodes.back(), sampler.sample_count() / 2,
                                                 plan.position_step(sampler.argument))));
    if (compensate::LargestDeparture(curve, nodes) <= 1.0 && IncrementsFit(sampler, curve, nodes)) return nodes;
    points = std::max(points + 1, static_cast<size_t>(static_cast<double>(points) * kMoreNodes));
  }
}

absl::StatusOr<std::vector<double>> ChooseNodes(const Sampler& sampler) {
  const Plan& plan = sampler.plan;
  if (plan.format.limits.equal_steps) return ChooseEqual(sampler);
  const compensate::TableRange& range = plan.ranges[sampler.argument];
  const double step = plan.position_step(sampler.argument);
  ASSIGN_OR_RETURN(const Curve curve, sampler.Sample(sampler.Even(range.min, range.max, sampler.sample_count(), step)));
  std::vector<double> nodes;
  for (const size_t i : compensate::BestFreeNodes(curve, static_cast<size_t>(plan.max_points)))
    nodes.push_back(curve.position[i]);
  return nodes;
}

absl::StatusOr<TableBlock> SampleBlock(const Sampler& sampler, const std::vector<int>& targets) {
  TableBlock block;
  ASSIGN_OR_RETURN(std::vector<double> nodes, ChooseNodes(sampler));
  const double step = sampler.plan.position_step(sampler.argument);
  const size_t count = std::max(sampler.sample_count(), std::min<size_t>(kMostSamples, 8 * nodes.size()));
  ASSIGN_OR_RETURN(const Curve curve, sampler.Sample(sampler.Even(nodes.front(), nodes.back(), count, step)));
  for (size_t c = 0; c < targets.size(); ++c) {
    TableColumn column;
    column.target = targets[c];
    column.forward = compensate::FitNodes(curve.position, curve.values[c], nodes);
    if (sampler.by_sense && curve.values[c] != curve.values[targets.size() + c])
      column.reverse = compensate::FitNodes(curve.position, curve.values[targets.size() + c], nodes);
    for (double& value : column.forward) value *= sampler.tolerance[c];
    for (double& value : column.reverse) value *= sampler.tolerance[c];
    block.columns.push_back(std::move(column));
  }
  block.arguments.push_back({sampler.argument, std::move(nodes)});
  return block;
}

absl::Status SampleFunctions(const Plan& plan, Content* content) {
  ASSIGN_OR_RETURN(const compensate::CorrectionTarget target, plan.Target(plan.sampled));
  for (const Function& function : plan.functions) {
    const bool is_angle = plan.machine.axes[function.corrected].kind == machine::AxisKind::kRotary;
    Sampler sampler{plan, function.argument, {plan.tolerance(is_angle)}, plan.format.limits.by_sense, {}};
    sampler.evaluate = [&](double position, double sense, std::vector<double>* values) {
      ASSIGN_OR_RETURN(const Positions change, target.Along(function.argument, position, sense));
      (*values)[0] = change[function.corrected];
      return absl::OkStatus();
    };
    ASSIGN_OR_RETURN(TableBlock block, SampleBlock(sampler, {function.corrected}));
    content->table.blocks.push_back(std::move(block));
    content->value_steps.push_back(plan.value_step(function.corrected));
  }
  return absl::OkStatus();
}

// Error components over one axis, or constant ones (argument -1): what one block of a table holds.
struct ComponentGroup {
  int argument = -1;
  std::vector<int> targets;
  bool by_sense = false;
};

std::vector<ComponentGroup> GroupsOf(const Plan& plan) {
  const bool whole_axes = plan.format.limits.whole_axes;
  std::vector<ComponentGroup> groups;
  std::vector<int> arguments = {-1};
  arguments.insert(arguments.end(), plan.arguments.begin(), plan.arguments.end());
  for (const int argument : arguments) {
    const size_t first = groups.size();
    for (const ErrorTerm& term : plan.sampled.terms) {
      if (shapes::VariableAxis(term.shape).value_or(-1) != argument) continue;
      const int target = term.joint * machine::kComponents + static_cast<int>(term.component);
      const auto holds = [&](const ComponentGroup& group) {
        return !whole_axes || group.targets[0] / machine::kComponents == term.joint;
      };
      auto group = std::find_if(groups.begin() + static_cast<long>(first), groups.end(), holds);
      if (group == groups.end()) {
        groups.push_back({argument, {}, false});
        group = groups.end() - 1;
        for (int k = 0; whole_axes && k < machine::kComponents; ++k)
          group->targets.push_back(term.joint * machine::kComponents + k);
      }
      group->by_sense |= std::holds_alternative<shapes::Backlash>(term.shape);
      if (std::find(group->targets.begin(), group->targets.end(), target) == group->targets.end())
        group->targets.push_back(target);
    }
  }
  return groups;
}

absl::Status SampleComponents(const Plan& plan, Content* content) {
  content->table.kind = compensate::TableKind::kErrors;
  const auto value = [&](int target, int argument, double position, double sense) {
    return ComponentAt(plan.machine, plan.sampled, plan.request.state, target, argument, position, sense);
  };
  for (const ComponentGroup& group : GroupsOf(plan)) {
    Sampler sampler{plan, group.argument, {}, group.by_sense, {}};
    for (const int target : group.targets)
      sampler.tolerance.push_back(
          plan.tolerance(machine::IsAngle(static_cast<machine::Component>(target % machine::kComponents))));
    TableBlock block;
    if (group.argument < 0) {
      for (const int target : group.targets) block.columns.push_back({target, {value(target, -1, 0.0, 0.0)}, {}});
    } else {
      sampler.evaluate = [&](double position, double sense, std::vector<double>* values) {
        for (size_t c = 0; c < group.targets.size(); ++c)
          (*values)[c] = value(group.targets[c], group.argument, position, sense);
        return absl::OkStatus();
      };
      ASSIGN_OR_RETURN(block, SampleBlock(sampler, group.targets));
    }
    content->table.blocks.push_back(std::move(block));
    content->value_steps.push_back(0.0);  // by column: see RoundValues
  }
  if (!content->table.blocks.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError("the machine has no error that a table of " + plan.format.name + " can carry");
}

// Values at the points of a grid of the linear axes, as few of equal steps as keep each axis' own function.
absl::Status SampleGrid(const Plan& plan, Content* content) {
  ASSIGN_OR_RETURN(const compensate::CorrectionTarget target, plan.Target(plan.sampled));
  TableBlock block;
  size_t count = 1;
  for (const int argument : plan.arguments) {
    Sampler sampler{plan, argument, std::vector<double>(plan.arguments.size(), plan.tolerance(false)), false, {}};
    sampler.evaluate = [&](double position, double sense, std::vector<double>* values) {
      ASSIGN_OR_RETURN(const Positions change, target.Along(argument, position, sense));
      for (size_t c = 0; c < plan.arguments.size(); ++c) (*values)[c] = change[plan.arguments[c]];
      return absl::OkStatus();
    };
    ASSIGN_OR_RETURN(std::vector<double> nodes, ChooseNodes(sampler));
    count *= nodes.size();
    block.arguments.push_back({argument, std::move(nodes)});
  }
  for (const int corrected : plan.arguments) block.columns.push_back({corrected, {}, {}});
  for (size_t node = 0; node < count; ++node) {
    compensate::Pose pose = plan.reference;
    size_t rest = node;
    for (const compensate::TableArgument& argument : block.arguments) {
      pose.position[argument.axis] = argument.nodes[rest % argument.nodes.size()];
      rest /= argument.nodes.size();
    }
    ASSIGN_OR_RETURN(const Positions change, target.At(pose));
    for (TableColumn& column : block.columns) column.forward.push_back(change[column.target]);
  }
  content->table.blocks.push_back(std::move(block));
  content->value_steps.push_back(plan.value_step(plan.arguments[0]));
  return absl::OkStatus();
}

absl::Status RoundValues(const Plan& plan, Content* content) {
  const Limits& limits = plan.format.limits;
  for (size_t b = 0; b < content->table.blocks.size(); ++b) {
    for (TableColumn& column : content->table.blocks[b].columns) {
      const bool is_angle = IsAngle(content->table, column, plan.machine);
      const bool is_error = content->table.kind == compensate::TableKind::kErrors;
      const double step =
          is_error ? (is_angle ? limits.value_step_deg : limits.value_step_mm) : content->value_steps[b];
      for (std::vector<double>* values : {&column.forward, &column.reverse}) {
        for (double& value : *values) value = Round(value, step);
      }
      if (is_error || is_angle || limits.largest_mm <= 0.0) continue;
      for (const double value : column.forward) {
        if (std::abs(value) <= limits.largest_mm) continue;
        return absl::FailedPreconditionError(absl::StrFormat("correction of %s = %.4f mm, %s takes at most %g mm",
                                                             plan.machine.axes[column.target].name, value,
                                                             plan.format.name, limits.largest_mm));
      }
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<Content> SampleTable(const Plan& plan) {
  Content content;
  content.reference = plan.reference;
  content.tool_tip_mm = plan.request.state.tool_tip_mm;
  for (int i = 0; i < plan.machine.axis_count(); ++i) content.least_steps.push_back(plan.value_step(i));
  switch (plan.format.layout) {
    case Layout::kOwnAxis:
    case Layout::kAnyAxis:
      RETURN_IF_ERROR(SampleFunctions(plan, &content));
      break;
    case Layout::kComponents:
      RETURN_IF_ERROR(SampleComponents(plan, &content));
      break;
    case Layout::kGrid:
      RETURN_IF_ERROR(SampleGrid(plan, &content));
      break;
    case Layout::kPoints:
      content.table.kind = compensate::TableKind::kPoints;
      content.table.points_mm = PointsOf(plan, plan.sampled);
      for (Eigen::Vector3d& point : content.table.points_mm) {
        for (double& coordinate : point) coordinate = Round(coordinate, plan.format.limits.value_step_mm);
      }
      return content;
  }
  if (plan.format.fit != nullptr) RETURN_IF_ERROR(plan.format.fit(plan.machine, &content));
  RETURN_IF_ERROR(RoundValues(plan, &content));
  return content;
}

}  // namespace axiscal::tables
