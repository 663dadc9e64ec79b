// Modes that the text behind their keyword switches: frames of Sinumerik, cycles of Klartext that turn coordinates.
#include <algorithm>
#include <cstring>
#include <string>

#include "absl/strings/str_split.h"
#include "core/nc/char_class.h"
#include "core/nc/plain_number.h"
#include "core/nc/request.h"

namespace axiscal::nc {
namespace {

constexpr const char* kShiftedLetters = "XYZABCUVW";
constexpr uint16_t kAnyShift = 1u << 15;

// Whether it is a number, and zero: "+0", "-0.00".
bool IsZero(const std::string& text) {
  bool has_digit = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '0') {
      has_digit = true;
    } else if (c != '.' && !(i == 0 && (c == '+' || c == '-'))) {
      return false;
    }
  }
  return has_digit;
}

// "X10", "X=10", "X+10" of a line: the axis' letter and the value in ticks. False for anything else.
bool ReadShift(const std::string& word, Ticks unit, char* letter, Ticks* ticks) {
  if (word.empty() || std::strchr(kShiftedLetters, word[0]) == nullptr) return false;
  *letter = word[0];
  const bool has_equals = word.size() > 1 && word[1] == '=';
  const std::optional<Ticks> value = PlainTicks(std::string_view(word).substr(has_equals ? 2 : 1), unit);
  if (value) *ticks = *value;
  return value.has_value();
}

}  // namespace

std::string RestOf(const char* begin, const char* end) {
  std::string rest;
  for (const char* at = begin; at != end && *at != ';'; ++at) {
    const bool is_blank = *at == ' ' || *at == '\t' || *at == '\r';
    if (is_blank && (rest.empty() || rest.back() == ' ')) continue;
    rest.push_back(is_blank ? ' ' : Capital(*at));
  }
  while (!rest.empty() && rest.back() == ' ') rest.pop_back();
  return rest;
}

void Interpreter::SelectByRest(const char* text, Request* request, Step* step) {
  const uint32_t mode = request->by_rest->detail;
  const Word& word = *request->by_rest_word;
  const char* const name = dialect_->keywords[static_cast<size_t>(word.keyword)].name;
  const std::string rest = RestOf(text + word.letter_at + std::strlen(name), end_of_text_);
  bool ends = (rest.empty() && name[0] != 'A' && mode != kTiltedPlane) || (mode == kSwivel && rest == "()");
  std::string words_of_frame = rest;
  if (dialect_->has_poles && mode != kTiltedPlane) {
    // TNC 640, User's Manual for Cycle Programming: ".0" names the cycle, the lines behind it state it.
    const size_t behind = rest.find_first_not_of("0123456789", 1);
    const std::string part = rest.substr(0, behind), words = behind == std::string::npos ? "" : rest.substr(behind);
    const std::string stated = words.empty() || words[0] != ' ' ? words : words.substr(1);
    const bool is_continued = !rest.empty() && rest.back() == '~';
    const bool is_part = part.size() > 1 && part[0] == '.' && !is_continued;
    if (is_part && part == ".0") {
      step->begins_definition = true;
      return;
    }
    ends = is_part && stated.empty() && (mode == kMirror || mode == kWorkingPlane);
    if (is_part && mode == kRotation) ends = stated.rfind("ROT", 0) == 0 && IsZero(stated.substr(3));
    if (is_part && mode == kScaling && stated.rfind("SCL", 0) == 0) {
      const std::optional<Decimal> factor = PlainNumber(std::string_view(stated).substr(3));
      ends = factor && ValueOf(*factor) == 1.0;
    }
    // Without rotary axes nothing can be tilted by zero.
    if (is_part && mode == kWorkingPlane && !stated.empty() && frame_of_words_.has_xyz() && !HasRotaryAxis()) {
      const std::vector<std::string> angles = absl::StrSplit(stated, ' ', absl::SkipEmpty());
      ends = std::all_of(angles.begin(), angles.end(), [](const std::string& angle) {
        return angle.size() > 1 && angle[0] >= 'A' && angle[0] <= 'C' && IsZero(angle.substr(1));
      });
    }
    words_of_frame = is_part ? stated : std::string("~");
    // "CYCL DEF 7.1", "CYCL DEF 10.1 ROT": nothing is stated. Whether that ends what was stated before is not known.
    const bool is_empty = is_part && (stated.empty() || (mode == kRotation && stated == "ROT"));
    const bool is_off = ((modal_.blockers | modal_.tool_point) & mode) == 0;
    if (is_empty && (mode == kDatumShift || mode == kRotation) && is_off) return;
    if (mode == kDatumShift) {
      modal_.shifted_axes = is_part && !stated.empty() ? ShiftDatum(stated, modal_.shifted_axes)
                                                       : static_cast<uint16_t>(modal_.shifted_axes | kAnyShift);
      ends = modal_.shifted_axes == 0;
    }
  }
  if (ends) {
    if (mode == kModalMacro && (modal_.blockers & mode) != 0) MayHaveChanged(kCalledGroups);  // by what it called
    if (mode == kModalMacro) modal_.macro_depth = 0;
    if (mode == kModalMacro) modal_.calls_at_moves = false;
    if (mode == kMirror) modal_.mirrored_axes = 0;
    // Any of TRANS, ROT, SCALE and MIRROR replaces what all of them stated.
    for (int i = 0; mode == kFrame && i < axis_count_; ++i) ShiftFrame(i, 0);
    // The machine's builder may turn the axes home.
    if (mode == kSwivel) request->away = "end of a tilted plane";
    return EndMode(mode);
  }
  // "MCALL CYCLE81(10,0,2,-20)": one of the cycles that are followed.
  if (mode == kModalMacro && modal_.macro_depth == 0 && rest.size() > 8 && rest.rfind("CYCLE", 0) == 0) {
    for (size_t i = 0; i < dialect_->keywords.size(); ++i) {
      const Keyword& keyword = dialect_->keywords[i];
      if (keyword.meaning != Meaning::kCallCycle || rest.compare(0, 7, keyword.name) != 0) continue;
      if (!ReadArguments(rest.substr(7), &dialect_->keyword_codes[i], &modal_.called)) break;
      modal_.calls_at_moves = true;
      return;
    }
  }
  const bool adds = std::strcmp(name, "ATRANS") == 0;
  if ((adds || std::strcmp(name, "TRANS") == 0) && Translate(rest, adds)) return;
  std::string problem;
  if ((mode & kPlacedFrames) != 0 && std::strstr(name, "TRANS") == nullptr &&
      FrameByRest(name, words_of_frame, mode, step, &problem))
    return;
  if ((modal_.tool_point & mode) != 0) LoseToolPoint();
  modal_.calls_at_moves = false;
  modal_.blockers |= mode;
  if (mode == kMirror) modal_.mirrored_axes = kAllAxes;
  if (mode == kModalMacro) {
    if (modal_.macro_depth < 255) ++modal_.macro_depth;
    NoteCall();
    request->is_call = true;
  }
  request->Refuse(absl::StrCat(name, " (", request->by_rest->text, ")", problem.empty() ? "" : ": ", problem));
}

void Interpreter::ShiftFrame(int axis, Ticks value) {
  if (coordinates_.frame(axis) == value) return;
  coordinates_.SetFrame(axis, value);
  pole_.is_known = false;
  if (dialect_->g91_takes_new_offsets) needs_absolute_ |= static_cast<uint16_t>(1u << axis);
}

// 840D sl, Programming Manual Fundamentals, "Programmable zero offset (TRANS, ATRANS)": TRANS replaces all that frames
// stated before, ATRANS adds to it.
bool Interpreter::Translate(const std::string& words, bool adds) {
  const uint32_t others = modal_.blockers & ~(adds ? 0u : static_cast<uint32_t>(kFrame));
  if (others != 0 || (modal_.tool_point & ~(kFrame | kSwivel)) != 0 || block_may_be_skipped_ || modal_.is_inch ||
      (modal_.uncertain & (kUnitGroup | kOffsetGroup)) != 0)
    return false;
  AxisTicks shift{};
  uint16_t named = 0;
  for (const std::string& word : std::vector<std::string>(absl::StrSplit(words, ' ', absl::SkipEmpty()))) {
    char letter = 0;
    Ticks ticks = 0;
    const bool is_read = ReadShift(word, kTicksPerMm, &letter, &ticks);
    const int axis = is_read ? AxisOf(letter) : -1;
    if (axis < 0 || (named >> axis & 1)) return false;
    named |= static_cast<uint16_t>(1u << axis);
    shift[axis] = ticks;
  }
  if (named == 0) return false;
  if (adds && (modal_.tool_point & kFrame) != 0) {
    // Behind a rotation, a mirror or a scale it is counted along what these turned.
    Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
    for (int i = 0; i < axis_count_; ++i) {
      if (shift[i] == 0) continue;
      const std::array<int, 3>& xyz = frame_of_words_.xyz();
      const auto k = std::find(xyz.begin(), xyz.end(), i) - xyz.begin();
      if (k == 3) return false;
      shift_mm[k] = static_cast<double>(shift[i]) / kTicksPerUnit;
    }
    frames_.inner_at_mm += frames_.inner * shift_mm;
    return true;
  }
  EndMode(kFrame);
  for (int i = 0; i < axis_count_; ++i) ShiftFrame(i, shift[i] + (adds ? coordinates_.frame(i) : 0));
  return true;
}

// TNC 640, User's Manual for Cycle Programming, "Datum shift (cycle 7)": an axis that is not named keeps its shift.
uint16_t Interpreter::ShiftDatum(const std::string& words, uint16_t shifted) {
  for (const std::string& word : std::vector<std::string>(absl::StrSplit(words, ' ', absl::SkipEmpty()))) {
    char letter = word[0];
    Ticks ticks = 0;
    const char* const known = std::strchr(kShiftedLetters, letter);
    if (known == nullptr || word.size() < 2) return shifted | kAnyShift;
    const int axis = AxisOf(letter);
    const auto bit = static_cast<uint16_t>(1u << (known - kShiftedLetters));
    const Ticks unit = axis >= 0 ? ticks_per_unit(axis) : kTicksPerMm;
    const bool is_read = ReadShift(word, unit, &letter, &ticks) && (ticks == 0 || axis >= 0);
    const bool is_followed = is_read && modal_.tool_point == 0 && !block_may_be_skipped_ && UnitProblem().empty();
    if (axis >= 0) ShiftFrame(axis, is_followed ? ticks : 0);
    shifted = static_cast<uint16_t>(is_followed || (is_read && ticks == 0) ? shifted & ~bit : shifted | bit);
  }
  return shifted;
}

bool Interpreter::NamesAxesOnly(const char* text, const Block& block) {
  if (!dialect_->has_equals) return false;
  const std::string rest = RestOf(text + block.problem_at, end_of_text_) + " ";
  for (size_t at = 0; at < rest.size();) {
    const size_t end = rest.find(' ', at), equals = rest.find('=', at);
    // "SUPA G0 Z=_Z_HOME D0": what the length is behind it, a D word must say.
    const bool is_length =
        rest[at] == 'D' && end > at + 1 &&
        std::all_of(rest.begin() + static_cast<ptrdiff_t>(at) + 1, rest.begin() + static_cast<ptrdiff_t>(end),
                    [](char c) { return c >= '0' && c <= '9'; });
    if (is_length) {
      modal_.uncertain |= kLengthGroup;
      at = end + 1;
      continue;
    }
    if (equals != at + 1 || AxisOf(rest[at]) < 0 || end < equals + 2) return false;
    for (size_t i = equals + 1; i < end; ++i) {
      const char c = rest[i];
      const bool is_name = (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '$' || c == '.';
      if (!is_name && std::strchr("+-*/", c) == nullptr) return false;
    }
    at = end + 1;
  }
  return true;
}

}  // namespace axiscal::nc
