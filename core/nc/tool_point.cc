// Tool centre point control: where it can be followed, and what becomes of the positions where it begins and ends.
#include <algorithm>
#include <string>

#include "core/nc/char_class.h"
#include "core/nc/request.h"

namespace axiscal::nc {

namespace {

// Of the sines and cosines on the way from one frame to the other, over metres.
constexpr Ticks kRoundingTicks = kTicksPerMm / 1'000'000;

}  // namespace

std::string Interpreter::WhyNoToolPoint(const char* text, const Block& block, const Request& request) const {
  if (!frame_of_words_.problem().empty()) return frame_of_words_.problem();
  const Word& word = *request.tool_point_word;
  if (word.letter == 0) {
    const char* const name = dialect_->keywords[static_cast<size_t>(word.keyword)].name;
    const std::string rest = RestOf(text + word.letter_at + std::string(name).size(), end_of_text_);
    if (dialect_->has_poles) {
      // TNC 640: rotary words are positions of axes, and turn axis by axis.
      static constexpr const char* kKnown[] = {"F TCP AXIS POS PATHCTRL AXIS", "F CONT AXIS POS PATHCTRL AXIS",
                                               "F TCP AXIS POS PATHCTRL AXIS REFPNT TIP-TIP",
                                               "F CONT AXIS POS PATHCTRL AXIS REFPNT TIP-TIP"};
      if (std::find(std::begin(kKnown), std::end(kKnown), rest) == std::end(kKnown))
        return absl::StrCat("with '", rest, "': followed is F TCP AXIS POS PATHCTRL AXIS");
    } else if (!rest.empty() && rest != "()" && rest != "(1)") {
      return absl::StrCat("with '", rest, "': followed is the machine's first transformation, alone in its block");
    }
  }
  if ((modal_.tool_point & kPlacedFrames) != 0) return "together with a turned frame or a tilted plane";
  if ((modal_.uncertain & (kOffsetGroup | kLengthGroup)) != 0) return "the work offset or the tool length is not known";
  if (coordinates_.has_preset() || coordinates_.has_shift() || coordinates_.has_frame())
    return "with preset or shifted coordinates (G92, G52, TRANS, cycle 7) in force controllers differ";
  if (coordinates_.has_length_difference())
    return "with a difference of the tool length (DL) the tool point is not that of the stated length";
  return RotaryOffsetProblem();
}

std::string Interpreter::RotaryOffsetProblem() const {
  for (int i = 0; i < axis_count_; ++i) {
    if (is_linear_[i] || coordinates_.Offset(i) == 0) continue;
    return absl::StrCat("the work offset of ", machine_->axes[i].name,
                        " is not zero, and whether the words' frame stands with the table at zero or at the offset is "
                        "not known");
  }
  return "";
}

void Interpreter::BeginToolPoint(const char* text, const Block& block, Request* request) {
  const bool states_vectors = (request->tool_point->detail & kStatesVectors) != 0;
  const uint32_t bit = request->tool_point->detail & ~(kSelectsLength | kStatesVectors);
  EndMode(bit);
  blockers_seen_ |= bit;
  std::string problem = WhyNoToolPoint(text, block, *request);
  // P3 and L1 of G43.4 turn the tool otherwise.
  const bool has_stray_centre = request->has_centre && !states_vectors;
  const char stray = request->parameter != 0 ? request->parameter : has_stray_centre ? 'I' : char{0};
  if (problem.empty() && stray != 0)
    problem = absl::StrCat("with a word ", std::string(1, stray), ": what it chooses is not followed");
  if (problem.empty() && states_vectors && options_->orientation)
    problem = "with --orientation it is not followed: a correction of the tool's direction would change I, J and K";
  if (problem.empty() && modal_.tool_point == 0 && request->problem.empty()) {
    modal_.tool_point = bit;
    modal_.states_vectors = states_vectors;
    return;
  }
  LoseToolPoint();
  modal_.blockers |= bit;
  const Word& word = *request->tool_point_word;
  const std::string name =
      word.letter == 0 ? dialect_->keywords[static_cast<size_t>(word.keyword)].name : WordText(word);
  request->Refuse(absl::StrCat(name, " (", request->tool_point->text, ")", problem.empty() ? "" : ": ", problem));
}

bool Interpreter::ToFrame(const FrameChange& change, AxisTicks* ticks) const {
  const double length_mm = static_cast<double>(change.length) / kTicksPerUnit;
  return change.to == FrameChange::To::kWords ? frame_of_words_.ToWords(length_mm, ticks)
                                              : frame_of_words_.ToAxes(length_mm, ticks);
}

bool Interpreter::IsKept(const FrameChange& change) const {
  const std::array<int, 3>& xyz = frame_of_words_.xyz();
  return std::all_of(xyz.begin(), xyz.end(), [&](int axis) { return change.kept >> axis & 1; });
}

void Interpreter::ChangeFrame(Request* request, Step* step) {
  const bool was = (request->tool_point_before & ~kPlacedFrames) != 0;
  const bool is = (modal_.tool_point & ~kPlacedFrames) != 0;
  const bool is_same_length = request->length_before == coordinates_.active_length();
  coordinates_.SetToolPoint(is);
  if (was == is && is_same_length) return;
  is_tool_length_asked_ = false;
  if (was && !is && is_same_length && request->has_axis && modal_.blockers == 0)
    request->Refuse(
        "the end of tool centre point control and words of axes in one block: which comes first is not known");
  const std::array<int, 3>& xyz = frame_of_words_.xyz();
  const auto bit = [](int axis) { return static_cast<uint16_t>(1u << axis); };
  const auto all_xyz = static_cast<uint16_t>(bit(xyz[0]) | bit(xyz[1]) | bit(xyz[2]));
  step->frame = {true,
                 was == is ? FrameChange::To::kSame
                 : is      ? FrameChange::To::kWords
                           : FrameChange::To::kAxes,
                 0, coordinates_.length()};
  if (was != is && dialect_->transformation_may_drop_offset) modal_.uncertain |= kOffsetGroup;
  // Words that the program does not name are inserted behind this block as absolute ones. Where the frame has turned or
  // moved they would say what pivots, work offset and tool length were stated here, and millimetres beside it where the
  // control's are others: so only where X and Y stay what they are does anybody know where the axes stand. A length
  // that begins or changes here may move the tool along itself: Z is not known then.
  if (was != is && coordinates_.active_length() > 0 && modal_.blockers == 0) {
    AxisTicks ticks = positions_.ticks;
    const auto stays = [&](int axis) { return std::abs(ticks[axis] - positions_.ticks[axis]) <= kRoundingTicks; };
    const bool keeps_z = is_same_length;
    uint16_t needed = static_cast<uint16_t>(~all_xyz & ((1u << axis_count_) - 1));
    needed |= keeps_z ? all_xyz : static_cast<uint16_t>(bit(xyz[0]) | bit(xyz[1]));
    const bool is_known = (positions_.known & needed) == needed;
    if (is_known && (keeps_z || is) && frame_of_words_.IsUpright(ticks) && ToFrame(step->frame, &ticks) &&
        stays(xyz[0]) && stays(xyz[1])) {
      positions_.ticks[xyz[2]] = ticks[xyz[2]];
      step->frame.kept = needed & all_xyz;
    }
  }
  for (const int axis : xyz) {
    positions_.sense[axis] = 0;
    needs_absolute_ |= bit(axis);
    if ((step->frame.kept & bit(axis)) == 0 && positions_.is_known(axis)) ForgetPosition(axis, false);
  }
}

}  // namespace axiscal::nc
