#include "core/compensate/tables/sample.h"

#include <algorithm>
#include <cmath>

#include "core/compensate/tables/block_sampler.h"
#include "core/compensate/tables/text.h"
#include "core/shapes/depends_on.h"

namespace axiscal::tables {
namespace {

using compensate::Positions;
using compensate::TableBlock;
using compensate::TableColumn;
using machine::ErrorModel;
using machine::ErrorTerm;
using machine::Machine;

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
      group->by_sense |= shapes::DependsOnSense(term.shape);
      if (std::find(group->targets.begin(), group->targets.end(), target) == group->targets.end())
        group->targets.push_back(target);
    }
  }
  return groups;
}

// Replaces the blocks over single axes that were asked for together by one over the grid of their positions: sums.
absl::Status JoinBlocks(const Plan& plan, Content* content) {
  constexpr size_t kMostRows = 100000;
  if (plan.together.size() < 2) return absl::OkStatus();
  TableBlock joined;
  std::vector<TableBlock> rest, parts(plan.together.size());
  size_t rows = 1;
  for (TableBlock& block : content->table.blocks) {
    const auto at = block.arguments.empty()
                        ? plan.together.end()
                        : std::find(plan.together.begin(), plan.together.end(), block.arguments[0].axis);
    (at == plan.together.end() ? rest.emplace_back() : parts[static_cast<size_t>(at - plan.together.begin())]) =
        std::move(block);
  }
  for (size_t d = 0; d < parts.size(); ++d) {
    const int axis = plan.together[d];
    if (parts[d].arguments.empty()) parts[d].arguments = {{axis, {plan.ranges[axis].min, plan.ranges[axis].max}}};
    rows *= parts[d].arguments[0].nodes.size();
    joined.arguments.push_back(parts[d].arguments[0]);
    for (const TableColumn& column : parts[d].columns) {
      if (d > 0 && !column.reverse.empty()) {
        return absl::FailedPreconditionError(absl::StrCat("axis: the errors over ", plan.machine.axes[axis].name,
                                                          " depend on its sense of motion: name it first"));
      }
      const auto same = [&](const TableColumn& known) { return known.target == column.target; };
      if (std::none_of(joined.columns.begin(), joined.columns.end(), same))
        joined.columns.push_back({column.target, {}, {}});
    }
  }
  if (rows > kMostRows) {
    return absl::FailedPreconditionError(absl::StrCat("axis: the grid would have ", rows, " rows, at most ", kMostRows,
                                                      ": allow a larger tolerance or name fewer axes"));
  }
  for (TableColumn& sum : joined.columns) {
    sum.forward.assign(rows, 0.0);
    size_t stride = 1;
    for (const TableBlock& part : parts) {
      const size_t count = part.arguments[0].nodes.size();
      for (const TableColumn& column : part.columns) {
        if (column.target != sum.target) continue;
        if (!column.reverse.empty()) sum.reverse.assign(rows, 0.0);
        for (size_t row = 0; row < rows; ++row) {
          const size_t node = row / stride % count;
          sum.forward[row] += column.forward[node];
          if (!sum.reverse.empty())
            sum.reverse[row] += column.reverse.empty() ? column.forward[node] : column.reverse[node];
        }
      }
      stride *= count;
    }
  }
  rest.push_back(std::move(joined));
  content->table.blocks = std::move(rest);
  content->value_steps.assign(content->table.blocks.size(), 0.0);
  return absl::OkStatus();
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
  if (!content->table.blocks.empty()) return JoinBlocks(plan, content);
  return absl::FailedPreconditionError("the machine has no error that a table of " + plan.format.name + " can carry");
}

// Values at the points of a grid of the linear axes, with as few equal steps as keep each axis' function in tolerance.
absl::Status SampleGrid(const Plan& plan, Content* content) {
  ASSIGN_OR_RETURN(const compensate::CorrectionTarget target, plan.Target(plan.sampled));
  TableBlock block;
  size_t count = 1;
  for (const int argument : plan.arguments) {
    // The departures of all axes' functions add up.
    const double share = plan.tolerance(false) / static_cast<double>(plan.arguments.size());
    Sampler sampler{plan, argument, std::vector<double>(plan.arguments.size(), share), false, {}};
    sampler.evaluate = [&](double position, double sense, std::vector<double>* values) {
      ASSIGN_OR_RETURN(const Positions change, target.Along(argument, position, sense));
      for (size_t c = 0; c < plan.arguments.size(); ++c) (*values)[c] = change[plan.arguments[c]];
      return absl::OkStatus();
    };
    sampler.is_fitted = false;
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
