#include <algorithm>

#include "core/reports/fitted_json.h"
#include "core/reports/report_json.h"
#include "core/reports/rewrite.h"
#include "core/reports/warning_kinds.h"

namespace axiscal::reports {

template <typename Io>
void Members(Io& io, base::Like<Io, Spread> spread) {
  io.Member("max_um", spread.max_um);
  io.Member("rms_um", spread.rms_um);
  io.Member("count", spread.count);
}

template <typename Io>
void Members(Io& io, base::Like<Io, AngleSpread> spread) {
  io.Member("max_urad", spread.max_urad);
  io.Member("rms_urad", spread.rms_urad);
  io.Member("count", spread.count);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Finding> finding) {
  io.Required("line", finding.line);
  io.Member("block", finding.block);
  io.Member("reason", finding.reason);
}

template <typename Io>
void Members(Io& io, base::Like<Io, LineRange> range) {
  io.Required("first", range.first);
  io.Required("last", range.last);
  io.Member("reason", range.reason);
}

template <typename Io>
void Members(Io& io, base::Like<Io, NoteKind> note) {
  io.Required("kind", note.kind);
  io.Member("line", note.line);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Blocks> blocks) {
  io.Member("read", blocks.read);
  io.Member("corrected", blocks.corrected);
  io.Member("split", blocks.split);
  io.Member("inserted", blocks.inserted);
  io.Member("passed", blocks.passed);
  io.Member("refused", blocks.refused);
  io.Member("going_back", blocks.going_back);
}

template <typename Io>
void Members(Io& io, base::Like<Io, WayBack> way) {
  io.Required("line", way.line);
  io.Member("block", way.block);
  io.Member("way_um", way.way_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Orientation> orientation) {
  io.Member("max_rotary_correction_deg", orientation.max_rotary_correction_deg);
  io.IfAny("correction", orientation.correction);
  io.Group("error", [&](auto& error) {
    error.Member("before", orientation.error_before);
    error.Member("after", orientation.error_after);
  });
  io.Member("blocks_not_reached", orientation.blocks_not_reached);
  io.Member("not_reached", orientation.not_reached);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Leftovers> leftovers) {
  io.Member("corrected", leftovers.corrected);
  io.Member("left_max_um", leftovers.left_max_um);
  io.Member("not_exact", leftovers.not_exact);
  io.Member("left", leftovers.left);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Shift> shift) {
  io.Member("tool", shift.tool);
  io.Member("work_offset", shift.work_offset);
  io.Member("moves", shift.moves);
  io.Member("max_um", shift.max_um);
  io.Member("rms_um", shift.rms_um);
  io.Member("line", shift.line);
  io.IfAny("at", shift.at);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Extremes> extremes) {
  io.Member("low_um", extremes.low_um);
  io.Member("high_um", extremes.high_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Stretch> stretch) {
  io.Required("first", stretch.first);
  io.Required("last", stretch.last);
  io.Member("way_mm", stretch.way_mm);
  io.IfAny("correction", stretch.correction);
  io.Member("before_max_um", stretch.before_max_um);
  io.Member("after_max_um", stretch.after_max_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Rewrite> report) {
  io.Member("calibration", report.calibration);
  io.IfAny("calibration_warnings", report.calibration_warnings);
  io.IfAny("calibration_causes", report.calibration_causes);
  io.Member("dialect", report.dialect);
  io.Member("null_correction", report.null_correction);
  io.Member("blocks", report.blocks);
  io.IfAny("correction", report.correction);
  io.Member("shifts", report.shifts);
  io.IfAny("rotary_stood_deg", report.rotary_stood_deg);
  io.Member("missing", report.missing);
  io.Group("tool_point_error", [&](auto& error) {
    error.Member("before", report.error_before);
    error.Member("after", report.error_after);
  });
  io.Group("tool_point_error_along_path", [&](auto& path) {
    path.Member("before_at_most_um", report.path_before_at_most_um);
    path.Member("after_at_most_um", report.path_after_at_most_um);
  });
  io.IfAny("path", report.path);
  io.Member("max_tilt_left_urad", report.max_tilt_left_urad);
  io.Member("orientation", report.orientation);
  io.Member("holes", report.holes);
  io.Member("contours", report.contours);
  io.Member("max_departure_um", report.max_departure_um);
  io.IfAny("positions", report.positions);
  io.Member("passed", report.passed);
  io.Member("refused", report.refused);
  io.IfAny("ways_back", report.ways_back);
  io.Member("ranges_not_corrected", report.ranges_not_corrected);
  io.Member("not_corrected", report.not_corrected);
  io.Member("notes", report.notes);
  io.IfAny("note_kinds", report.note_kinds);
  io.Member("source_crc32c", report.source_crc32c);
}

std::string ToJson(const Rewrite& report) { return base::WriteMembers(report); }

std::vector<std::string> KindsOf(const std::vector<Warning>& warnings, const std::vector<Cause>& causes) {
  std::vector<std::string> kinds;
  const auto add = [&kinds](auto kind) {
    const char* const word = WordsOf(kind)[static_cast<int>(kind)];
    if (std::find(kinds.begin(), kinds.end(), word) == kinds.end()) kinds.emplace_back(word);
  };
  for (const Warning& warning : warnings) add(warning.kind);
  for (const Cause& cause : causes) add(cause.kind);
  return kinds;
}

absl::StatusOr<Rewrite> ReadRewrite(const std::string& text) { return ReadReport<Rewrite>(text); }

}  // namespace axiscal::reports
