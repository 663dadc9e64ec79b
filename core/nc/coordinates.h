// From programmed coordinates to axis positions: work offset + preset (G92) + local shift (G52) + tool length, each in
// ticks per axis. Whatever is selected without stated values makes the coordinates unknown.
#ifndef AXISCAL_CORE_NC_COORDINATES_H_
#define AXISCAL_CORE_NC_COORDINATES_H_

#include <algorithm>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/nc/modal.h"
#include "core/nc/options.h"

namespace axiscal::nc {

// `values` in ticks, by axis; `axes` lists those that are named. INVALID_ARGUMENT that names `field`.
absl::StatusOr<AxisTicks> ToAxisTicks(const machine::Machine& machine, const std::vector<AxisValue>& values,
                                      const std::string& field, std::vector<int>* axes);

class Coordinates {
 public:
  static absl::StatusOr<Coordinates> Create(const machine::Machine& machine, const RewriteOptions& options,
                                            const Dialect& dialect);

  // Axis position = programmed value + Offset(axis).
  Ticks Offset(int axis) const { return total_[axis]; }
  const AxisTicks& offsets() const { return total_; }
  // The number of the tool length in force, -1: none.
  int active_length() const { return active_length_; }
  // Which of the stated work offsets is in force, by an option or by G10 of the program; "": none.
  const std::string& active_offset() const {
    return selected_ < 0 ? no_offset_ : stated_[static_cast<size_t>(selected_)].code;
  }

  // The state at the begin of a program.
  void Reset();
  // False: not stated. "G54", "G54.1 P5", "G505"; "" is none.
  bool Select(const std::string& code);
  bool IsLengthStated(int number) const {
    return std::any_of(lengths_.begin(), lengths_.end(), [number](const Length& one) { return one.number == number; });
  }
  // Of some tool (NumberOfEdge): then the number alone is of no other.
  bool IsEdgeStatedByTool(int edge) const {
    return std::any_of(lengths_.begin(), lengths_.end(), [edge](const Length& one) {
      return one.number >= kEdgesOfTool && one.number % kEdgesOfTool == edge;
    });
  }
  // Index into options.tool_lengths of the number, -1: not stated. Number 0 is no length.
  bool SelectLength(int number, int sign);
  void DropLength();
  // A difference of the length in force (DL): Z stands so much higher, the tool is as long as it is.
  void SetLengthDifference(Ticks difference);
  // While words stand in the workpiece's frame they say where the tool point is: no length is added to Z.
  void SetToolPoint(bool is_tool_point);
  Ticks length() const { return length_; }
  // Offset(axis) without the tool length.
  Ticks WithoutLength(int axis) const {
    return total_[axis] - (axis == length_axis_ && !is_tool_point_ ? length_ + length_difference_ : 0);
  }
  bool has_length_difference() const { return length_difference_ != 0; }
  // G92: the axis' present position gets the programmed value.
  void Preset(int axis, Ticks position, Ticks value);
  // G92.1, of the axes in `axes`; a local shift (G52) ends with it.
  void ClearPreset(uint16_t axes);
  void SuspendPreset();
  void RestorePreset();
  // A local shift is in force.
  bool has_shift() const;
  // Preset coordinates are in force or suspended.
  bool has_preset() const;
  // A programmable frame that only shifts: TRANS, CYCL DEF 7.
  void SetFrame(int axis, Ticks value) {
    frame_[axis] = value;
    Sum();
  }
  Ticks frame(int axis) const { return frame_[axis]; }
  bool has_frame() const;
  // G52. False: a preset is in force, controllers differ.
  bool Shift(int axis, Ticks value);
  // G10 L2: the values of the axes in `axes` of a work offset, in force at once where it is selected. False, and
  // nothing changed: it is not stated, and `axes` are not all.
  bool Restate(const std::string& code, uint16_t axes, const AxisTicks& ticks);
  bool IsStated(const std::string& code) const;
  // G10: what was stated holds no longer.
  void ForgetStated();

 private:
  struct Stated {
    std::string code;
    AxisTicks ticks;
  };
  struct Length {
    int number;
    Ticks ticks;
  };
  void Sum();

  int axis_count_ = 0;
  int length_axis_ = -1;  // Z
  std::vector<Stated> stated_;
  std::vector<Length> lengths_;
  std::string first_offset_;
  std::string no_offset_;  // stays empty
  int selected_ = -1;
  bool has_selected_ = false;  // the program did, else the first one is in force if it is stated
  int active_length_ = -1;
  Ticks length_ = 0, length_difference_ = 0;
  bool is_tool_point_ = false;
  AxisTicks preset_{}, suspended_{}, shift_{}, frame_{}, total_{};
};

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_COORDINATES_H_
