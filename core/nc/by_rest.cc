// Modes that the text behind their keyword switches: frames of Sinumerik, cycles of Klartext that turn coordinates.
#include <algorithm>
#include <cstring>
#include <string>

#include "core/nc/char_class.h"
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

// "X+0 Y+5" of CYCL DEF 7: what is shifted then.
uint16_t Shifted(const std::string& words, uint16_t shifted) {
  for (size_t at = 0; at < words.size();) {
    const size_t end = std::min(words.find(' ', at), words.size());
    const std::string word = words.substr(at, end - at);
    at = end + 1;
    const char* const letter = std::strchr(kShiftedLetters, word[0]);
    if (letter == nullptr || word.size() < 2) return shifted | kAnyShift;
    const auto bit = static_cast<uint16_t>(1u << (letter - kShiftedLetters));
    shifted = static_cast<uint16_t>(IsZero(word.substr(1)) ? shifted & ~bit : shifted | bit);
  }
  return shifted;
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
  bool ends = rest.empty() || (mode == kSwivel && rest == "()");
  if (dialect_->has_poles) {
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
    // "CYCL DEF 7.1", "CYCL DEF 10.1 ROT": nothing is stated. Whether that ends what was stated before is not known.
    const bool is_empty = is_part && (stated.empty() || (mode == kRotation && stated == "ROT"));
    if (is_empty && (mode == kDatumShift || mode == kRotation) && (modal_.blockers & mode) == 0) return;
    if (mode == kDatumShift) {
      modal_.shifted_axes = is_part && !stated.empty() ? Shifted(stated, modal_.shifted_axes)
                                                       : static_cast<uint16_t>(modal_.shifted_axes | kAnyShift);
      ends = modal_.shifted_axes == 0;
    }
  }
  if (ends) {
    if (mode == kModalMacro && (modal_.blockers & mode) != 0) MayHaveChanged(kCalledGroups);  // by what it called
    if (mode == kModalMacro) modal_.macro_depth = 0;
    if (mode == kModalMacro) modal_.calls_at_moves = false;
    if (mode == kMirror) modal_.mirrored_axes = 0;
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
  modal_.calls_at_moves = false;
  modal_.blockers |= mode;
  if (mode == kMirror) modal_.mirrored_axes = kAllAxes;
  if (mode == kModalMacro) {
    if (modal_.macro_depth < 255) ++modal_.macro_depth;
    NoteCall();
    request->is_call = true;
  }
  request->Refuse(absl::StrCat(name, " (", request->by_rest->text, ")"));
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
