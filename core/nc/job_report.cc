#include "core/nc/job_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error_detail.h"
#include "core/base/units.h"
#include "core/compensate/compensator.h"
#include "core/nc/advice.h"

namespace axiscal::nc {
namespace {

constexpr size_t kShownBytes = 120;
constexpr size_t kMaxNotes = 100;

// Bytes of the well-formed UTF-8 character that begins there; 0: none does.
size_t CharacterSize(const unsigned char* at, size_t size) {
  const auto follows = [&](size_t i, unsigned low, unsigned high) { return i < size && at[i] >= low && at[i] <= high; };
  if (at[0] < 0x80) return 1;
  if (at[0] >= 0xC2 && at[0] <= 0xDF) return follows(1, 0x80, 0xBF) ? 2 : 0;
  if (at[0] >= 0xE0 && at[0] <= 0xEF) {
    const bool is_second = follows(1, at[0] == 0xE0 ? 0xA0 : 0x80, at[0] == 0xED ? 0x9F : 0xBF);
    return is_second && follows(2, 0x80, 0xBF) ? 3 : 0;
  }
  if (at[0] >= 0xF0 && at[0] <= 0xF4) {
    const bool is_second = follows(1, at[0] == 0xF0 ? 0x90 : 0x80, at[0] == 0xF4 ? 0x8F : 0xBF);
    return is_second && follows(2, 0x80, 0xBF) && follows(3, 0x80, 0xBF) ? 4 : 0;
  }
  return 0;
}

}  // namespace

std::string Shown(const BlockText& block) {
  const size_t size = std::min(block.text_size, kShownBytes);
  std::string text;
  for (size_t at = 0; at < size;) {
    const char c = block.text[at];
    const size_t count = CharacterSize(reinterpret_cast<const unsigned char*>(block.text) + at, size - at);
    const bool is_control = (c >= 0 && c < ' ') || c == 0x7F;
    if (count == 0 || is_control) {
      text += c == '\t' ? ' ' : '?';
    } else {
      text.append(block.text + at, count);
    }
    at += std::max<size_t>(count, 1);
  }
  return text;
}

JobReport::JobReport(const compensate::Compensator& compensator, const RewriteOptions& options)
    : compensator_(compensator), options_(options) {
  report_.calibration = options.calibration;
  report_.dialect = options.dialect;
  for (const machine::Axis& axis : compensator.machine().axes) {
    report_.axis_names.push_back(axis.name);
    report_.axis_is_rotary.push_back(axis.kind == machine::AxisKind::kRotary);
  }
  for (const machine::Axis& axis : compensator.machine().axes)
    has_travel_limits_ |= axis.min_position.has_value() || axis.max_position.has_value();
  report_.is_null_correction = compensator.is_null();
  report_.has_source_crc32c = options.source_crc32c.has_value();
  report_.source_crc32c = options.source_crc32c.value_or(0);
  for (const std::string& error : compensator.not_carried())
    report_.notes.push_back({"not-carried", "not carried: " + error});
  for (const int axis : compensator.linear_axes()) report_.axes.push_back({compensator.machine().axes[axis].name, {}});
  if (!options.orientation) return;
  report_.has_orientation = true;
  report_.max_rotary_correction_rad = options.max_rotary_correction_rad;
  for (int i = 0; i < compensator.machine().axis_count(); ++i) {
    if (compensator.machine().axes[i].kind != machine::AxisKind::kRotary) continue;
    rotary_axes_.push_back(i);
    report_.rotary_axes.push_back({compensator.machine().axes[i].name, {}});
  }
}

void JobReport::Note(const BlockText& block, const std::string& kind, const std::string& text) {
  if (report_.notes.size() < kMaxNotes) report_.notes.push_back(RemarkAt(block.line, kind, text));
}

void JobReport::AddFinding(const BlockText& block, const std::string& reason, std::vector<Finding>* findings) {
  if (findings->size() >= kMaxFindings) return;
  const std::string where = source_.empty() ? "" : absl::StrCat("in ", source_, ": ");
  findings->push_back({block.line, Shown(block), where + reason});
}

void JobReport::Passed(const BlockText& block, const std::string& reason, bool is_consequence) {
  ++report_.blocks_passed;
  if (!is_consequence) {
    AddFinding(block, reason, &report_.passed);
    for (const std::string& option : MissingOptions(reason, compensator_.machine())) Ask(option);
  }
  if (!report_.is_null_correction)
    report_.not_corrected.Add(block.line, source_.empty() ? reason : absl::StrCat("in ", source_, ": ", reason));
}

void JobReport::WentBack(const BlockText& block, const std::string& added, double way_mm) {
  ++report_.blocks_going_back;
  if (report_.ways_back.size() < kMaxFindings) report_.ways_back.push_back({block.line, added, way_mm});
}

void JobReport::Refused(const BlockText& block, const std::string& reason, bool is_consequence) {
  ++report_.blocks_refused;
  if (is_consequence && !report_.refused.empty()) return;
  AddFinding(block, reason, &report_.refused);
  for (const std::string& option : MissingOptions(reason, compensator_.machine())) Ask(option);
}

void JobReport::Ask(const std::string& option) {
  std::vector<std::string>& missing = report_.missing;
  if (missing.size() < kMaxAdvice && std::find(missing.begin(), missing.end(), option) == missing.end())
    missing.push_back(option);
}

void JobReport::AskStart(const std::vector<int>& axes) { start_axes_.insert(axes.begin(), axes.end()); }

void JobReport::AskKept(const std::vector<int>& axes) { kept_axes_.insert(axes.begin(), axes.end()); }

void JobReport::FindPlace(int64_t tool, const std::string& work_offset) {
  place_tool_ = tool;
  place_offset_ = work_offset;
  std::vector<Shift>& shifts = report_.shifts;
  for (place_ = 0; place_ < shifts.size(); ++place_) {
    if (shifts[place_].tool == tool && shifts[place_].work_offset == work_offset) return;
  }
  if (shifts.size() < kMaxShifts) {
    shifts.emplace_back();
    shifts.back().tool = tool;
    shifts.back().work_offset = work_offset;
  } else {
    place_ = kNowhere;
  }
}

void JobReport::Finish() {
  const machine::Machine& machine = compensator_.machine();
  std::string start, kept;
  for (const int i : InWordOrder(machine)) {
    if (start_axes_.contains(i)) absl::StrAppend(&start, start.empty() ? "" : " ", machine.axes[i].name, "=...");
    if (kept_axes_.contains(i)) absl::StrAppend(&kept, kept.empty() ? "" : " ", machine.axes[i].name);
  }
  if (!start.empty()) Ask("--start \"" + start + "\"");
  if (!kept.empty())
    Ask("--tool-change-keeps \"" + kept + "\" (only if the tool changer leaves them where they stand)");
  std::erase_if(report_.shifts, [](const Shift& shift) { return shift.count == 0; });
  MergeHarmless(&report_.missing);
}

void JobReport::Account(const BlockText& block, const Piece& piece, const Commanded& commanded, double departure_mm) {
  report_.not_corrected.End();
  const machine::Machine& machine = compensator_.machine();
  const std::vector<int>& axes = compensator_.linear_axes();
  Eigen::Vector3d after = Eigen::Vector3d::Zero();
  double shift_mm2 = 0;
  corrections_mm_.resize(axes.size());
  ends_mm_.resize(axes.size());
  for (size_t k = 0; k < axes.size(); ++k) {
    const int axis = axes[k];
    const double correction_mm = static_cast<double>(piece.targets[axis] - piece.nominal[axis]) / kTicksPerUnit;
    report_.axes[k].correction.Add(correction_mm);
    corrections_mm_[k] = correction_mm;
    ends_mm_[k] = static_cast<double>(piece.nominal[axis]) / kTicksPerUnit;
    shift_mm2 += correction_mm * correction_mm;
    if (std::abs(correction_mm) > options_.max_correction_mm) {
      Refused(block,
              absl::StrFormat("correction of %s = %.1f um, the limit is %.1f um", machine.axes[axis].name,
                              correction_mm * base::kUmPerMm, options_.max_correction_mm * base::kUmPerMm),
              has_exceeded_limit_);
      has_exceeded_limit_ = true;
    }
    const double rounding_mm = static_cast<double>(commanded.ticks[axis] - piece.targets[axis]) / kTicksPerUnit;
    after += piece.correction.tip_per_mm[k] * rounding_mm;
  }
  if (place_ != kNowhere) AddShift(block, piece, shift_mm2);
  AddPositions(piece);
  for (int i = 0; has_travel_limits_ && i < machine.axis_count(); ++i) {
    const machine::Axis& axis = machine.axes[i];
    if (axis.min_position || axis.max_position)
      CheckTravel(block, i,
                  piece.is_tool_point && axis.kind == machine::AxisKind::kLinear
                      ? piece.correction.corrected[i]
                      : static_cast<double>(commanded.ticks[i]) / kTicksPerUnit);
  }
  const double after_mm = after.norm() + piece.correction.after_mm, before_mm = piece.correction.before_mm;
  if (options_.orientation) AccountRotary(piece, commanded);
  report_.error_before.Add(before_mm);
  report_.error_after.Add(after_mm);
  report_.path.Add(block.line, corrections_mm_, ends_mm_, before_mm, after_mm);
  report_.path_before_max_mm =
      std::max({report_.path_before_max_mm, last_before_mm_ + departure_mm, before_mm + departure_mm});
  report_.path_after_max_mm =
      std::max({report_.path_after_max_mm, last_after_mm_ + departure_mm, after_mm + departure_mm});
  last_before_mm_ = before_mm;
  last_after_mm_ = after_mm;
  report_.max_departure_mm = std::max(report_.max_departure_mm, departure_mm);
  report_.max_tilt_left_rad = std::max(report_.max_tilt_left_rad, piece.correction.tilt_left_rad);
}

void JobReport::AddPositions(const Piece& piece) {
  const machine::Machine& machine = compensator_.machine();
  const auto count = static_cast<size_t>(machine.axis_count());
  report_.least.resize(count, std::numeric_limits<double>::infinity());
  report_.greatest.resize(count, -std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < count; ++i) {
    // Words of the tool point are no positions of the axes that carry it.
    const bool is_of_tool = piece.is_tool_point && machine.axes[i].kind == machine::AxisKind::kLinear;
    const double position =
        is_of_tool ? piece.correction.corrected[i] : static_cast<double>(piece.nominal[i]) / kTicksPerUnit;
    report_.least[i] = std::min(report_.least[i], position);
    report_.greatest[i] = std::max(report_.greatest[i], position);
  }
}

void JobReport::AddShift(const BlockText& block, const Piece& piece, double shift_mm2) {
  Shift& shift = report_.shifts[place_];
  shift.sum_squares_mm2 += shift_mm2;
  if (++shift.count > 1 && shift_mm2 <= shift.max_mm * shift.max_mm) return;
  shift.max_mm = std::sqrt(shift_mm2);
  shift.line = block.line;
  shift.at.resize(report_.axis_names.size());
  for (size_t i = 0; i < shift.at.size(); ++i) shift.at[i] = static_cast<double>(piece.nominal[i]) / kTicksPerUnit;
}

void JobReport::AccountRotary(const Piece& piece, const Commanded& commanded) {
  for (size_t k = 0; k < rotary_axes_.size(); ++k) {
    const int axis = rotary_axes_[k];
    const double change = static_cast<double>(commanded.ticks[axis] - piece.nominal[axis]) / kTicksPerUnit;
    // An axis that counts from 0 to 360 deg is whole turns away.
    report_.rotary_axes[k].correction.Add(std::remainder(change, 360.0) * base::kRadPerDeg);
  }
  report_.tilt_before.Add(piece.correction.tilt_before_rad);
  report_.tilt_after.Add(piece.correction.tilt_left_rad);
}

void JobReport::Drilled(const BlockText& block, double left_mm, double rounding_mm, const std::string& help) {
  report_.not_corrected.End();
  ++report_.holes;
  report_.max_hole_left_mm = std::max(report_.max_hole_left_mm, left_mm);
  if (left_mm > rounding_mm) {
    ++report_.holes_left;
    AddFinding(block, absl::StrFormat("%.1f um are left at the hole: %s", left_mm * base::kUmPerMm, help),
               &report_.left);
  }
  if (left_mm <= options_.cycle_tolerance_mm) return;
  Refused(block,
          absl::StrFormat("%.1f um are left at the hole, the limit is %.1f um: %s; state "
                          "--cycle-tolerance-um if that is good enough, or program the hole in moves",
                          left_mm * base::kUmPerMm, options_.cycle_tolerance_mm * base::kUmPerMm, help),
          false);
}

void JobReport::Contoured(const BlockText& block, double left_mm, double rounding_mm, bool is_limited,
                          const std::string& help) {
  ++report_.contour_moves;
  report_.max_contour_left_mm = std::max(report_.max_contour_left_mm, left_mm);
  if (left_mm > rounding_mm) {
    ++report_.contour_moves_left;
    AddFinding(block, absl::StrFormat("%.1f um are left: %s", left_mm * base::kUmPerMm, help), &report_.contour_left);
  }
  if (!is_limited || left_mm <= options_.cutter_tolerance_mm) return;
  Refused(
      block,
      absl::StrFormat("%.1f um are left along the contour, the limit is %.1f um: %s; state --cutter-tolerance-um if "
                      "that is good enough, or program the path of the cutter's centre",
                      left_mm * base::kUmPerMm, options_.cutter_tolerance_mm * base::kUmPerMm, help),
      false);
}

void JobReport::Tilted(const BlockText& block, const compensate::Turned& turned) {
  ++report_.blocks_tilted;
  AddFinding(block,
             absl::StrFormat("the tool's direction is %.3g urad off: %s", turned.tilt_left_rad * base::kUradPerRad,
                             compensate::ToString(turned, options_.max_rotary_correction_rad)),
             &report_.tilted);
}

void JobReport::CheckTravel(const BlockText& block, int index, double commanded) {
  const machine::Axis& axis = compensator_.machine().axes[index];
  const bool is_rotary = axis.kind == machine::AxisKind::kRotary;
  const double unit = is_rotary ? base::kRadPerDeg : 1.0;
  const double slack = is_rotary ? 1e-9 : 0.0;  // degrees are converted
  const bool is_below = axis.min_position && commanded * unit < *axis.min_position - slack;
  const bool is_above = axis.max_position && commanded * unit > *axis.max_position + slack;
  if (!is_below && !is_above) return;
  Refused(block,
          absl::StrFormat("%s = %.4f %s with its correction, beyond the travel limit of %.4f %s", axis.name, commanded,
                          is_rotary ? "deg" : "mm", (is_below ? *axis.min_position : *axis.max_position) / unit,
                          is_rotary ? "deg" : "mm"),
          false);
}

absl::Status JobReport::Refusal() const {
  // Which setting a person should look at first: without a unit no correction is known.
  const bool asks_unit =
      std::find(report_.missing.begin(), report_.missing.end(), kUnitAdvice) != report_.missing.end();
  const std::string cause = asks_unit             ? "UNIT_NOT_STATED"
                            : has_exceeded_limit_ ? "CORRECTION_TOO_LARGE"
                                                  : "PROGRAM_REFUSED";
  const auto refuse = [&cause](const std::string& text) {
    return base::Error(absl::StatusCode::kFailedPrecondition, text, {cause, {}});
  };
  const std::string count =
      absl::StrCat(report_.blocks_refused, report_.blocks_refused == 1 ? " block" : " blocks", " refused");
  std::string add;
  for (const std::string& option : report_.missing) absl::StrAppend(&add, add.empty() ? "; add " : " ", option);
  if (report_.refused.empty()) return refuse(count + add);
  const Finding& first = report_.refused.front();
  return refuse(absl::StrCat(count, "; line ", first.line, ": '", first.block, "': ", first.reason, add));
}

}  // namespace axiscal::nc
