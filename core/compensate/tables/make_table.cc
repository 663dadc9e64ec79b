#include <algorithm>
#include <cmath>
#include <memory>

#include "core/base/units.h"
#include "core/compensate/tables/plan.h"
#include "core/compensate/tables/read_back.h"
#include "core/compensate/tables/report.h"
#include "core/compensate/tables/sample.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Deviation;
using compensate::Pose;
using compensate::Positions;
using compensate::Table;
using compensate::TableBlock;
using compensate::TableColumn;

constexpr int kPosesWithin = 2000;
constexpr int kPosesPerTerm = 300;
// A term counts as carried where less than this part of its effect stays.
constexpr double kCarriedPart = 0.1;

std::vector<Pose> PosesAlongAll(const Plan& plan, const Table& table) {
  std::vector<Pose> poses;
  // A table of errors serves wherever the machine goes, also along axes over which nothing varies.
  std::vector<int> axes = plan.arguments;
  for (int i = 0; plan.format.layout == Layout::kComponents && i < plan.machine.axis_count(); ++i) {
    if (plan.ranges[i].is_set && std::find(axes.begin(), axes.end(), i) == axes.end()) axes.push_back(i);
  }
  for (const int axis : axes) {
    std::vector<double> nodes;
    for (const TableBlock& block : table.blocks) {
      for (const compensate::TableArgument& argument : block.arguments) {
        if (argument.axis == axis) nodes.insert(nodes.end(), argument.nodes.begin(), argument.nodes.end());
      }
    }
    std::sort(nodes.begin(), nodes.end());
    const std::vector<Pose> along = PosesAlong(plan.reference, axis, plan.ranges[axis], nodes);
    poses.insert(poses.end(), along.begin(), along.end());
  }
  return poses;
}

// Tables of corrections are zero at the reference. The error of an axis there belongs to its zero: it is subtracted
// with and without the table, so that before and after show the effect of the table.
absl::StatusOr<Positions> ZerosOf(const Plan& plan, const machine::ErrorModel& errors) {
  if (plan.format.layout == Layout::kComponents || plan.format.layout == Layout::kPoints) return Positions{};
  ASSIGN_OR_RETURN(const compensate::CorrectionTarget target, plan.Target(errors));
  return target.constant();
}

// What a table of corrections itself adds at the reference, mean of both senses (because a format is zero there in one
// sense only, or because of rounding): a shift of the zero as well.
absl::StatusOr<Positions> ShiftOf(const Plan& plan, const Table& table) {
  Positions shift{};
  if (table.kind != compensate::TableKind::kCorrections) return shift;
  ASSIGN_OR_RETURN(const Positions commanded,
                   CommandedWith(table, plan.machine, plan.request.state.tool_tip_mm, plan.reference));
  for (size_t i = 0; i < shift.size(); ++i) shift[i] = commanded[i] - plan.reference.position[i];
  return shift;
}

Positions Difference(const Positions& a, const Positions& b) {
  Positions difference = a;
  for (size_t i = 0; i < difference.size(); ++i) difference[i] -= b[i];
  return difference;
}

Positions Sum(const Positions& a, const Positions& b) {
  Positions sum = a;
  for (size_t i = 0; i < sum.size(); ++i) sum[i] += b[i];
  return sum;
}

compensate::Commander Without(const Positions& zeros) {
  return [zeros](const Pose& pose) { return Sum(pose.position, zeros); };
}

compensate::Commander With(const Plan& plan, const Table& table, const Positions& zeros) {
  return [&plan, table, zeros](const Pose& pose) -> absl::StatusOr<Positions> {
    ASSIGN_OR_RETURN(const Positions commanded,
                     CommandedWith(table, plan.machine, plan.request.state.tool_tip_mm, pose));
    return Sum(commanded, zeros);
  };
}

// How far the table departs from the exact function, over positions between the nodes.
absl::StatusOr<std::vector<ColumnReport>> CheckColumns(const Plan& plan, const Table& table) {
  std::vector<ColumnReport> reports;
  ASSIGN_OR_RETURN(const compensate::CorrectionTarget target, plan.Target(plan.carried));
  const bool is_correction = table.kind == compensate::TableKind::kCorrections;
  for (const TableBlock& block : table.blocks) {
    for (const TableColumn& column : block.columns) {
      ColumnReport report;
      report.name = TargetName(table, block, column, plan.machine);
      report.is_angle = IsAngle(table, column, plan.machine);
      report.by_sense = !column.reverse.empty();
      for (const compensate::TableArgument& argument : block.arguments) {
        report.arguments.push_back(plan.machine.axes[argument.axis].name);
        report.points.push_back(argument.nodes.size());
        report.from.push_back(argument.nodes.front() / FileUnit(plan.machine.axes[argument.axis]));
        report.to.push_back(argument.nodes.back() / FileUnit(plan.machine.axes[argument.axis]));
      }
      std::vector<Pose> poses;
      if (block.arguments.size() == 1) {
        const int axis = block.arguments[0].axis;
        poses = PosesAlong(plan.reference, axis, plan.ranges[axis], block.arguments[0].nodes);
      } else {
        compensate::TableRanges ranges{};
        for (const compensate::TableArgument& argument : block.arguments)
          ranges[argument.axis] = plan.ranges[argument.axis];
        poses = PosesWithin(plan.machine, plan.reference, ranges, block.arguments.empty() ? 1 : kPosesWithin);
      }
      // As in With(): less what the table adds at the reference.
      const double shift = is_correction ? ValueAt(block, column, plan.reference) : 0.0;
      for (const Pose& pose : poses) {
        double wanted = 0.0;
        if (table.kind == compensate::TableKind::kErrors) {
          const auto at = [&](int argument, double position, double sense) {
            return ComponentAt(plan.machine, plan.carried, plan.request.state, column.target, argument, position,
                               sense);
          };
          if (block.arguments.empty()) wanted = at(-1, 0.0, 0.0);
          for (const compensate::TableArgument& argument : block.arguments)
            wanted += at(argument.axis, pose.position[argument.axis], pose.sense[argument.axis]);
        } else {
          ASSIGN_OR_RETURN(const Positions change, target.At(pose));
          wanted = change[column.target];
        }
        report.wanted.Add(std::abs(wanted));
        report.left.Add(std::abs(wanted - ValueAt(block, column, pose) + shift));
      }
      reports.push_back(std::move(report));
    }
  }
  return reports;
}

// What an exact table of this layout would command for one term alone.
absl::StatusOr<compensate::Commander> ExactCommander(const Plan& plan, const machine::ErrorModel& term) {
  if (plan.format.layout == Layout::kPoints) {
    Table table;
    table.kind = compensate::TableKind::kPoints;
    table.points_mm = PointsOf(plan, term);
    return With(plan, table, Positions{});
  }
  ASSIGN_OR_RETURN(compensate::CorrectionTarget made, plan.Target(term));
  const auto target = std::make_shared<const compensate::CorrectionTarget>(std::move(made));
  return compensate::Commander([&plan, target](const Pose& pose) -> absl::StatusOr<Positions> {
    Positions commanded = Sum(pose.position, target->constant());
    if (plan.format.layout == Layout::kGrid) {
      Pose in_grid = plan.reference;
      for (const int axis : plan.arguments) in_grid.position[axis] = pose.position[axis];
      ASSIGN_OR_RETURN(const Positions change, target->At(in_grid));
      for (const int axis : plan.arguments) commanded[axis] += change[axis];
      return commanded;
    }
    for (const Function& function : plan.functions) {
      const double sense = plan.format.limits.by_sense ? pose.sense[function.argument] : 0.0;
      ASSIGN_OR_RETURN(const Positions change,
                       target->Along(function.argument, pose.position[function.argument], sense));
      commanded[function.corrected] += change[function.corrected];
    }
    return commanded;
  });
}

// Lists terms of which this layout leaves a part at the tool point, however many points and however fine steps it has.
absl::Status ListLeft(const Plan& plan, std::vector<std::string>* not_carried) {
  if (plan.format.layout == Layout::kComponents) return absl::OkStatus();
  const std::vector<Pose> poses = PosesWithin(plan.machine, plan.reference, plan.ranges, kPosesPerTerm);
  for (const machine::ErrorTerm& term : plan.sampled.terms) {
    machine::ErrorModel alone;
    alone.terms = {term};
    const compensate::TableChecker checker(plan.machine, alone, plan.request.state, plan.reference);
    ASSIGN_OR_RETURN(const compensate::Commander command, ExactCommander(plan, alone));
    ASSIGN_OR_RETURN(const Positions zeros, ZerosOf(plan, alone));
    ASSIGN_OR_RETURN(const compensate::PointError error, checker.Check(Without(zeros), command, poses));
    if (error.after.largest <= std::max(kCarriedPart * error.before.largest, plan.request.tolerance_mm)) continue;
    if (error.after.largest > error.before.largest + plan.request.tolerance_mm) {
      not_carried->push_back(absl::StrFormat(
          "%s: alone it would be worse with the table, %.2f um at the tool point within the ranges instead of %.2f: it "
          "turns with axes that the table is not over",
          machine::NameOf(plan.machine, term), error.after.largest * base::kUmPerMm,
          error.before.largest * base::kUmPerMm));
      continue;
    }
    not_carried->push_back(absl::StrFormat("%s: %.2f of %.2f um at the tool point stay within the ranges",
                                           machine::NameOf(plan.machine, term), error.after.largest * base::kUmPerMm,
                                           error.before.largest * base::kUmPerMm));
  }
  return absl::OkStatus();
}

// Where the controller's points do not reach the tolerance.
void ListCoarse(const Plan& plan, const std::vector<ColumnReport>& columns, std::vector<std::string>* not_carried) {
  for (const ColumnReport& column : columns) {
    const double tolerance = plan.tolerance(column.is_angle);
    const bool is_full = std::any_of(column.points.begin(), column.points.end(), [&](size_t points) {
      return static_cast<double>(points) > 0.8 * plan.max_points;
    });
    const int axis = machine::FindAxis(plan.machine, column.name);
    const double step = axis < 0 ? 0.0 : plan.value_step(axis);
    if (!is_full || column.left.largest <= 1.5 * tolerance + step) continue;
    const double factor = column.is_angle ? base::kUradPerRad : base::kUmPerMm;
    not_carried->push_back(
        absl::StrFormat("%s over %s: %.3f of %.3f %s stay where %.3f was asked for: %d points cannot follow it closer",
                        column.name, column.arguments[0], column.left.largest * factor, column.wanted.largest * factor,
                        column.is_angle ? "urad" : "um", tolerance * factor, plan.max_points));
  }
}

void ListZeros(const Plan& plan, const Positions& zeros, std::vector<std::string>* not_carried) {
  for (int i = 0; i < plan.machine.axis_count(); ++i) {
    const bool is_angle = plan.machine.axes[i].kind == machine::AxisKind::kRotary;
    if (std::abs(zeros[i]) <= plan.tolerance(is_angle)) continue;
    not_carried->push_back(absl::StrFormat(
        "%s is off by %.2f %s at the reference: tables are zero there, it belongs into the zero of the axis",
        plan.machine.axes[i].name, -zeros[i] * (is_angle ? base::kUradPerRad : base::kUmPerMm),
        is_angle ? "urad" : "um"));
  }
}

// "B, C": axes that move within the ranges but are no argument of the table.
std::string AxesBeside(const Plan& plan) {
  std::string names;
  for (int i = 0; i < plan.machine.axis_count(); ++i) {
    const bool is_over = std::find(plan.arguments.begin(), plan.arguments.end(), i) != plan.arguments.end();
    const bool is_free = is_over && (plan.format.layout == Layout::kGrid || plan.arguments.size() == 1);
    if (plan.ranges[i].is_set && !is_free)
      absl::StrAppend(&names, names.empty() ? "" : ", ", plan.machine.axes[i].name);
  }
  return names.empty() ? "the other axes" : names;
}

// A table that makes things worse is not handed out.
absl::Status Judge(const Plan& plan, const TableReport& report) {
  const double rounding =
      2.0 * plan.request.tolerance_mm + 2.0 * plan.value_step(plan.arguments.empty() ? 0 : plan.arguments[0]);
  const auto worse = [&](const Deviation& before, const Deviation& after, const char* where) -> absl::Status {
    if (after.rms() <= before.rms() + rounding) return absl::OkStatus();
    return absl::FailedPreconditionError(
        absl::StrFormat("the table would make the tool point worse: %.2f um rms %s instead of %.2f. Its values hold "
                        "for one position of "
                        "%s. Narrow the ranges, put the reference (--reference) where the work is, or take another "
                        "format; programs can "
                        "be corrected at every position (compensate)",
                        after.rms() * base::kUmPerMm, where, before.rms() * base::kUmPerMm, AxesBeside(plan)));
  };
  RETURN_IF_ERROR(worse(report.along.before, report.along.after, "along the axes"));
  return worse(report.within.before, report.within.after, "within the ranges");
}

}  // namespace

absl::StatusOr<MadeTable> MakeTable(const machine::Machine& machine, const machine::ErrorModel& errors,
                                    const TableRequest& request) {
  ASSIGN_OR_RETURN(const Format* format, FindFormat(request.format));
  ASSIGN_OR_RETURN(const Plan plan, MakePlan(machine, errors, *format, request));
  ASSIGN_OR_RETURN(Content content, SampleTable(plan));
  ASSIGN_OR_RETURN(const std::string bare, format->write(machine, content));
  ASSIGN_OR_RETURN(const Table read, ReadBack(plan, content.table, bare));

  TableReport report;
  ASSIGN_OR_RETURN(report.columns, CheckColumns(plan, read));
  const compensate::TableChecker checker(machine, plan.carried, request.state, plan.reference);
  ASSIGN_OR_RETURN(const Positions zeros, ZerosOf(plan, plan.carried));
  ASSIGN_OR_RETURN(const Positions shift, ShiftOf(plan, read));
  const Positions zeros_with = Difference(zeros, shift);
  const compensate::Commander without = Without(zeros), with = With(plan, read, zeros_with);
  ASSIGN_OR_RETURN(report.along, checker.Check(without, with, PosesAlongAll(plan, read)));
  ASSIGN_OR_RETURN(report.within,
                   checker.Check(without, with, PosesWithin(machine, plan.reference, plan.ranges, kPosesWithin)));
  RETURN_IF_ERROR(Judge(plan, report));
  report.not_carried = plan.not_carried;
  ListCoarse(plan, report.columns, &report.not_carried);
  RETURN_IF_ERROR(ListLeft(plan, &report.not_carried));
  ListZeros(plan, zeros_with, &report.not_carried);
  AddTilt(report.within.tilt_rad, &report.not_carried);

  content.notes = NotesOf(plan, report);
  MadeTable made;
  ASSIGN_OR_RETURN(made.text, format->write(machine, content));
  RETURN_IF_ERROR(ReadBack(plan, content.table, made.text).status());
  made.report_json = reports::ToJson(ReportOf(plan, report));
  return made;
}

}  // namespace axiscal::tables
