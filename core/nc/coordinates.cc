#include "core/nc/coordinates.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"

namespace axiscal::nc {
namespace {

constexpr double kMaxUnits = 1e7;  // 10 km: ticks stay far from overflow

}  // namespace

absl::StatusOr<AxisTicks> ToAxisTicks(const machine::Machine& machine, const std::vector<AxisValue>& values,
                                      const std::string& field, std::vector<int>* axes) {
  AxisTicks ticks{};
  for (const AxisValue& value : values) {
    const int axis = machine::FindAxis(machine, value.axis);
    if (axis < 0) {
      return absl::InvalidArgumentError(
          absl::StrCat(field, ": machine '", machine.id, "' has no axis '", value.axis, "'"));
    }
    const bool is_linear = machine.axes[axis].kind == machine::AxisKind::kLinear;
    const double units = is_linear ? value.value : value.value * base::kDegPerRad;
    if (!(std::abs(units) <= kMaxUnits)) {
      return absl::InvalidArgumentError(
          absl::StrCat(field, ": ", value.axis, " = ", units, ", must be finite, at most 1e7"));
    }
    ticks[axis] = std::llround(units * kTicksPerUnit);
    axes->push_back(axis);
  }
  return ticks;
}

absl::StatusOr<Coordinates> Coordinates::Create(const machine::Machine& machine, const RewriteOptions& options,
                                                const Dialect& dialect) {
  Coordinates coordinates;
  coordinates.axis_count_ = machine.axis_count();
  coordinates.length_axis_ = machine::FindAxis(machine, "Z");
  coordinates.first_offset_ = dialect.first_offset;
  std::vector<int> axes;
  for (const WorkOffset& offset : options.work_offsets) {
    ASSIGN_OR_RETURN(const AxisTicks ticks, ToAxisTicks(machine, offset.offsets, "work_offsets " + offset.code, &axes));
    coordinates.stated_.push_back({offset.code, ticks});
  }
  for (const ToolLength& length : options.tool_lengths) {
    if (coordinates.length_axis_ < 0) {
      return absl::InvalidArgumentError(absl::StrCat("tool_lengths: machine '", machine.id, "' has no axis Z"));
    }
    coordinates.lengths_.push_back({length.number, std::llround(length.length_mm * kTicksPerUnit)});
  }
  coordinates.Reset();
  return coordinates;
}

void Coordinates::Reset() {
  selected_ = active_length_ = -1;
  length_ = length_difference_ = 0;
  is_tool_point_ = has_selected_ = false;
  preset_ = suspended_ = shift_ = frame_ = {};
  for (size_t i = 0; i < stated_.size(); ++i) {
    if (stated_[i].code == first_offset_) selected_ = static_cast<int>(i);
  }
  Sum();
}

bool Coordinates::Select(const std::string& code) {
  has_selected_ = true;
  selected_ = -1;
  for (size_t i = 0; i < stated_.size(); ++i) {
    if (stated_[i].code == code) selected_ = static_cast<int>(i);
  }
  Sum();
  return selected_ >= 0 || code.empty();
}

bool Coordinates::SelectLength(int number, int sign) {
  length_ = length_difference_ = 0;
  active_length_ = -1;
  bool is_stated = number == 0;
  for (const Length& length : lengths_) {
    if (length.number != number || number == 0) continue;
    length_ = sign * length.ticks;
    active_length_ = number;
    is_stated = true;
  }
  Sum();
  return is_stated;
}

void Coordinates::DropLength() { SelectLength(0, 1); }

void Coordinates::SetLengthDifference(Ticks difference) {
  length_difference_ = difference;
  Sum();
}

void Coordinates::SetToolPoint(bool is_tool_point) {
  if (is_tool_point == is_tool_point_) return;
  is_tool_point_ = is_tool_point;
  Sum();
}

void Coordinates::Preset(int axis, Ticks position, Ticks value) {
  preset_[axis] += position - value - total_[axis];
  suspended_ = preset_;
  Sum();
}

void Coordinates::ClearPreset(uint16_t axes) {
  for (int i = 0; i < axis_count_; ++i) {
    if (axes >> i & 1) preset_[i] = suspended_[i] = shift_[i] = 0;
  }
  Sum();
}

bool Coordinates::has_shift() const {
  return std::any_of(shift_.begin(), shift_.end(), [](Ticks ticks) { return ticks != 0; });
}

bool Coordinates::has_frame() const {
  return std::any_of(frame_.begin(), frame_.end(), [](Ticks ticks) { return ticks != 0; });
}

bool Coordinates::has_preset() const {
  return std::any_of(suspended_.begin(), suspended_.end(), [](Ticks ticks) { return ticks != 0; });
}

void Coordinates::SuspendPreset() {
  preset_ = {};
  Sum();
}

void Coordinates::RestorePreset() {
  preset_ = suspended_;
  Sum();
}

bool Coordinates::Shift(int axis, Ticks value) {
  shift_[axis] = value;
  Sum();
  return !has_preset();
}

bool Coordinates::IsStated(const std::string& code) const {
  return std::any_of(stated_.begin(), stated_.end(), [&](const Stated& stated) { return stated.code == code; });
}

bool Coordinates::Restate(const std::string& code, uint16_t axes, const AxisTicks& ticks) {
  const auto all = static_cast<uint16_t>((1u << axis_count_) - 1);
  if (!IsStated(code)) {
    if (axes != all) return false;
    stated_.push_back({code, {}});
    if (!has_selected_ && code == first_offset_) selected_ = static_cast<int>(stated_.size()) - 1;
  }
  for (Stated& stated : stated_) {
    for (int i = 0; stated.code == code && i < axis_count_; ++i) {
      if (axes >> i & 1) stated.ticks[i] = ticks[i];
    }
  }
  Sum();
  return true;
}

void Coordinates::ForgetStated() {
  selected_ = -1;
  stated_.clear();
  lengths_.clear();
}

void Coordinates::Sum() {
  for (int i = 0; i < axis_count_; ++i) {
    const Ticks of_offset = selected_ < 0 ? 0 : stated_[static_cast<size_t>(selected_)].ticks[i];
    total_[i] = preset_[i] + shift_[i] + frame_[i] + of_offset;
  }
  if (length_axis_ >= 0 && !is_tool_point_) total_[length_axis_] += length_ + length_difference_;
}

}  // namespace axiscal::nc
