#include "server/inputs/calibration_use.h"

#include <algorithm>
#include <cmath>

#include "absl/time/time.h"
#include "core/base/error_detail.h"
#include "core/machine/machine_json.h"
#include "core/reports/calibration.h"

namespace axiscal::inputs {
namespace {

bool SameAxis(const machine::Axis& a, const machine::Axis& b) {
  return a.name == b.name && a.kind == b.kind && a.direction == b.direction && a.point_mm == b.point_mm;
}

bool SameChain(const machine::Machine& a, const machine::Machine& b) {
  return std::equal(a.axes.begin(), a.axes.end(), b.axes.begin(), b.axes.end(), SameAxis) &&
         a.tool_branch == b.tool_branch && a.work_branch == b.work_branch && a.tool_direction == b.tool_direction;
}

// Combinations stand in the engine's report only.
bool DeterminesACombination(const std::string& report_json) {
  const absl::StatusOr<reports::CalibrationReport> report = reports::ReadCalibrationReport(report_json);
  return report.ok() && !reports::FittedOf(*report).determined.empty();
}

// No machine that moves has more. Lengths and scales (um/m): 20 mm, or 2 % of a travel, ten times the share of its size
// at which an identification warns (reports::BeyondSize). Angles: six degrees; joints of an arm that was put together
// anew may be off by some. What a forgotten stylus or m in place of mm leaves is beyond them.
constexpr double kMostUm = 20'000.0, kMostUrad = 100'000.0;

}  // namespace

absl::StatusOr<machine::Machine> MachineFor(storage::Database& database,
                                            const records::CalibrationRecord& calibration) {
  ASSIGN_OR_RETURN(const records::MachineRecord now, database.GetMachine(calibration.content.machine));
  ASSIGN_OR_RETURN(const records::MachineRecord then,
                   database.GetMachineRevision(now.id, calibration.content.machine_revision));
  ASSIGN_OR_RETURN(machine::Machine machine, machine::MachineFromJson(now.description_json));
  ASSIGN_OR_RETURN(const machine::Machine fitted, machine::MachineFromJson(then.description_json));
  if (SameChain(machine, fitted)) return machine;
  return base::Error(
      absl::StatusCode::kFailedPrecondition,
      absl::StrCat("the axes of machine ", machine.id, " were changed since calibration ", calibration.id.number(),
                   " was identified (revision ", then.revision, ", now ", now.revision, "): identify again"),
      {"MACHINE_CHANGED", {}});
}

absl::Status CheckSizes(const records::CalibrationRecord& calibration) {
  for (const records::Estimate& estimate : calibration.content.estimates) {
    const bool is_um = estimate.unit == records::EstimateUnit::kUm;
    const double most = is_um ? kMostUm : kMostUrad;
    if (!estimate.value || std::abs(*estimate.value) <= most) continue;
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("calibration ", calibration.id.number(), " has ", estimate.symbol, " = ",
                                    *estimate.value, is_um ? " um" : " urad", ", no machine has more than ", most,
                                    ": a length, a radius or a unit of its sessions or of machine.json is wrong; its "
                                    "report says what may be. Mend that and identify again"),
                       {"CALIBRATION_NOT_PLAUSIBLE", {{"symbol", estimate.symbol}}});
  }
  return absl::OkStatus();
}

absl::Status CheckUsable(storage::Database& database, const records::CalibrationRecord& calibration) {
  RETURN_IF_ERROR(MachineFor(database, calibration).status());
  RETURN_IF_ERROR(CheckSizes(calibration));
  const std::vector<records::Estimate>& estimates = calibration.content.estimates;
  const bool has_number = std::any_of(estimates.begin(), estimates.end(),
                                      [](const records::Estimate& estimate) { return estimate.identifiable; });
  if (has_number || DeterminesACombination(calibration.content.report_json)) return absl::OkStatus();
  return base::Error(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat("calibration ", calibration.id.number(),
                                  estimates.empty() ? " holds no error: nothing was declared and nothing found"
                                                    : " holds no error that its sessions determine",
                                  ", so there is nothing to compensate"),
                     {"CALIBRATION_EMPTY", {}});
}

absl::Status CheckTables(storage::Database& database, const records::CalibrationRecord& calibration, bool are_off) {
  if (are_off) return absl::OkStatus();
  const MachineId& machine = calibration.content.machine;
  ASSIGN_OR_RETURN(std::vector<records::HandedTable> tables, database.ListHandedTables(machine));
  if (tables.empty()) return absl::OkStatus();
  std::stable_sort(tables.begin(), tables.end(), [](const records::HandedTable& a, const records::HandedTable& b) {
    return a.handed_at > b.handed_at;
  });
  constexpr size_t kMostNamed = 10;  // a text that is still read
  std::string text;
  for (size_t i = 0; i < std::min(tables.size(), kMostNamed); ++i) {
    absl::StrAppend(
        &text, text.empty() ? "" : ", ", tables[i].format, " of calibration ", tables[i].calibration.number(), " on ",
        absl::FormatTime("%Y-%m-%d", absl::FromUnixMicros(base::ToUtcUs(tables[i].handed_at)), absl::UTCTimeZone()),
        " to ", tables[i].handed_to);
  }
  if (tables.size() > kMostNamed) absl::StrAppend(&text, " and ", tables.size() - kMostNamed, " older ones");
  return base::Error(absl::StatusCode::kFailedPrecondition,
                     absl::StrCat("compensation tables of machine ", machine.text(), " were handed out (", text,
                                  "): a control that uses one corrects errors already that the program by calibration ",
                                  calibration.id.number(),
                                  " would correct again. Take it out of the control or switch it off there, "
                                  "and state --tables-off (tables_are_off), or leave the program as it is"),
                     {"TABLE_HANDED_OUT", {}});
}

std::vector<nc::Remark> NotesOnInseparableErrors(const records::CalibrationRecord& calibration) {
  std::vector<nc::Remark> notes;
  const auto report = reports::ReadCalibrationReport(calibration.content.report_json);
  const std::string name = absl::StrCat("calibration ", calibration.id.number());
  if (!report.ok()) {
    if (!calibration.content.report_json.empty())
      notes.push_back({"apart-not-known", absl::StrCat(name, ": what it cannot tell apart is not known (",
                                                       report.status().message(), ")")});
    return notes;
  }
  constexpr char kElsewhere[] = ": the correction holds at poses like the measured ones, elsewhere it is not known";
  for (const std::string& direction : reports::FittedOf(*report).not_separable)
    notes.push_back({"not-told-apart", absl::StrCat(name, " cannot tell apart ", direction, kElsewhere)});
  const auto* const loop = std::get_if<reports::Loop>(&*report);
  if (loop == nullptr) return notes;
  for (const reports::Effect& effect : loop->effects) {
    std::string others;
    for (const reports::NamedTerm& other : effect.equivalent)
      absl::StrAppend(&others, others.empty() ? "" : ", ", other.name);
    if (others.empty()) continue;
    notes.push_back(
        {"not-told-apart", absl::StrCat(name, " cannot tell ", effect.is.name, " from ", others, kElsewhere)});
  }
  return notes;
}

std::optional<nc::Remark> NoteOnUnmeasured(const records::CalibrationRecord& calibration,
                                           const std::vector<reports::AxisRange>& positions) {
  const auto report = reports::ReadCalibrationReport(calibration.content.report_json);
  if (!report.ok()) return std::nullopt;
  // What is measured beside a position holds there too: errors do not change within so little.
  constexpr double kShareOfSpan = 0.1, kLeastMm = 1.0, kLeastDeg = 0.5;
  std::string beyond;
  for (const reports::AxisRange& measured : reports::FittedOf(*report).measured) {
    const auto gone = std::find_if(positions.begin(), positions.end(),
                                   [&](const reports::AxisRange& one) { return one.axis == measured.axis; });
    if (gone == positions.end()) continue;
    const bool is_linear = measured.unit == "mm";
    const double span = measured.to - measured.from;
    const double margin = std::max(kShareOfSpan * span, is_linear ? kLeastMm : kLeastDeg);
    // The same place on another turn is measured too; a whole turn is all that there is.
    constexpr double kTurnDeg = 360.0;
    if (!is_linear && span + margin >= kTurnDeg) continue;
    const double turns =
        is_linear ? 0.0 : std::round((0.5 * (gone->from + gone->to) - measured.from - 0.5 * span) / kTurnDeg);
    const double from = gone->from - turns * kTurnDeg, to = gone->to - turns * kTurnDeg;
    if (!(from < measured.from - margin || to > measured.to + margin)) continue;
    absl::StrAppend(&beyond, beyond.empty() ? "" : ", ",
                    absl::StrFormat("%s from %.6g to %.6g %s (measured: %.6g to %.6g)", gone->axis, gone->from,
                                    gone->to, gone->unit, measured.from, measured.to));
  }
  if (beyond.empty()) return std::nullopt;
  return nc::Remark{"not-measured-there",
                    absl::StrCat("the program goes where calibration ", calibration.id.number(),
                                 " was not measured: ", beyond, ". How right the correction is there is not known")};
}

Doubts DoubtsOf(const records::CalibrationRecord& calibration) {
  const auto report = reports::ReadCalibrationReport(calibration.content.report_json);
  if (!report.ok()) return {};
  const auto* const loop = std::get_if<reports::Loop>(&*report);
  return {reports::FittedOf(*report).warnings, loop == nullptr ? std::vector<reports::Cause>{} : loop->causes};
}

}  // namespace axiscal::inputs
