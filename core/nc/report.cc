#include "core/nc/report.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/units.h"

namespace axiscal::nc {
namespace {

reports::Spread SpreadOf(const Spread& spread) {
  return {spread.max_mm * base::kUmPerMm, spread.rms_mm() * base::kUmPerMm, spread.count};
}

reports::AngleSpread SpreadOf(const AngleSpread& spread) {
  return {spread.max_rad * base::kUradPerRad, spread.rms_rad() * base::kUradPerRad, spread.count};
}

std::vector<reports::Finding> FindingsOf(const std::vector<Finding>& findings) {
  std::vector<reports::Finding> list;
  for (const Finding& finding : findings) list.push_back({finding.line, finding.block, finding.reason});
  return list;
}

reports::Orientation OrientationOf(const RewriteReport& report) {
  reports::Orientation orientation;
  orientation.max_rotary_correction_deg = report.max_rotary_correction_rad * base::kDegPerRad;
  for (const RotaryAxisSpread& axis : report.rotary_axes)
    orientation.correction.emplace_back(axis.axis, SpreadOf(axis.correction));
  orientation.error_before = SpreadOf(report.tilt_before);
  orientation.error_after = SpreadOf(report.tilt_after);
  orientation.blocks_not_reached = report.blocks_tilted;
  orientation.not_reached = FindingsOf(report.tilted);
  return orientation;
}

reports::Shift ShiftOf(const Shift& shift, const RewriteReport& report) {
  reports::Shift said;
  if (shift.tool > 0) said.tool = absl::StrFormat("T%d", shift.tool);
  if (shift.tool < 0) said.tool = "called by name";
  said.work_offset = shift.work_offset;
  said.moves = shift.count;
  said.max_um = shift.max_mm * base::kUmPerMm;
  said.rms_um =
      shift.count == 0 ? 0.0 : std::sqrt(shift.sum_squares_mm2 / static_cast<double>(shift.count)) * base::kUmPerMm;
  said.line = shift.line;
  for (size_t i = 0; i < shift.at.size(); ++i) said.at.emplace_back(report.axis_names[i], shift.at[i]);
  return said;
}

// To a thousandth: a picture's numbers, of which there are many.
double Rounded(double value) { return std::round(value * 1000.0) / 1000.0; }

reports::Stretch StretchOf(const Stretch& stretch, const RewriteReport& report) {
  reports::Stretch said;
  said.first = stretch.first_line;
  said.last = stretch.last_line;
  said.way_mm = Rounded(stretch.way_mm);
  for (size_t k = 0; k < report.axes.size(); ++k) {
    said.correction.emplace_back(report.axes[k].axis,
                                 reports::Extremes{Rounded(stretch.least_mm[k] * base::kUmPerMm),
                                                   Rounded(stretch.greatest_mm[k] * base::kUmPerMm)});
  }
  said.before_max_um = Rounded(stretch.before_max_mm * base::kUmPerMm);
  said.after_max_um = Rounded(stretch.after_max_mm * base::kUmPerMm);
  return said;
}

}  // namespace

double Spread::rms_mm() const { return count == 0 ? 0.0 : std::sqrt(sum_squares_mm2 / static_cast<double>(count)); }

void Path::Add(int64_t line, const std::vector<double>& corrections_mm, const std::vector<double>& end_mm,
               double before_mm, double after_mm) {
  double squares_mm2 = 0.0;
  for (size_t k = 0; k < last_mm_.size(); ++k) squares_mm2 += (end_mm[k] - last_mm_[k]) * (end_mm[k] - last_mm_[k]);
  way_mm_ += std::sqrt(squares_mm2);
  last_mm_ = end_mm;
  if (stretches_.empty() || stretches_.back().pieces >= pieces_) {
    if (stretches_.size() == kMostStretches) Halve();
    stretches_.push_back({line, line, 0, way_mm_, corrections_mm, corrections_mm, before_mm, after_mm});
  }
  Stretch& stretch = stretches_.back();
  ++stretch.pieces;
  stretch.last_line = line;
  stretch.way_mm = way_mm_;
  for (size_t k = 0; k < corrections_mm.size(); ++k) {
    stretch.least_mm[k] = std::min(stretch.least_mm[k], corrections_mm[k]);
    stretch.greatest_mm[k] = std::max(stretch.greatest_mm[k], corrections_mm[k]);
  }
  stretch.before_max_mm = std::max(stretch.before_max_mm, before_mm);
  stretch.after_max_mm = std::max(stretch.after_max_mm, after_mm);
}

void Path::Halve() {
  static_assert(kMostStretches % 2 == 0);
  for (size_t i = 0; 2 * i < stretches_.size(); ++i) {
    Stretch one = std::move(stretches_[2 * i]);
    const Stretch& next = stretches_[2 * i + 1];
    one.last_line = next.last_line;
    one.pieces += next.pieces;
    one.way_mm = next.way_mm;
    for (size_t k = 0; k < one.least_mm.size(); ++k) {
      one.least_mm[k] = std::min(one.least_mm[k], next.least_mm[k]);
      one.greatest_mm[k] = std::max(one.greatest_mm[k], next.greatest_mm[k]);
    }
    one.before_max_mm = std::max(one.before_max_mm, next.before_max_mm);
    one.after_max_mm = std::max(one.after_max_mm, next.after_max_mm);
    stretches_[i] = std::move(one);
  }
  stretches_.resize(stretches_.size() / 2);
  pieces_ *= 2;
}

double AngleSpread::rms_rad() const {
  return count == 0 ? 0.0 : std::sqrt(sum_squares_rad2 / static_cast<double>(count));
}

std::vector<reports::AxisRange> PositionsOf(const RewriteReport& found) {
  std::vector<reports::AxisRange> positions;
  for (size_t i = 0; i < found.least.size(); ++i)
    positions.push_back(
        {found.axis_names[i], found.least[i], found.greatest[i], found.axis_is_rotary[i] ? "deg" : "mm"});
  return positions;
}

reports::Rewrite ReportOf(const RewriteReport& found) {
  reports::Rewrite report;
  report.calibration = found.calibration;
  report.calibration_warnings = found.calibration_warnings;
  report.calibration_causes = found.calibration_causes;
  report.dialect = found.dialect;
  report.null_correction = found.is_null_correction;
  report.blocks = {found.blocks_read,   found.blocks_corrected, found.blocks_split,     found.blocks_inserted,
                   found.blocks_passed, found.blocks_refused,   found.blocks_going_back};
  for (const WayBack& way : found.ways_back)
    report.ways_back.push_back({way.line, way.block, way.way_mm * base::kUmPerMm});
  for (const AxisSpread& axis : found.axes) report.correction.emplace_back(axis.axis, SpreadOf(axis.correction));
  for (const Shift& shift : found.shifts) report.shifts.push_back(ShiftOf(shift, found));
  report.missing = found.missing;
  report.rotary_stood_deg.assign(found.rotary_stood.begin(), found.rotary_stood.end());
  report.error_before = SpreadOf(found.error_before);
  report.error_after = SpreadOf(found.error_after);
  report.path_before_at_most_um = found.path_before_max_mm * base::kUmPerMm;
  report.path_after_at_most_um = found.path_after_max_mm * base::kUmPerMm;
  for (const Stretch& stretch : found.path.stretches()) report.path.push_back(StretchOf(stretch, found));
  report.max_tilt_left_urad = found.max_tilt_left_rad * base::kUradPerRad;
  if (found.holes > 0)
    report.holes = {found.holes, found.max_hole_left_mm * base::kUmPerMm, found.holes_left, FindingsOf(found.left)};
  if (found.contour_moves > 0) {
    report.contours = {found.contour_moves, found.max_contour_left_mm * base::kUmPerMm, found.contour_moves_left,
                       FindingsOf(found.contour_left)};
  }
  if (found.has_orientation) report.orientation = OrientationOf(found);
  report.max_departure_um = found.max_departure_mm * base::kUmPerMm;
  report.positions = PositionsOf(found);
  report.passed = FindingsOf(found.passed);
  report.refused = FindingsOf(found.refused);
  report.ranges_not_corrected = found.not_corrected.count;
  report.not_corrected = found.not_corrected.listed;
  report.notes = TextsOf(found.notes);
  for (const Remark& note : found.notes)
    report.note_kinds.push_back({note.kind, note.line > 0 ? std::optional(note.line) : std::nullopt});
  if (found.has_source_crc32c) report.source_crc32c = absl::StrFormat("%08x", found.source_crc32c);
  return report;
}

}  // namespace axiscal::nc
