#include "core/compensate/tables/report.h"

#include <cmath>

#include "core/base/units.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using compensate::Deviation;

constexpr double kShownTiltRad = 1e-6;

double Factor(bool is_angle) { return is_angle ? base::kUradPerRad : base::kUmPerMm; }
const char* Unit(bool is_angle) { return is_angle ? "urad" : "um"; }

// To a nanometre: the last digits are rounding, which differs between machines.
double Rounded(double value) { return std::round(value * 1e3) / 1e3; }

reports::PointSpread SpreadOf(const Deviation& deviation) {
  return {Rounded(deviation.largest * base::kUmPerMm), Rounded(deviation.rms() * base::kUmPerMm)};
}

std::string Text(const Deviation& deviation) {
  return absl::StrFormat("%.3f um at most, %.3f rms", deviation.largest * base::kUmPerMm,
                         deviation.rms() * base::kUmPerMm);
}

std::string RangesText(const Plan& plan) {
  std::string text;
  for (int i = 0; i < plan.machine.axis_count(); ++i) {
    const machine::Axis& axis = plan.machine.axes[i];
    if (!plan.ranges[i].is_set) continue;
    absl::StrAppend(&text, text.empty() ? "" : ", ", axis.name, " ", Fixed(plan.ranges[i].min / FileUnit(axis), 4),
                    " to ", Fixed(plan.ranges[i].max / FileUnit(axis), 4), " ", UnitName(axis));
  }
  return text;
}

std::string ReferenceText(const Plan& plan) {
  std::string text;
  for (int i = 0; i < plan.machine.axis_count(); ++i) {
    const machine::Axis& axis = plan.machine.axes[i];
    absl::StrAppend(&text, text.empty() ? "" : " ", axis.name, Fixed(plan.reference.position[i] / FileUnit(axis), 4));
  }
  return text;
}

std::string ColumnText(const ColumnReport& column) {
  std::string text = column.name;
  for (size_t i = 0; i < column.arguments.size(); ++i)
    absl::StrAppend(&text, i == 0 ? " over " : " x ", column.arguments[i], " (", column.points[i], " points)");
  return text + absl::StrFormat(": up to %.3f %s, the table leaves %.3f at most, %.3f rms",
                                column.wanted.largest * Factor(column.is_angle), Unit(column.is_angle),
                                column.left.largest * Factor(column.is_angle),
                                column.left.rms() * Factor(column.is_angle));
}

}  // namespace

void AddTilt(double tilt_rad, std::vector<std::string>* not_carried) {
  if (tilt_rad <= kShownTiltRad) return;
  not_carried->push_back(absl::StrFormat("orientation: the tool stays tilted against the table by up to %.1f urad",
                                         tilt_rad * base::kUradPerRad));
}

std::vector<std::string> NotesOf(const Plan& plan, const TableReport& report) {
  const Eigen::Vector3d& tip = plan.request.state.tool_tip_mm;
  std::vector<std::string> notes = {
      absl::StrCat("axiscal table, format ", plan.format.name, ", machine ", plan.machine.id,
                   plan.request.calibration.empty() ? "" : ", calibration " + plan.request.calibration),
      "values: " + plan.format.values,
      absl::StrCat("reference: ", ReferenceText(plan), "; tool point at home ", Fixed(tip.x(), 4), " ",
                   Fixed(tip.y(), 4), " ", Fixed(tip.z(), 4), " mm"),
      "ranges: " + RangesText(plan)};
  if (!plan.format.assumed.empty()) {
    notes.push_back("assumed: " + plan.format.assumed);
    notes.push_back(
        "before production: load one table, move to its largest value, see that the axis goes where this file says");
  }
  for (const ColumnReport& column : report.columns) notes.push_back(ColumnText(column));
  notes.push_back("tool point along the axes: " + Text(report.along.before) + " before; " + Text(report.along.after) +
                  " with it");
  notes.push_back("tool point within the ranges: " + Text(report.within.before) + " before; " +
                  Text(report.within.after) + " with it");
  for (const std::string& line : report.not_carried) notes.push_back("not carried: " + line);
  for (const std::string& line : plan.request.notes) notes.push_back("note: " + line);
  return notes;
}

reports::Table ReportOf(const Plan& plan, const TableReport& found) {
  reports::Table report;
  report.format = plan.format.name;
  report.machine = plan.machine.id;
  report.calibration = plan.request.calibration;
  report.values = plan.format.values;
  const Eigen::Vector3d& tip = plan.request.state.tool_tip_mm;
  report.tool_tip_mm = {tip.x(), tip.y(), tip.z()};
  for (int i = 0; i < plan.machine.axis_count(); ++i) {
    const machine::Axis& axis = plan.machine.axes[i];
    const std::string key = axis.name + "_" + UnitName(axis);
    report.reference.emplace_back(key, Rounded(plan.reference.position[i] / FileUnit(axis)));
    if (plan.ranges[i].is_set) {
      report.ranges.push_back(
          {key, {Rounded(plan.ranges[i].min / FileUnit(axis)), Rounded(plan.ranges[i].max / FileUnit(axis))}});
    }
  }
  for (const ColumnReport& column : found.columns) {
    const double factor = Factor(column.is_angle);
    report.tables.push_back({.of = column.name,
                             .over = column.arguments,
                             .points = {column.points.begin(), column.points.end()},
                             .from = column.from,
                             .to = column.to,
                             .by_sense = column.by_sense,
                             .unit = Unit(column.is_angle),
                             .largest = Rounded(column.wanted.largest * factor),
                             .left_max = Rounded(column.left.largest * factor),
                             .left_rms = Rounded(column.left.rms() * factor)});
  }
  report.along_axes = {SpreadOf(found.along.before), SpreadOf(found.along.after)};
  report.within_ranges = {SpreadOf(found.within.before), SpreadOf(found.within.after)};
  report.not_carried = found.not_carried;
  report.cannot_carry = plan.format.cannot_carry;
  report.notes = plan.request.notes;
  return report;
}

}  // namespace axiscal::tables
