#include "core/reports/table.h"

#include "core/reports/report_json.h"

namespace axiscal::reports {

template <typename Io>
void Members(Io& io, base::Like<Io, Column> column) {
  io.Required("of", column.of);
  io.Member("over", column.over);
  io.Member("points", column.points);
  io.Member("from", column.from);
  io.Member("to", column.to);
  io.Member("by_sense", column.by_sense);
  io.Member("unit", column.unit);
  io.Member("largest", column.largest);
  io.Member("left_max", column.left_max);
  io.Member("left_rms", column.left_rms);
}

template <typename Io>
void Members(Io& io, base::Like<Io, PointSpread> spread) {
  io.Member("max_um", spread.max_um);
  io.Member("rms_um", spread.rms_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, PointError> error) {
  io.Member("before", error.before);
  io.Member("after", error.after);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Table> report) {
  io.Member("format", report.format);
  io.Member("machine", report.machine);
  io.Member("calibration", report.calibration);
  io.Member("values", report.values);
  io.Member("tool_tip_mm", report.tool_tip_mm);
  io.Member("reference", report.reference);
  io.Member("ranges", report.ranges);
  io.Member("tables", report.tables);
  io.Group("tool_point_error", [&](auto& error) {
    error.Member("along_axes", report.along_axes);
    error.Member("within_ranges", report.within_ranges);
  });
  io.Member("not_carried", report.not_carried);
  io.Member("cannot_carry", report.cannot_carry);
  io.Member("notes", report.notes);
}

std::string ToJson(const Table& report) { return base::WriteMembers(report); }

absl::StatusOr<Table> ReadTable(const std::string& text) { return ReadReport<Table>(text); }

}  // namespace axiscal::reports
