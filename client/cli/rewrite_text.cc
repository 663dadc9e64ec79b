#include "client/cli/rewrite_text.h"

#include <optional>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cli/line_ranges.h"
#include "client/cli/output.h"

namespace axiscal::cli {
namespace {

// The part of a report that --orientation adds: the first blocks whose direction was not reached by line.
std::string OrientationText(const std::optional<reports::Orientation>& orientation) {
  constexpr size_t kShown = 5;
  if (!orientation) return "";
  const auto row = [](const std::string& name, const reports::AngleSpread& spread) {
    return std::vector<std::string>{name, NumberText(spread.max_urad), NumberText(spread.rms_urad)};
  };
  std::vector<std::vector<std::string>> rows = {{"", "max urad", "rms urad"}};
  for (const auto& [axis, spread] : orientation->correction) rows.push_back(row("correction of " + axis, spread));
  rows.push_back(row("tool direction error before", orientation->error_before));
  rows.push_back(row("tool direction error after", orientation->error_after));
  std::string text = Table(rows);
  const int64_t count = orientation->blocks_not_reached;
  if (count == 0) return text;
  absl::StrAppend(&text, "direction not reached in ", count, count == 1 ? " block" : " blocks",
                  " (no rotary command changes by more than ",
                  absl::StrFormat("%g", orientation->max_rotary_correction_deg), " deg):\n");
  const std::vector<reports::Finding>& findings = orientation->not_reached;
  for (size_t i = 0; i < findings.size() && i < kShown; ++i) {
    absl::StrAppend(&text, "  line ", findings[i].line, ": ", findings[i].block, "  (", findings[i].reason, ")\n");
  }
  if (count > static_cast<int64_t>(kShown)) absl::StrAppend(&text, "  ... more in the report\n");
  return text;
}

// `what`: "holes of drilling cycles", and where something is left of them.
std::string LeftText(const std::optional<reports::Leftovers>& left, const std::string& what, const std::string& where) {
  constexpr size_t kShown = 5;
  if (!left) return "";
  std::string text =
      absl::StrFormat("%d %s, at most %.1f um left %s\n", left->corrected, what, left->left_max_um, where);
  for (size_t i = 0; i < left->left.size() && i < kShown; ++i) {
    const reports::Finding& found = left->left[i];
    absl::StrAppend(&text, "  line ", found.line, ": ", found.block, "  (", found.reason, ")\n");
  }
  if (left->not_exact > static_cast<int64_t>(kShown)) absl::StrAppend(&text, "  ... more in the report\n");
  return text;
}

// By tool and work offset: how many moves, the largest shift and where.
std::string ShiftsText(const std::vector<reports::Shift>& shifts) {
  constexpr size_t kShown = 12;
  if (shifts.empty()) return "";
  std::vector<std::vector<std::string>> rows = {{"tool", "work offset", "moves", "max um", "rms um", "largest at"}};
  for (const reports::Shift& shift : shifts) {
    if (rows.size() > kShown) break;
    std::string at = absl::StrCat("line ", shift.line);
    for (const auto& [axis, position] : shift.at) absl::StrAppend(&at, " ", axis, absl::StrFormat("%.3f", position));
    rows.push_back({shift.tool.empty() ? "-" : shift.tool, shift.work_offset.empty() ? "-" : shift.work_offset,
                    absl::StrCat(shift.moves), NumberText(shift.max_um), NumberText(shift.rms_um), at});
  }
  std::string text = "shift of the moves, all linear axes together:\n" + Table(rows);
  if (shifts.size() > kShown) absl::StrAppend(&text, "  ... more in the report\n");
  return text;
}

// What the calibration's own report says against it.
std::string DoubtsText(const reports::Rewrite& report) {
  std::string text;
  for (const reports::Warning& warning : report.calibration_warnings)
    absl::StrAppend(&text, "warning of the calibration: ", warning.text, "\n");
  for (const reports::Cause& cause : report.calibration_causes)
    absl::StrAppend(&text, "no error of the machine, says the calibration: ", cause.subject, ": ", cause.correction,
                    "\n");
  return text;
}

// Moves that nobody programmed.
std::string WaysBackText(const reports::Rewrite& report) {
  constexpr size_t kShown = 5;
  if (report.ways_back.empty()) return "";
  const int64_t count = report.blocks.going_back;
  std::string text = absl::StrCat(count, count == 1 ? " move was" : " moves were",
                                  " added, back to where the program says that a block which stays as it is begins:\n");
  for (size_t i = 0; i < report.ways_back.size() && i < kShown; ++i) {
    const reports::WayBack& way = report.ways_back[i];
    absl::StrAppend(&text, "  in front of line ", way.line, ": ", way.block, "  (", NumberText(way.way_um), " um)\n");
  }
  if (count > static_cast<int64_t>(kShown)) absl::StrAppend(&text, "  ... more in the report\n");
  return text;
}

}  // namespace

std::string RewriteReportText(const reports::Rewrite& report, const std::string& output, const std::string& dialect) {
  std::string text =
      absl::StrFormat("%s: %d of %d blocks corrected, %d split, %d passed unchanged\ndialect: %s\n", output,
                      report.blocks.corrected, report.blocks.read, report.blocks.split, report.blocks.passed, dialect);
  text += DoubtsText(report);
  std::vector<std::vector<std::string>> rows = {{"", "max um", "rms um"}};
  const auto row = [&rows](const std::string& name, const reports::Spread& spread) {
    rows.push_back({name, NumberText(spread.max_um), NumberText(spread.rms_um)});
  };
  for (const auto& [axis, spread] : report.correction) row("correction of " + axis, spread);
  row("tool-point error before", report.error_before);
  row("tool-point error after", report.error_after);
  absl::StrAppend(&text, Table(rows), ShiftsText(report.shifts), OrientationText(report.orientation),
                  LeftText(report.holes, "holes of drilling cycles", "at the bottom"),
                  LeftText(report.contours, "moves under cutter compensation", "along the contour"));
  text += WaysBackText(report);
  absl::StrAppend(&text, LineRangesText("not corrected", report.not_corrected, report.ranges_not_corrected));
  for (const auto& [axis, angle_deg] : report.rotary_stood_deg)
    absl::StrAppend(&text, axis, " is never named: taken to stand at ", NumberText(angle_deg),
                    " deg, as --start says\n");
  if (!report.missing.empty()) {
    absl::StrAppend(&text, "more would be corrected with:\n");
    for (const std::string& option : report.missing) absl::StrAppend(&text, "  ", option, "\n");
  }
  for (const std::string& note : report.notes) absl::StrAppend(&text, "note: ", note, "\n");
  return text;
}

}  // namespace axiscal::cli
