// Cutter compensation: where the control's offset of the contour can be followed. Its words are those of the part's
// contour; which radius the control takes is stated (RewriteOptions::tool_radii).
#include <Eigen/LU>
#include <cmath>
#include <string>

#include "core/base/units.h"
#include "core/nc/request.h"

namespace axiscal::nc {
namespace {

constexpr double kSquare = 1e-9;  // directions of machine.json are unit to that

// Whether a contour of words of X and Y is one of the tool point: both stand at right angles to each other and to Z.
bool HasSquareAxes(const machine::Machine& machine, const std::array<int, 3>& xyz) {
  Eigen::Matrix3d directions;
  for (int k = 0; k < 3; ++k) {
    const int axis = xyz[static_cast<size_t>(k)];
    if (axis < 0 || machine.axes[axis].kind != machine::AxisKind::kLinear) return false;
    directions.col(k) = machine.axes[axis].direction;
  }
  return (directions.transpose() * directions - Eigen::Matrix3d::Identity()).isZero(kSquare) &&
         std::abs(std::abs(machine.tool_direction.dot(directions.col(2))) - 1.0) <= kSquare;
}

}  // namespace

std::string Interpreter::WhyNoCutter(const Request& request, Ticks* radius) const {
  if (!HasSquareAxes(*machine_, frame_of_words_.xyz()))
    return "X, Y and Z of the machine do not stand at right angles, or the tool not along Z: the control's offset is "
           "no "
           "offset of the tool point";
  if (HasRotaryAxis() && !frame_of_words_.problem().empty()) return frame_of_words_.problem();
  if (modal_.is_cutter_ending) return "it begins again in front of the move in X or Y that ends it";
  if (options_->orientation) return "with --orientation it is not followed: a contour would turn rotary axes inside";
  if (block_may_be_skipped_) return "in a block that may be skipped: state --block-delete";
  if ((modal_.tool_point & ~kPlacedFrames) != 0) return "under tool centre point control it is not followed";
  if (word_frame_ != nullptr &&
      !(word_frame_->linear.transpose() * word_frame_->linear - Eigen::Matrix3d::Identity()).isZero(kSquare))
    return "in scaled coordinates: whether the radius is scaled is not known";
  if (word_frame_ != nullptr && word_frame_->linear.determinant() < 0)
    return "in mirrored coordinates controls differ on the side";
  if (modal_.plane_normal != 2 || (modal_.uncertain & kPlaneGroup) != 0)
    return "in another plane than XY, or where that is not known";
  if ((modal_.uncertain & kOffsetGroup) != 0) return "the work offset is not known";
  if (request.has_corner || rounds_corners_ || is_behind_corner_)
    return "beside rounded or chamfered corners it is not followed";
  const bool is_by_tool = roles_['D' - 'A'] != Role::kToolRadius;
  int number = is_by_tool ? coordinates_.active_length() : last_radius_number_;
  if (is_by_tool && (modal_.uncertain & kLengthGroup) != 0) number = -1;
  if (dialect_->takes_loaded_tool && request.radius_number == nullptr)
    number = is_loaded_tool_known_ && loaded_tool_ <= 9999 ? static_cast<int>(loaded_tool_) : -1;
  *radius = 0;
  if (number == 0) return "";
  if (number < 0) {
    return dialect_->tool_call_sets_length ? "no TOOL CALL in front of it says which tool's radius the control takes"
           : dialect_->takes_loaded_tool
               ? "no D word, and no T word and M6 in front of it say which tool's radius the control takes"
               : "no D word says which radius the control takes";
  }
  const auto is_stated = [this](int known) {
    return std::any_of(options_->tool_radii.begin(), options_->tool_radii.end(),
                       [known](const ToolRadius& one) { return one.number == known; });
  };
  // D1 of the tool in the spindle.
  const bool is_edge = is_by_tool && !dialect_->tool_call_sets_length && number < kEdgesOfTool;
  const bool is_by_its_tool = std::any_of(
      options_->tool_radii.begin(), options_->tool_radii.end(),
      [number](const ToolRadius& one) { return one.number >= kEdgesOfTool && one.number % kEdgesOfTool == number; });
  if (const int of_spindle = is_edge ? NumberOfSpindle(number) : 0;
      of_spindle > 0 && (is_by_its_tool || is_stated(of_spindle)))
    number = of_spindle;
  const std::string name = number >= kEdgesOfTool            ? ToolNumberText(number)
                           : dialect_->tool_call_sets_length ? absl::StrCat("T", number)
                                                             : absl::StrCat("D", number);
  for (const ToolRadius& stated : options_->tool_radii) {
    if (stated.number != number) continue;
    if (!radius_difference_) return "DR of TOOL CALL is no plain number";
    *radius = std::llround(stated.radius_mm * kTicksPerUnit) + *radius_difference_;
    return *radius < 0 ? "its radius is below zero: controls differ on the side" : "";
  }
  return absl::StrCat("the cutter's radius ", name, " is not stated: add --tool-radius ", name,
                      "=MM, or a --tool-table that holds it");
}

void Interpreter::BeginCutter(Request* request) {
  Ticks radius = 0;
  std::string problem = WhyNoCutter(*request, &radius);
  const int8_t side =
      request->cutter_side == nullptr ? modal_.cutter_side : static_cast<int8_t>(request->cutter_side->detail);
  const std::string name = request->cutter_side == nullptr ? "D" : request->cutter_side->text;
  if (problem.empty() && request->cutter_side_before != 0 &&
      (side != request->cutter_side_before || radius != modal_.cutter_radius))
    problem = "its side or its radius changes while it is active: end it in front (G40, R0)";
  blockers_seen_ |= kCutterCompensation;
  if (problem.empty() && request->problem.empty() && (modal_.blockers & kCutterCompensation) == 0) {
    modal_.cutter_side = side;
    modal_.cutter_radius = radius;
    return;
  }
  modal_.cutter_side = 0, modal_.cutter_radius = 0;
  modal_.blockers |= kCutterCompensation;
  request->Refuse(absl::StrCat(name, problem.empty() ? "" : ": ", problem));
}

void Interpreter::KeepCutter(const AxisTicks& offsets_before, const Modal& before, Request* request) {
  if (modal_.cutter_side == 0 && (modal_.blockers & kCutterCompensation) == 0) return;  // it ended here
  std::string what;
  if (offsets_before != coordinates_.offsets() || (modal_.uncertain & kOffsetGroup) != 0) what = "coordinates change";
  if (request->length_before != coordinates_.active_length()) what = "the tool length changes";
  if (request->tool_point_before != modal_.tool_point || request->word_frame_before != word_frame_)
    what = "the frame of the words changes";
  if (before.plane_normal != modal_.plane_normal) what = "the plane changes";
  const bool is_cycle =
      modal_.motion == Meaning::kDrillCycle || modal_.calls_at_moves || request->cycle_call != nullptr;
  if (is_cycle || modal_.motion == Meaning::kOtherMotion) what = "another move is stated";
  if (request->away != nullptr) what = "the tool is changed";
  if (request->preset != nullptr || request->shift != nullptr || request->data_input != nullptr)
    what = "coordinates change";
  if (!request->problem.empty() || !request->is_whole) what = "a block is not followed";
  if (what.empty()) return;
  LoseCutter();
  request->Refuse(absl::StrCat(what, " while cutter compensation is active: end that in front of it (G40, R0)"));
}

// TNC 640, User's Manual for Klartext Programming, "Approaching and departing a contour": the tool goes to a point of
// the control's own first, and to the height of a word of Z there.
std::string Interpreter::WhyNoApproach(const Request& request) const {
  const bool comes = request.IsOfContour(kApproach);
  if (!comes && !request.IsOfContour(kDeparture)) return "";
  if (request.is_rapid_block) return "APPR or DEP as a rapid move";
  if (comes && request.cutter_side == nullptr) return "APPR without RL or RR";
  if (comes && request.cutter_side_before != 0) return "APPR while cutter compensation is active: end it in front (R0)";
  if (!comes && request.cutter_side_before == 0)
    return "DEP without cutter compensation that is followed in front of it";
  return "";
}

void Interpreter::Depart(const Request& request, Step* step) {
  if (request.has_axis || request.foreign_axis != 0)
    return Unsupported("DEP LT, LN or CT with words of axes: where it leads is not known", false, step);
  step->moves_away = step->departs = true;
  pole_.is_known = false;
  const std::array<int, 3>& xyz = frame_of_words_.xyz();
  for (int i = 0; i < axis_count_; ++i) {
    if (i == xyz[0] || i == xyz[1]) {
      ForgetPosition(i, false);
    } else {
      step->kept_away |= static_cast<uint16_t>(1u << i);
    }
  }
}

std::string Interpreter::WhyNoContour(const Request& request, const Step& step) const {
  if (request.has_corner || rounds_corners_ || is_behind_corner_)
    return "a rounded or chamfered corner while cutter compensation is active";
  const std::array<int, 3>& xyz = frame_of_words_.xyz();
  for (int i = 0; i < axis_count_; ++i) {
    if (i == xyz[0] || i == xyz[1] || i == xyz[2] || step.word_of_axis[i] < 0) continue;
    if (step.start.is_known(i) && step.start.ticks[i] == step.end.ticks[i]) continue;
    return absl::StrCat("a move of ", machine_->axes[i].name, " while cutter compensation is active, or ends");
  }
  if (HasRotaryAxis() && !is_in_table() && !frame_of_words_.IsAlongZ(step.end.ticks))
    return "the tool does not stand along Z: the control offsets the contour in the plane XY";
  return "";
}

}  // namespace axiscal::nc
