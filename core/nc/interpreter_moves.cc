// What a block does with its axis words.
#include <cmath>

#include "core/base/units.h"
#include "core/nc/request.h"

namespace axiscal::nc {
namespace {

constexpr Ticks kMaxTicks = 10'000'000 * kTicksPerMm;  // 10 km: ticks stay far from overflow

bool InRange(Ticks ticks) { return ticks <= kMaxTicks && ticks >= -kMaxTicks; }

const char* NameOf(ModalGroup group) {
  switch (group) {
    case kMotionGroup:
      return "the motion code (G00 to G03)";
    case kDistanceGroup:
      return "G90 or G91";
    case kUnitGroup:
      return "the unit (G20, G21)";
    case kPlaneGroup:
      return "the plane (G17 to G19)";
    case kFeedGroup:
      return "the feed mode";
    case kOffsetGroup:
      return "the work offset";
    case kLengthGroup:
      return "the tool length";
    case kCentreGroup:
      return "how centres count (G90.1, G91.1)";
  }
  return "the modal state";
}

}  // namespace

void Interpreter::Act(const Block& block, const Request& request, Step* step) {
  if (request.is_pole) return SetPole(block, request, step);
  if (request.departs) return Depart(request, step);
  if (request.machine_move != nullptr) return DoMachineMove(request, step);
  if (request.data_input != nullptr || request.frame != nullptr) return;  // its words are values
  if (request.turn_to_plane != nullptr) return;
  const bool begins_cycle = request.motion != nullptr && request.motion->meaning == Meaning::kDrillCycle;
  if (begins_cycle && (request.preset != nullptr || request.shift != nullptr)) {
    modal_.blockers |= kShift;
    return Unsupported("a drilling cycle that begins beside G52, G92 or G50: its heights are not stated", false, step);
  }
  if (request.preset != nullptr) return DoPreset(block, request, step);
  if (request.shift != nullptr) return DoShift(block, request, step);
  if (request.is_dwell) return DoDwell(request, step);
  if (request.owner != nullptr && (request.has_axis || request.foreign_axis != 0)) {
    if (request.motion != nullptr)
      Unsupported(absl::StrCat(request.owner->text, " and a motion code in one block"), false, step);
    return;
  }
  if (request.cycle_call != nullptr && request.cycle_call->detail == kAtPosition)
    return CallCycleAt(block, request, step);
  if (request.cycle_call != nullptr && !request.has_axis && request.foreign_axis == 0 && !request.HasVector()) {
    bool is_consequence = false;
    if (std::string reason = WhyNoMove(request, &is_consequence); !reason.empty())
      return Unsupported(std::move(reason), is_consequence, step);
    step->start.CopyFrom(positions_, axis_count_);
    step->end.CopyFrom(positions_, axis_count_);
    return CallCycle(request, step);
  }
  const bool is_cycle = modal_.motion == Meaning::kDrillCycle;
  const bool has_cycle_word = request.motion != nullptr || request.parameter != 0 || request.radius != nullptr;
  if (is_cycle && has_cycle_word && !request.has_axis && request.foreign_axis == 0)
    return LoseCycle("without words of X, Y or Z controls differ on whether it drills", step);
  if (!request.has_axis && request.foreign_axis == 0 && !request.HasVector()) {
    const bool moves_by_centre = modal_.motion == Meaning::kArc && request.has_centre;
    if (moves_by_centre) {
      bool is_consequence = false;
      std::string reason = WhyNoMove(request, &is_consequence);
      return reason.empty() ? Move(block, request, step) : Unsupported(std::move(reason), is_consequence, step);
    }
    step->is_corner = is_behind_corner_ = request.has_corner;
    if (request.has_code) return;
    char stray = request.parameter != 0 ? request.parameter : request.radius != nullptr ? 'R' : char{0};
    if (stray == 0 && request.has_centre) stray = 'I';
    if (stray != 0) {
      NoteCall();  // L100 of Sinumerik calls a subprogram
      step->leaves_text = true;
      Unsupported(absl::StrCat("word ", std::string(1, stray), " without a code that it belongs to"), false, step);
    }
    return;
  }
  bool is_consequence = false;
  std::string reason = WhyNoMove(request, &is_consequence);
  if (reason.empty()) reason = WhyNoVector(request, *step);
  if (reason.empty()) reason = WhyNoApproach(request);
  if (!reason.empty()) return Unsupported(std::move(reason), is_consequence, step);
  if (is_cycle) return Drill(block, request, step);
  Move(block, request, step);
  if (step->kind == StepKind::kMove && (modal_.calls_at_moves || request.cycle_call != nullptr))
    CallCycle(request, step);
}

void Interpreter::DoDwell(const Request& request, Step* step) {
  for (int i = 0; i < axis_count_; ++i) {
    if (step->word_of_axis[i] < 0 || machine_->axes[i].name == "X" || machine_->axes[i].name == "U") continue;
    return Unsupported("a dwell with the axis word " + machine_->axes[i].name, false, step);
  }
  if (request.motion != nullptr) return Unsupported("a dwell and a motion code in one block", false, step);
  if (request.has_axis && request.parameter == 'P')
    Unsupported("a dwell with two times: one of them may be a position", false, step);
}

void Interpreter::DoMachineMove(const Request& request, Step* step) {
  const bool names_axis = request.has_axis || request.foreign_axis != 0;
  if (request.machine_move->detail == 1 && names_axis)
    return Unsupported(step->reason + " and words of axes in one block", false, step);
  if (modal_.cutter_side != 0) {
    LoseCutter();
    return Unsupported(step->reason + " while cutter compensation is active: end that in front of it", false, step);
  }
  if (modal_.calls_at_moves) return Unsupported(step->reason + " while MCALL is in force: it drills", false, step);
  step->kind = StepKind::kUntouched;
  if (modal_.motion == Meaning::kDrillCycle) modal_.motion = Meaning::kOtherMotion;
  // Under tool centre point control every axis that moves moves the tool point in all directions of the words.
  if ((modal_.tool_point & ~kPlacedFrames) != 0) return ForgetPositions(true);
  for (const int axis : frame_of_words_.xyz()) {
    if (word_frame_ != nullptr) ForgetPosition(axis, true);
  }
  for (int i = 0; i < axis_count_; ++i) {
    const bool is_named =
        step->word_of_axis[i] >= 0 || !request.has_axis || request.foreign_axis != 0 || request.HasVector();
    if (is_named || !request.is_whole) ForgetPosition(i, true);
  }
}

void Interpreter::DoPreset(const Block& block, const Request& request, Step* step) {
  const std::string name = request.scaling_off != nullptr ? "G50" : "G92", what = request.preset->text;
  std::string problem;
  switch (request.preset->detail) {
    case 1:
      // Fanuc names the axes, LinuxCNC means all.
      step->preset_axes = request.has_axis || request.foreign_axis != 0 ? 0 : 0xFFFF;
      for (int i = 0; i < axis_count_; ++i) {
        if (step->word_of_axis[i] >= 0) step->preset_axes |= static_cast<uint16_t>(1u << i);
      }
      coordinates_.ClearPreset(step->preset_axes);
      step->preset = PresetChange::kCleared;
      return;
    case 2:
    case 3:
      // LinuxCNC keeps both in one place.
      if (coordinates_.has_shift()) {
        problem = "with a local shift (G52) in force";
        break;
      }
      if (request.preset->detail == 2) {
        coordinates_.SuspendPreset();
        step->preset = PresetChange::kSuspended;
      } else {
        coordinates_.RestorePreset();
        step->preset = PresetChange::kRestored;
      }
      return;
    default:
      break;
  }
  const bool is_alone = !request.has_axis && request.foreign_axis == 0 && request.parameter == 0;
  if (is_alone && problem.empty()) return;  // G92 S2000 limits the spindle
  if (request.preset->detail == kPresetOrThread && request.has_feed) {
    modal_.motion = Meaning::kOtherMotion;
    modal_.motion_text = "G92 with an F word: a thread of lathes";
    problem = "with an F word it is a thread of lathes";
  }
  if (modal_.blockers != 0) problem = BlockerText(modal_.blockers);
  if (modal_.tool_point != 0) problem = BlockerText(modal_.tool_point);
  if (request.foreign_axis != 0) problem = absl::StrCat("word ", std::string(1, request.foreign_axis));
  if (modal_.uncertain & (kOffsetGroup | kLengthGroup)) problem = "the modal state is not known";
  if (request.has_axis && problem.empty()) problem = UnitProblem();
  step->preset_axes = 0;
  for (int i = 0; i < axis_count_ && problem.empty(); ++i) {
    if (step->word_of_axis[i] < 0) continue;
    const Word& word = block.words[static_cast<size_t>(step->word_of_axis[i])];
    problem = WordProblem(word);
    if (!problem.empty()) break;
    if (!positions_.is_known(i)) {
      problem = absl::StrCat("the position of ", machine_->axes[i].name, " is unknown");
      break;
    }
    const std::optional<Ticks> value = ToTicks(Meant(word.number, ticks_per_unit(i)), ticks_per_unit(i));
    coordinates_.Preset(i, positions_.ticks[i], *value);
    step->preset_axes |= static_cast<uint16_t>(1u << i);
  }
  if (!problem.empty()) {
    modal_.blockers |= kShift;
    return Unsupported(absl::StrCat(name, " (", what, "): ", problem), false, step);
  }
  step->preset = PresetChange::kSet;
  step->end = positions_;
}

void Interpreter::DoShift(const Block& block, const Request& request, Step* step) {
  std::string problem;
  if (request.foreign_axis != 0) problem = absl::StrCat("word ", std::string(1, request.foreign_axis));
  if (modal_.is_incremental || (modal_.uncertain & kDistanceGroup) != 0)
    problem = "in G91 controllers differ on what it means";
  if (modal_.tool_point != 0) problem = BlockerText(modal_.tool_point);
  if (request.has_axis && problem.empty()) problem = UnitProblem();
  for (int i = 0; i < axis_count_ && problem.empty(); ++i) {
    if (step->word_of_axis[i] < 0) continue;
    const Word& word = block.words[static_cast<size_t>(step->word_of_axis[i])];
    problem = WordProblem(word);
    if (problem.empty() && !coordinates_.Shift(i, *ToTicks(Meant(word.number, ticks_per_unit(i)), ticks_per_unit(i))))
      problem = "with preset coordinates (G92) in force controllers differ";
  }
  if (problem.empty()) return;
  modal_.blockers |= kShift;
  Unsupported(absl::StrCat("G52 (", request.shift->text, "): ", problem), false, step);
}

std::string Interpreter::UnitProblem() const {
  if ((modal_.uncertain & kUnitGroup) == 0) return "";
  if (options_->unit == ProgramUnit::kUnstated && !says_mm_ && !says_inch_) {
    return "the unit is not known: nothing in front of this block says inch or mm, state it with --unit mm or --unit "
           "inch";
  }
  return "the unit (G20, G21) is not known behind a block that was not followed, or a program that says another one";
}

std::string Interpreter::WhyNoMove(const Request& request, bool* is_consequence) {
  *is_consequence = false;
  if (modal_.blockers != 0) {
    *is_consequence = (modal_.blockers & request.blockers_before) != 0;
    const bool is_lost = (modal_.blockers & lost_tool_point_) != 0 && (modal_.blockers & ~lost_tool_point_) == 0;
    return absl::StrCat(BlockerText(modal_.blockers),
                        is_lost ? absl::StrCat(", or not: line ", lost_tool_point_line_,
                                               " may have ended it; end it in front of that line and begin it again")
                                : "");
  }
  if (modal_.motion == Meaning::kOtherMotion) {
    *is_consequence = request.motion == nullptr;
    return modal_.motion_text;
  }
  if (modal_.motion == Meaning::kCancelMotion) return "axis words while no motion code is in force (G80)";
  const bool is_arc = modal_.motion == Meaning::kArc;
  const bool is_control = (modal_.tool_point & ~kPlacedFrames) != 0;
  if (is_arc && is_control) return "a circular move under tool centre point control";
  if (is_arc && word_frame_ != nullptr && !word_frame_->keeps_circles)
    return "a circular move while the axes of its plane are scaled otherwise";
  if (is_arc && word_frame_ != nullptr && modal_.plane_normal != 2 &&
      (frames_.inner - Eigen::Matrix3d::Identity()).norm() > 0)
    return "a circular move in another plane than XY of turned or mirrored coordinates";
  if (is_control || is_in_table()) {
    const bool may_wait = !is_control && modal_.motion == Meaning::kRapid;  // for its length: Move
    if (!may_wait && (coordinates_.active_length() <= 0 || (modal_.uncertain & kLengthGroup) != 0)) {
      *is_consequence = is_tool_length_asked_;
      is_tool_length_asked_ = true;
      return absl::StrCat(
          is_control ? BlockerText(modal_.tool_point) : "a tilted plane or a dynamic work offset is active",
          ", and no tool length is in force: the words lead a tool point that is not known; call the "
          "tool's length in front of it, and state it with --tool-length");
    }
  }
  // While the tool length is unknown, so is where Z words lead.
  const uint8_t needed = static_cast<uint8_t>((kAllGroups & ~(is_arc ? kLengthGroup : kPlaneGroup | kLengthGroup)) |
                                              (is_arc && request.has_centre ? kCentreGroup : 0));
  if (const uint8_t missing = modal_.uncertain & needed; missing != 0) {
    *is_consequence = (missing & request.uncertain_before) != 0;
    if (missing & kUnitGroup) {
      *is_consequence = is_unit_asked_;
      is_unit_asked_ = true;
      return UnitProblem();
    }
    return absl::StrCat(NameOf(static_cast<ModalGroup>(missing & -missing)),
                        " is not known behind a block that was not followed");
  }
  if (request.foreign_axis != 0) {
    return absl::StrCat("word ", std::string(1, request.foreign_axis), ": machine '", machine_->id,
                        "' has no such axis");
  }
  if (modal_.motion == Meaning::kDrillCycle) return "";
  const char* const kind = is_arc ? " in a circular move" : " in a linear move";
  if (request.parameter != 0) return absl::StrCat("word ", std::string(1, request.parameter), kind);
  if (is_arc && dialect_->has_poles && request.motion == nullptr) return "axis words without L or C behind an arc";
  if (!is_arc && request.radius != nullptr) return absl::StrCat("word R", kind);
  if (!is_arc && request.has_centre) return absl::StrCat("word I, J or K", kind);
  return "";
}

std::string Interpreter::WordProblem(const Word& word) const {
  const Decimal& number = word.number;
  if (!number.has_point && number.digits >= 5 && options_->integer_words == IntegerWords::kWholeUnits) {
    return absl::StrCat(
        "word ", WordText(word),
        " has no point and five digits or more: state whether it counts whole units or least increments");
  }
  const Ticks unit = modal_.is_inch ? kTicksPerInch : kTicksPerMm;
  const std::optional<Ticks> ticks = ToTicks(Meant(number, unit), unit);
  if (!ticks || std::abs(*ticks) > kMaxTicks)
    return absl::StrCat("word ", WordText(word), " has more than nine decimals or is out of range");
  return "";
}

std::optional<Ticks> Interpreter::LengthTicks(const Word& word) const {
  const Ticks unit = modal_.is_inch ? kTicksPerInch : kTicksPerMm;
  const std::optional<Ticks> ticks = ToTicks(Meant(word.number, unit), unit);
  return !ticks || std::abs(*ticks) > kMaxTicks ? std::nullopt : ticks;
}

bool Interpreter::MayMoveBy(int axis, Step* step) {
  if (!step->end.is_known(axis)) {
    Unsupported(absl::StrCat("G91 from an unknown position of ", machine_->axes[axis].name), is_unknown_reported(axis),
                step);
    return false;
  }
  if (needs_absolute_ >> axis & 1) {
    Unsupported("G91 behind a change of the tool length or of the work offset: controllers differ", false, step);
    return false;
  }
  return true;
}

bool Interpreter::ReadTargets(const Block& block, Step* step) {
  step->start.CopyFrom(positions_, axis_count_);
  Positions& end = step->end;
  end.CopyFrom(positions_, axis_count_);
  for (int i = 0; i < axis_count_; ++i) {
    if (step->word_of_axis[i] < 0) continue;
    const Word& word = block.words[static_cast<size_t>(step->word_of_axis[i])];
    const Decimal& number = word.number;
    const bool is_incremental = IsIncremental(word);
    if (is_incremental && !MayMoveBy(i, step)) return false;
    Ticks before = end.ticks[i];
    const Ticks base = is_incremental ? before : offset(i), unit = ticks_per_unit(i);
    Ticks value = 0;
    // With five whole digits at most, 2540 m, no limit is near.
    if (number.has_point && number.decimals <= kMaxDecimals && number.digits - number.decimals <= 5) {
      value = number.mantissa * GrainTicks(unit, number.decimals);
    } else if (!ReadTarget(word, unit, &value, step)) {
      return false;
    }
    const Ticks target = base + value;  // far from overflow: values are within 9e18, bases within 1e17
    if (!InRange(target)) {
      Unsupported(absl::StrCat("word ", WordText(word), " is out of range"), false, step);
      return false;
    }
    if (word.distance >= Distance::kShortestWay) {
      end.ticks[i] = target;
      if (!Wrap(word, i, step)) return false;
      before = step->start.ticks[i];
    } else if ((ways_ >> i & 1) && !is_incremental) [[unlikely]] {
      end.ticks[i] = target;
      if (!TakeWay(word, i, step)) return false;
      if (!end.is_known(i)) end.known |= static_cast<uint16_t>(1u << i);
      continue;
    }
    if (target != before) end.sense[i] = target > before ? 1 : -1;
    end.ticks[i] = target;
    if (!end.is_known(i)) {
      end.sense[i] = 0;
      end.known |= static_cast<uint16_t>(1u << i);
    }
  }
  if (modal_.uncertain & kLengthGroup) {
    const int z = AxisOf('Z');
    if (z >= 0) end.known &= static_cast<uint16_t>(~(1u << z));
  }
  if (needs_absolute_ != 0) {
    for (int i = 0; i < axis_count_; ++i) {
      if (step->word_of_axis[i] >= 0) needs_absolute_ &= static_cast<uint16_t>(~(1u << i));
    }
  }
  return true;
}

bool Interpreter::Wrap(const Word& word, int axis, Step* step) {
  const auto refuse = [&](const std::string& reason) {
    Unsupported(absl::StrCat("word ", WordText(word), ": ", reason), false, step);
    return false;
  };
  const Ticks value = step->end.ticks[axis] - offset(axis);
  if (is_linear_[axis]) return refuse("a way round is of rotary axes");
  if (value < 0 || value >= kTurn) return refuse("a position of an axis that counts from 0 to 360 deg is out of it");
  // A correction of the start could turn a move of zero length into a full turn.
  if (options_->orientation && word.distance != Distance::kShortestWay)
    return refuse("a stated sense of rotation while rotary axes are corrected");
  step->wrapped |= static_cast<uint16_t>(1u << axis);
  if (!step->start.is_known(axis)) return true;
  Ticks travel = (step->end.ticks[axis] - step->start.ticks[axis]) % kTurn;
  if (travel < 0) travel += kTurn;
  if (word.distance == Distance::kShortestWay && 2 * travel == kTurn)
    return refuse("half a turn: which way the axis goes is not known");
  if (travel != 0 &&
      (word.distance == Distance::kDownwards || (word.distance == Distance::kShortestWay && 2 * travel > kTurn)))
    travel -= kTurn;
  step->start.ticks[axis] = step->end.ticks[axis] - travel;
  return true;
}

machine::RollOver Interpreter::WayOf(int axis, const Modal& modal) const {
  using machine::RollOver;
  const machine::Axis& stated = machine_->axes[axis];
  RollOver way = stated.roll_over;
  // With travel limits an axis counts on, unless the program itself speaks of a shorter way.
  const bool is_limited = stated.min_position || stated.max_position;
  if (way == RollOver::kUnstated && is_limited && modal.way == Way::kOfAxis) way = RollOver::kNone;
  if (way == RollOver::kNone || modal.way == Way::kOfAxis) return way;
  return way != RollOver::kUnstated && modal.way == Way::kShorter ? RollOver::kShortest : RollOver::kUnstated;
}

bool Interpreter::TakeWay(const Word& word, int axis, Step* step) {
  using machine::RollOver;
  const auto refuse = [&](const std::string& reason) {
    Unsupported(absl::StrCat("word ", WordText(word), ": ", reason), false, step);
    return false;
  };
  const auto modulo = [](Ticks ticks) {
    const Ticks rest = ticks % kTurn;
    return rest < 0 ? rest + kTurn : rest;
  };
  const RollOver way = WayOf(axis);
  const auto bit = static_cast<uint16_t>(1u << axis);
  Ticks &start = step->start.ticks[axis], &end = step->end.ticks[axis];
  const Ticks origin = offset(axis), value = end - origin;
  const bool is_known = step->start.is_known(axis);
  const auto turn_by = [&](Ticks travel) {
    start = end - travel;
    step->end.sense[axis] = travel > 0 ? 1 : travel < 0 ? -1 : step->start.sense[axis];
  };
  step->end.sense[axis] = 0;
  if (way == RollOver::kUnstated || way == RollOver::kNone) {
    if (!is_known) return true;
    const Ticks travel = end - start;
    const bool is_long = 2 * std::abs(travel) >= kTurn;
    if (is_long && !step->is_rapid && way == RollOver::kUnstated) {
      return refuse(absl::StrCat("it turns ", machine_->axes[axis].name,
                                 " by half a turn or more, and which way is not known: state in machine.json how the "
                                 "axis counts (roll_over)"));
    }
    if (!is_long || way == RollOver::kNone) turn_by(travel);
    return true;
  }
  step->word_turns[axis] = 0;
  if (way == RollOver::kBySign) {
    if (value <= -kTurn || value >= kTurn) return refuse("its axis rolls over by the sign: expected less than 360 deg");
    if (options_->orientation) return refuse("a sense of rotation by the sign while rotary axes are corrected");
    const bool has_sign = word.end - word.number_at > static_cast<uint32_t>(word.number.digits + word.number.has_point);
    if (value == 0 && has_sign && !word.number.has_plus)
      return refuse("its axis rolls over by the sign, and controls differ on that of zero");
    step->wrapped |= bit;
    if (value < 0) step->downwards |= bit, end = origin - value;
    if (!is_known) return true;
    const Ticks travel = modulo(end - start);
    turn_by(value < 0 && travel != 0 ? travel - kTurn : travel);
    return true;
  }
  if (way == RollOver::kByDifference) {
    if (value < 0 || value >= kTurn)
      return refuse("its axis counts from 0 to 360 deg (roll_over), expected a position of that range");
    if (options_->orientation) return refuse("a way by the difference while rotary axes are corrected");
    step->wrapped |= bit;
    if (!is_known) return true;
    const Ticks travel = value - modulo(start - origin);
    if (travel != modulo(end) - modulo(start))
      return refuse("its way is not known: the control may count from 0 to 360 deg with or without the offset");
    turn_by(travel);
    return true;
  }
  step->wrapped |= bit;
  step->word_turns[axis] = static_cast<int16_t>((value - modulo(value)) / kTurn);
  if (!is_known) return true;
  const Ticks travel = modulo(end - start);
  const Ticks slack =
      options_->orientation
          ? static_cast<Ticks>(2.0 * options_->max_rotary_correction_rad * base::kDegPerRad * kTicksPerUnit)
          : 0;
  const bool is_half = std::abs(2 * travel - kTurn) <= 2 * slack;
  if (is_half && !step->is_rapid)
    return refuse("half a turn on an axis that goes the shorter way: which way is not known");
  turn_by(2 * travel > kTurn ? travel - kTurn : travel);
  if (is_half) step->end.sense[axis] = 0;
  return true;
}

bool Interpreter::ReadTarget(const Word& word, Ticks unit, Ticks* value, Step* step) {
  const bool is_in_range = ToTicks(Meant(word.number, unit), unit, value) && InRange(*value);
  const bool is_odd = !word.number.has_point && word.number.digits >= 5;
  const bool is_integer = !word.number.has_point && word.number.mantissa != 0;
  if (is_integer && !has_noted_integers_ && dialect_->integers_may_be_increments &&
      options_->integer_words == IntegerWords::kWholeUnits) {
    has_noted_integers_ = true;
    step->note =
        RemarkAt(line_, "whole-units",
                 absl::StrCat("word ", WordText(word),
                              " has no point: such words count whole units here, on other controls least increments"));
  }
  if (is_in_range && !is_odd) return true;
  std::string problem = WordProblem(word);
  if (problem.empty() && !is_in_range) problem = absl::StrCat("word ", WordText(word), " is out of range");
  if (problem.empty()) return true;
  Unsupported(std::move(problem), false, step);
  return false;
}

void Interpreter::WaitForLength(Step* step) {
  if (coordinates_.active_length() > 0 && (modal_.uncertain & kLengthGroup) == 0) return;
  const std::array<int, 3>& xyz = frame_of_words_.xyz();
  bool is_known = true;
  for (int i = 0; i < axis_count_; ++i) is_known &= is_linear_[i] || step->end.is_known(i);
  const bool is_upright =
      is_known && (word_frame_->base == WordFrame::Base::kTable || frame_of_words_.IsAlongZ(step->end.ticks));
  // The length that comes moves the tool along Z alone where the tool stands along it.
  for (size_t k = is_upright ? 2 : 0; k < 3; ++k) {
    if (step->end.is_known(xyz[k])) ForgetPosition(xyz[k], false);
    step->end.known &= static_cast<uint16_t>(~(1u << xyz[k]));
  }
}

void Interpreter::Move(const Block& block, const Request& request, Step* step) {
  step->is_rapid = modal_.motion == Meaning::kRapid || request.is_rapid_block;
  if (!ReadTargets(block, step)) return;
  if (modal_.motion == Meaning::kArc && !ReadArc(block, request, step)) return;
  if (modal_.cutter_side != 0 || request.cutter_side_before != 0) {
    if (std::string reason = WhyNoContour(request, *step); !reason.empty()) {
      LoseCutter();
      return Unsupported(std::move(reason), false, step);
    }
  }
  if (is_in_table() && !KeepsPlane(step)) return;
  if (is_in_table()) WaitForLength(step);
  step->takes_no_rotary_words = StatesVectors();
  if (request.HasVector()) {
    if (std::string reason = TurnToVector(block, request, step); !reason.empty())
      return Unsupported(std::move(reason), false, step);
  }
  if ((modal_.tool_point & ~kPlacedFrames) != 0 && modal_.turns_by_vector && !step->is_rapid && !TurnsAlike(step)) {
    return Unsupported(
        "the tool turns by a vector (ORIVECT, ORIWKS), or nobody says how, and axis by axis it would turn another way: "
        "state ORIAXES, or shorter moves",
        false, step);
  }
  if (traced_ != 0 && step->end.known == (1u << axis_count_) - 1) step->start.known |= traced_;
  step->is_at_corner = rounds_corners_ || is_behind_corner_ || request.has_corner;
  is_behind_corner_ = request.has_corner;
  for (const int axis : {frame_of_words_.xyz()[0], frame_of_words_.xyz()[1]}) {
    if (modal_.cutter_side == 0 && axis >= 0 && step->word_of_axis[axis] >= 0 &&
        (step->is_arc || !step->start.is_known(axis) || step->start.ticks[axis] != step->end.ticks[axis]))
      modal_.is_cutter_ending = false;
  }
  GoTo(step);
}

void Interpreter::GoTo(Step* step) {
  step->kind = StepKind::kMove;
  TakeFrame(step);
  positions_.CopyFrom(step->end, axis_count_);
  traced_ &= static_cast<uint16_t>(~positions_.known);
  has_moved_ = true;
}

}  // namespace axiscal::nc
