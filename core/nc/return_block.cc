// The way back to where the program thinks the control is, in front of blocks that are passed.
#include <algorithm>
#include <cmath>

#include "core/nc/block_writer.h"
#include "core/nc/char_class.h"

namespace axiscal::nc {
namespace {

// Of the block in G93: it takes 1/1000 min, as long as micrometres take at any feed.
constexpr const char* kInverseTimeFeed = " F1000.";

}  // namespace

uint16_t BlockWriter::Departed() const {
  uint16_t departed = 0;
  for (const int axis : order_) {
    if (Departure(axis) != 0) departed |= static_cast<uint16_t>(1u << axis);
  }
  return departed;
}

double BlockWriter::WayBackMm() const {
  double squares_mm2 = 0.0;
  for (const int axis : order_) {
    if (!is_linear_[axis]) continue;
    const double way_mm = static_cast<double>(Departure(axis)) / kTicksPerUnit;
    squares_mm2 += way_mm * way_mm;
  }
  return std::sqrt(squares_mm2);
}

void BlockWriter::ForgetAll(uint16_t kept) {
  adrift_ |= static_cast<uint16_t>(Departed() & ~kept);
  commanded_.known &= kept;
  pole_.is_known = false;
}

void BlockWriter::BeginProgram(bool is_behind_end) {
  ForgetAll();
  if (is_behind_end) adrift_ = 0;
  preset_shift_ = suspended_shift_ = {};
  wrapped_ = 0;
  is_in_chords_ = is_pole_moved_ = false;
}

void BlockWriter::Arrive(const Step& step) {
  for (const int axis : order_) programmed_[axis] = step.end.ticks[axis];
  adrift_ &= static_cast<uint16_t>(~commanded_.known);
  is_last_rapid_ = step.is_rapid;
  for (const int axis : order_) {
    if (step.word_of_axis[axis] >= 0) wrapped_ &= static_cast<uint16_t>(~(1u << axis));
  }
  wrapped_ |= step.wrapped;
}

void BlockWriter::LeaveAdrift(const char* text, size_t size, const StateBefore& before, const std::string& line_end,
                              OutBuffer* out) {
  if (interpreter_->dialect().has_poles) ReturnPole(before, line_end, out);
  for (const int axis : order_) {
    const char letter = machine_->axes[axis].name[0];
    const bool is_named = std::any_of(text, text + size, [letter](char c) { return Capital(c) == letter; });
    if (is_named) commanded_.known &= static_cast<uint16_t>(~(1u << axis));
  }
  ForgetAll();
}

void BlockWriter::AppendExact(int axis, Ticks target, Ticks base, bool is_inch, bool says_angle, OutBuffer* out) const {
  const Ticks unit = is_inch && is_linear_[axis] ? kTicksPerInch : kTicksPerMm;
  const WordForm form = ExactForm(rule_.Inserted(unit), target - base, unit);
  out->push_back(' ');
  out->push_back(machine_->axes[axis].name[0]);
  CorrectedWord word = WordFor(target, base, form);
  if (says_angle) {
    word.number %= kTurn / form.grain;
    if (word.number < 0) word.number += kTurn / form.grain;
    AppendDistance(Distance::kShortestWay, out);
  }
  AppendNumber(word, interpreter_->dialect().writes_plus, out);
  if (says_angle && !interpreter_->dialect().distance_names.empty()) out->push_back(')');
}

void BlockWriter::ReturnPole(const StateBefore& before, const std::string& line_end, OutBuffer* out) {
  if (!is_pole_moved_ || !before.pole.is_known || (pole_.is_known && pole_.ticks == before.pole.ticks)) return;
  is_pole_moved_ = false;
  pole_ = before.pole;
  pole_.is_absolute = true;
  out->append(std::string("CC"));
  static constexpr const char* kAxes[] = {"X", "Y"};  // Klartext's poles stand in XY
  for (const size_t index : {size_t{0}, size_t{1}}) {
    const int axis = machine::FindAxis(*machine_, kAxes[index]);
    AppendExact(axis, pole_.ticks[index], before.offsets[axis], before.modal.is_inch, false, out);
  }
  out->append(line_end);
}

std::string BlockWriter::Return(const StateBefore& before, const std::string& line_end, OutBuffer* out) {
  const bool has_poles = interpreter_->dialect().has_poles;
  const uint16_t departed = Departed();
  if (departed != 0) {
    const Modal& modal = before.modal;
    const bool is_rapid = has_poles ? is_last_rapid_ : modal.motion == Meaning::kRapid;
    if (modal.motion == Meaning::kDrillCycle || modal.calls_at_moves)
      return "the control stands at a corrected position, and a block in front of it would drill, or end the cycle";
    if (before.is_at_corner) return "the control rounds or chamfers the corner in front of it";
    constexpr uint8_t kNeeded = kMotionGroup | kDistanceGroup | kUnitGroup | kFeedGroup | kOffsetGroup | kLengthGroup;
    if (modal.blockers != 0 || (modal.uncertain & kNeeded) != 0 || modal.motion == Meaning::kOtherMotion)
      return "the control stands at a corrected position, and its modal state is not known";
    if (modal.is_rapid_unsure)
      return "the control stands at a corrected position, in G00 or not as a block with '/' says";
    for (const int axis : order_) {
      const machine::RollOver way = interpreter_->WayOf(axis, modal);
      const bool is_stated = way == machine::RollOver::kNone || way == machine::RollOver::kShortest;
      if ((departed >> axis & 1) == 0 || is_linear_[axis] || is_stated || modal.is_incremental) continue;
      // A word that was written for the shorter way says so itself in some dialects alone: C=DC(10).
      const bool says_way = (wrapped_ >> axis & 1) != 0 && !interpreter_->dialect().distance_names.empty();
      if (!says_way) {
        return absl::StrCat("the control stands at a corrected position of ", machine_->axes[axis].name,
                            ", and which way the axis would turn back is not known (roll_over)");
      }
    }
    if (!is_rapid && modal.feed_mode != FeedMode::kInverseTime && modal.lacks_feed)
      return "the control stands at a corrected position, and no F was programmed since the feed mode changed";
    out->append(std::string(has_poles ? "L" : is_rapid ? "G00" : "G01"));
    for (const int axis : order_) {
      if ((departed >> axis & 1) == 0) continue;
      const bool is_wrapped = (wrapped_ >> axis & 1) != 0;
      // In G91 an angle needs a word that says it is one: C=DC(10).
      const bool is_incremental =
          modal.is_incremental && !(is_wrapped && !interpreter_->dialect().distance_names.empty());
      const Ticks target = programmed_[axis] + preset_shift_[axis];
      Ticks base = is_incremental ? commanded_.ticks[axis] : before.offsets[axis] + preset_shift_[axis];
      // Both may be whole turns apart, where the axis counts from 0 again.
      if (is_incremental && is_wrapped)
        base += kTurn * std::llround(static_cast<double>(target - base) / static_cast<double>(kTurn));
      AppendExact(axis, target, base, modal.is_inch, is_wrapped && !is_incremental, out);
      commanded_.ticks[axis] = target;
    }
    if (has_poles && is_rapid) out->append(std::string(" FMAX"));
    if (!is_rapid && modal.feed_mode == FeedMode::kInverseTime) out->append(std::string(kInverseTimeFeed));
    out->append(line_end);
    if (modal.motion == Meaning::kCancelMotion) out->append("G80" + line_end);
    is_in_chords_ |= modal.motion == Meaning::kArc && !has_poles;
  }
  if (has_poles) ReturnPole(before, line_end, out);
  return "";
}

}  // namespace axiscal::nc
