#include "core/nc/lexer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string_view>

#include "core/base/crc32c.h"
#include "core/nc/assignment.h"
#include "core/nc/char_class.h"
#include "core/nc/mark.h"
#include "core/nc/plain_words.h"

namespace axiscal::nc {
namespace {

class BlockLexer {
 public:
  BlockLexer(const char* text, size_t size, const Dialect& dialect, Block* block, const Variables* variables)
      : text_(text), end_(text + size), at_(text), dialect_(dialect), block_(*block), variables_(variables) {}

  void Run() {
    block_.length_difference = block_.radius_difference = Decimal();
    block_.has_odd_radius = false;
    SkipReturns();
    SkipBlanks();
    if (at_ != end_ && *at_ == '/') ReadBlockDelete();
    if (dialect_.has_bare_keywords) SkipBlockNumber();
    if (dialect_.has_angle_names) SkipProgramName();
    if (at_ != end_ && dialect_.line_comment2 != 0 && *at_ == dialect_.line_comment2) {
      block_.is_marked |= HasMark(at_ + 1, end_);
      return;
    }
    while (true) {
      at_ = ReadPlainWords(text_, at_, end_, &block_);
      SkipBlanks();
      if (at_ == end_) return;
      const uint8_t kind = Class(*at_);
      if (dialect_.variable != 0 && Capital(*at_) == dialect_.variable && SkipAssignment()) continue;
      if (kind == kUpper || kind == kLower) {
        if (MayBeKeyword() && ReadKeyword()) {
          if (takes_rest_) return;
        } else if (!ReadWord(kind == kLower)) {
          return;
        }
      } else if (*at_ == '_' && dialect_.has_equals && SkipAssignment()) {
        continue;
      } else if (*at_ == '(' && dialect_.has_parenthesis_comments) {
        if (!ReadComment()) return;
      } else if (*at_ == dialect_.line_comment && dialect_.line_comment != 0) {
        block_.is_marked |= HasMark(at_ + 1, end_);
        if (dialect_.has_semicolon_ends && IsBlockBehind(at_, end_)) Fail(LexProblem::kSemicolon, at_);
        return;
      } else if (*at_ == ',' && ReadKeyword()) {
        if (takes_rest_) return;
      } else {
        Fail(kind == kMacro ? LexProblem::kExpression
             : *at_ == '/'  ? LexProblem::kSlashInside
                            : LexProblem::kStrayCharacter,
             at_);
        return;
      }
    }
  }

 private:
  uint32_t Offset(const char* p) const { return static_cast<uint32_t>(p - text_); }

  bool Fail(LexProblem problem, const char* at) {
    block_.problem = problem;
    block_.problem_at = Offset(at);
    return false;
  }

  void SkipBlanks() {
    while (at_ != end_ && Class(*at_) == kBlank) ++at_;
  }

  // Punched tape ends its blocks with LF CR CR: the returns stand at the begin of the next line. NUL is its leader;
  // between words it is that of a file in UTF-16, which is none of ours.
  void SkipReturns() {
    while (at_ != end_ && (*at_ == '\r' || *at_ == 0)) ++at_;
    while (at_ != end_ && (end_[-1] == '\r' || end_[-1] == 0)) --end_;
  }

  void ReadBlockDelete() {
    block_.is_deletable = true;
    ++at_;
    if (at_ != end_ && Class(*at_) == kDigit) ++at_;  // "/2": one of several switches
  }

  // "<NAME>" or "O<NAME>": text, not words.
  void SkipProgramName() {
    const char* at = at_;
    if (at != end_ && (*at == 'O' || *at == 'o')) ++at;
    if (at == end_ || *at != '<') return;
    while (at != end_ && *at != '>') ++at;
    if (at != end_) at_ = at + 1;
  }

  // What assigns a number moves nothing; where the variable stands in a word, that word is refused.
  bool SkipAssignment() {
    Assigned assigned;
    const char* const end =
        EndOfAssignment(at_, end_, block_.word_count == 0, dialect_, variables_, &assigned);
    if (end == nullptr) return false;
    block_.has_assignment = true;
    block_.assigned.push_back(std::move(assigned));
    at_ = end;
    return true;
  }

  // Klartext numbers its blocks with a bare integer.
  void SkipBlockNumber() {
    SkipBlanks();
    while (at_ != end_ && Class(*at_) == kDigit) ++at_;
    SkipBlanks();
  }

  // Words are a letter and a number: a keyword goes on with another letter, or stands alone.
  bool MayBeKeyword() const {
    if ((dialect_.keyword_letters >> ((*at_ - 'A') & 31) & 1) == 0 || *at_ == ':') return false;
    const uint8_t next = at_ + 1 == end_ ? static_cast<uint8_t>(kBlank) : Class(at_[1]);
    // "A3=0.5" beside the axis word "A3".
    if (next == kDigit) return dialect_.has_equals && end_ - at_ > 2 && at_[2] == '=';
    return next == kUpper || next == kLower || (dialect_.has_bare_keywords && next == kBlank);
  }

  // Where `name` ends if it stands here as a whole, else nullptr.
  const char* EndOfKeyword(const char* name) const {
    const char* at = at_;
    char last = 0;
    for (; *name != 0; ++name) {
      last = *name;
      if (at == end_ || Capital(*at) != last) return nullptr;
      ++at;
      if (last != ' ') continue;
      while (at != end_ && Class(*at) == kBlank) ++at;
    }
    if (at == end_) return at;
    const uint8_t next = Class(*at);
    if (at == at_ + 1) return next == kBlank ? at : nullptr;
    if (last >= '0' && last <= '9') return next == kDigit ? nullptr : at;
    if (last == '+' || last == '-') return next == kDigit ? nullptr : at;
    return next == kUpper || next == kLower || *at == '_' ? nullptr : at;
  }

  bool ReadKeyword() {
    const char* longest = nullptr;
    int found = -1;
    for (size_t i = 0; i < dialect_.keywords.size(); ++i) {
      const char* const end = EndOfKeyword(dialect_.keywords[i].name);
      if (end != nullptr && (longest == nullptr || end > longest)) longest = end, found = static_cast<int>(i);
    }
    if (found < 0) return false;
    const Keyword& keyword = dialect_.keywords[static_cast<size_t>(found)];
    takes_rest_ = keyword.takes_rest;
    const bool is_corner =
        (keyword.meaning == Meaning::kCorner || keyword.meaning == Meaning::kTurns) && !keyword.takes_rest;
    const bool is_vector = keyword.meaning == Meaning::kToolVector || keyword.meaning == Meaning::kSurfaceNormal;
    const bool is_address = is_corner || is_vector || keyword.meaning == Meaning::kAddress ||
                            keyword.meaning == Meaning::kIncrementalAddress;
    if (is_address) {
      const char* const begin = at_;
      at_ = longest - 1;
      if (!ReadWord(Class(*begin) == kLower)) {
        takes_rest_ = true;  // the problem is set, the rest is not read
        return true;
      }
      Word& word = block_.words[block_.word_count - 1];
      word.letter = is_corner || is_vector ? char{0} : static_cast<char>(keyword.detail);
      word.keyword = static_cast<int16_t>(found);
      word.letter_at = Offset(begin);
      if (keyword.meaning == Meaning::kIncrementalAddress) word.distance = Distance::kIncremental;
      return true;
    }
    if (block_.word_count == kMaxWords) return Fail(LexProblem::kTooManyWords, at_);
    Word& word = block_.words[block_.word_count++];
    word = Word();
    word.keyword = static_cast<int16_t>(found);
    word.letter_at = word.number_at = Offset(at_);
    at_ = longest;
    word.end = Offset(at_);
    if (takes_rest_) ReadArgument(&word);
    return true;
  }

  // "TOOL CALL 5": the number of a keyword that takes the rest; digits = 0: it has none, has_plus: it has a text or a
  // variable, has_point: what stands behind it makes another length of it ("5.1", "5 X", "5 Z DL+Q1").
  void ReadArgument(Word* word) {
    SkipBlanks();
    const std::string_view rest(at_, static_cast<size_t>(end_ - at_));
    word->says_inch = EndsWith(rest, "INCH");
    word->says_mm = EndsWith(rest, "MM");
    word->number.has_plus = at_ != end_ && (*at_ == '"' || *at_ == 'Q' || *at_ == 'q');
    for (; at_ != end_ && Class(*at_) == kDigit && word->number.digits < 9; ++at_) {
      word->number.mantissa = word->number.mantissa * 10 + (*at_ - '0');
      ++word->number.digits;
    }
    word->number.has_point = IsOtherLength();
  }

  // Whether the last word is `name`, in capitals or not: names of programs may hold it too.
  static bool EndsWith(std::string_view text, std::string_view name) {
    while (!text.empty() && Class(text.back()) == kBlank) text.remove_suffix(1);
    if (text.size() <= name.size() || Class(text[text.size() - name.size() - 1]) != kBlank) return false;
    text.remove_prefix(text.size() - name.size());
    return std::equal(text.begin(), text.end(), name.begin(), [](char a, char b) { return Capital(a) == b; });
  }

  // Behind the number of TOOL CALL: an index, a tool axis other than Z, a difference of the length in parameters. One
  // in numbers is read.
  bool IsOtherLength() {
    const char* at = at_;
    if (at != end_ && *at == '.') return true;
    while (at != end_ && *at != ';') {
      const char* const begin = at;
      while (at != end_ && *at != ';' && Class(*at) != kBlank) ++at;
      const std::string_view word(begin, static_cast<size_t>(at - begin));
      if (word.size() == 1 && std::strchr("XYUVWxyuvw", word[0]) != nullptr) return true;
      if (word.size() > 2 && Capital(word[0]) == 'D' && Capital(word[1]) == 'L' &&
          !ReadDifference(word.substr(2), &block_.length_difference))
        return true;
      if (word.size() > 2 && Capital(word[0]) == 'D' && Capital(word[1]) == 'R' &&
          !ReadDifference(word.substr(2), &block_.radius_difference))
        block_.has_odd_radius = true;
      while (at != end_ && Class(*at) == kBlank) ++at;
    }
    return false;
  }

  static bool ReadDifference(std::string_view text, Decimal* number) {
    *number = Decimal();
    const bool is_negative = text[0] == '-';
    if (is_negative || text[0] == '+') text.remove_prefix(1);
    for (const char c : text) {
      if (c == '.' && !number->has_point) {
        number->has_point = true;
      } else if (Class(c) == kDigit && number->digits < 12) {
        number->mantissa = 10 * number->mantissa + (c - '0');
        ++number->digits;
        number->decimals = static_cast<int8_t>(number->decimals + number->has_point);
      } else {
        return false;
      }
    }
    if (is_negative) number->mantissa = -number->mantissa;
    return number->digits > 0;
  }

  bool ReadComment() {
    const char* const open = at_++;
    const char* const inside = at_;
    while (at_ != end_ && *at_ != ')' && *at_ != '(') ++at_;
    if (at_ == end_) return Fail(LexProblem::kUnclosedComment, open);
    if (*at_ == '(') return Fail(LexProblem::kNestedComment, at_);
    block_.is_marked |= HasMark(inside, at_);
    ++at_;
    return true;
  }

  bool ReadWord(bool is_lower) {
    if (block_.word_count == kMaxWords) return Fail(LexProblem::kTooManyWords, at_);
    Word& word = block_.words[block_.word_count];
    word.letter = is_lower ? static_cast<char>(*at_ - 'a' + 'A') : *at_ == ':' ? 'O' : *at_;
    word.is_lower = is_lower;
    word.letter_at = Offset(at_);
    word.distance = Distance::kModal;
    const char* const letter = at_++;
    SkipBlanks();
    bool is_enclosed = false;
    if (dialect_.has_equals && at_ != end_ && *at_ == '=') {
      ++at_;
      SkipBlanks();
      is_enclosed = ReadDistance(&word);
    }
    word.number_at = Offset(at_);
    if (dialect_.has_equals && word.letter == 'T' && at_ != end_ && *at_ == '"') {
      if (!SkipName(letter, &word)) return false;
    } else if (!ReadNumber(letter, &word)) {
      return false;
    }
    // "S2=8000 M2=3": of the second spindle.
    if (dialect_.has_equals && at_ != end_ && *at_ == '=' && (word.letter == 'S' || word.letter == 'M')) {
      ++at_;
      SkipBlanks();
      word.number_at = Offset(at_);
      if (!ReadNumber(letter, &word)) return false;
    }
    if (is_enclosed) {
      SkipBlanks();
      if (at_ == end_ || *at_ != ')') return Fail(LexProblem::kExpression, letter);
      ++at_;
    }
    ++block_.word_count;
    return true;
  }

  // "IC(" of X=IC(5). False and nothing read where there is none.
  bool ReadDistance(Word* word) {
    for (const DistanceName& known : dialect_.distance_names) {
      const char* at = at_;
      for (const char* name = known.name; *name != 0 && at != end_ && Capital(*at) == *name; ++name) ++at;
      if (static_cast<size_t>(at - at_) != std::strlen(known.name)) continue;
      while (at != end_ && Class(*at) == kBlank) ++at;
      if (at == end_ || *at != '(') continue;
      at_ = at + 1;
      SkipBlanks();
      word->distance = known.distance;
      return true;
    }
    return false;
  }

  // T="MILL_D10": a number below zero stands for the name.
  bool SkipName(const char* letter, Word* word) {
    const char* const end = std::find(at_ + 1, end_, '"');
    if (end == end_) return Fail(LexProblem::kNoNumber, letter);
    word->number = Decimal();
    word->number.mantissa = -1 - static_cast<int64_t>(base::Crc32c(0, at_, static_cast<size_t>(end - at_)));
    at_ = end + 1;
    word->end = Offset(at_);
    return true;
  }

  bool ReadNumber(const char* letter, Word* word) {
    const char* at = at_;
    const char* const end = end_;
    bool negative = false, plus = false, point = false;
    if (at != end && (*at == '-' || *at == '+')) {
      negative = *at == '-';
      plus = !negative;
      ++at;
    }
    // Nearly every number is digits, a point and digits, at most 18 of them and without blanks.
    const char* const first = at;
    uint64_t mantissa = 0;
    at = ReadDigits(at, end, &mantissa);
    int digits = static_cast<int>(std::min<ptrdiff_t>(at - first, 100)), decimals = 0;
    if (at != end && *at == '.') {
      point = true;
      const char* const fraction = ++at;
      at = ReadDigits(at, end, &mantissa);
      decimals = static_cast<int>(std::min<ptrdiff_t>(at - fraction, 100));
      digits += decimals;
    }
    const char* last = at;
    if (at != end && Class(*at) == kBlank && digits <= 18) {
      // Blanks may stand inside the number.
      for (; at != end; ++at) {
        const unsigned digit = Digit(*at);
        if (digit <= 9) {
          if (++digits > 18) break;
          mantissa = mantissa * 10 + digit;
          decimals += point;
        } else if (*at == '.' && !point) {
          point = true;
        } else if (Class(*at) == kBlank) {
          continue;
        } else {
          break;
        }
        last = at + 1;
      }
    }
    if (digits > 18) return Fail(LexProblem::kNumberTooLong, letter);
    if (digits == 0) {
      at_ = at;
      if (ReadExpression(letter, negative, word)) return true;
      return Fail(at != end && Class(*at) == kMacro ? LexProblem::kExpression : LexProblem::kNoNumber, letter);
    }
    at_ = last;
    word->end = Offset(last);
    Decimal& number = word->number;
    number.has_plus = plus;
    number.has_point = point;
    number.mantissa = negative ? -static_cast<int64_t>(mantissa) : static_cast<int64_t>(mantissa);
    number.digits = static_cast<int8_t>(digits);
    number.decimals = static_cast<int8_t>(decimals);
    return true;
  }

  // "X#100", "X=R1+2", "X-Q1" behind the sign: the value in place of a number. What selects or counts is a whole one.
  bool ReadExpression(const char* letter, bool is_negative, Word* word) {
    constexpr int kMostDecimals = 5;
    if (variables_ == nullptr || std::strchr("GMNO", word->letter) != nullptr) return false;
    const bool may_begin = at_ != end_ && (Capital(*at_) == dialect_.variable || *at_ == '[' || *at_ == '_' ||
                                           (*at_ == '(' && dialect_.has_equals));
    // "RX" is no sum in Klartext; in Sinumerik an expression stands behind '='.
    if (!may_begin || (dialect_.has_equals && std::find(letter, at_, '=') == at_)) return false;
    const char* last = at_;
    const std::optional<double> value = Evaluate(&last, end_, dialect_, *variables_);
    if (!value) return false;
    const char* next = last;
    while (next != end_ && Class(*next) == kBlank) ++next;
    if (next != end_ && std::strchr("+-*/#[]=", *next) != nullptr) return false;
    Decimal& number = word->number;
    number = Decimal();
    number.mantissa = std::llround((is_negative ? -*value : *value) * static_cast<double>(kPowersOfTen[kMostDecimals]));
    number.decimals = kMostDecimals;
    for (; number.decimals > 0 && number.mantissa % 10 == 0; --number.decimals) number.mantissa /= 10;
    const bool counts = std::strchr("PHDTLQ", word->letter) != nullptr && number.decimals == 0;
    number.has_point = !counts;
    number.has_plus = dialect_.writes_plus;
    number.digits = static_cast<int8_t>(number.decimals + 1);
    for (int64_t whole = std::abs(number.mantissa) / kPowersOfTen[number.decimals]; whole >= 10; whole /= 10)
      ++number.digits;
    block_.has_expression = true;
    at_ = last;
    word->end = Offset(last);
    return true;
  }

  const char* const text_;
  const char* end_;
  const char* at_;
  const Dialect& dialect_;
  Block& block_;
  const Variables* const variables_;
  bool takes_rest_ = false;
};

// Apart from Lex, whose common case needs little room.
[[gnu::noinline]] void LexAnyBlock(const char* text, size_t size, const Dialect& dialect, const Variables* variables,
                                   Block* block) {
  block->assigned.clear();
  block->has_expression = false;
  BlockLexer(text, size, dialect, block, variables).Run();
  // Whether the word has the value of before or behind the assignment, controls differ.
  if (!block->has_expression || block->assigned.empty() || block->problem != LexProblem::kNone) return;
  block->problem = LexProblem::kExpression;
  block->problem_at = 0;
}

// "CR X+20 Y+10 R+20 DR- R0": the first R is the radius, and called Q from here on.
void NameRadius(const Dialect& dialect, Block* block) {
  const Word* const first = block->begin();
  if (block->word_count == 0 || first->letter != 0) return;
  const Keyword& keyword = dialect.keywords[static_cast<size_t>(first->keyword)];
  if (keyword.meaning != Meaning::kArc || keyword.detail != kArcWithRadius) return;
  const auto end = block->words.begin() + block->word_count;
  const auto radius = std::find_if(block->words.begin(), end, [](const Word& word) { return word.letter == 'R'; });
  if (radius != end) radius->letter = 'Q';
}

}  // namespace

void Lex(const char* text, size_t size, const Dialect& dialect, Block* block, const Variables* variables) {
  block->word_count = 0;
  block->is_deletable = block->is_marked = block->has_assignment = false;
  block->problem = LexProblem::kNone;
  block->problem_at = 0;
  // Nearly every block is plain words from its first byte to its last.
  const bool begins_with_word = size > 0 && *text >= 'A' && *text <= 'Z' && *text != 'O' && !dialect.has_bare_keywords;
  if (begins_with_word && ReadPlainBlock(text, text + size, block)) return;
  block->word_count = block->layout_count = 0;  // the words' other fields are no longer those of the layouts
  LexAnyBlock(text, size, dialect, variables, block);
  if (dialect.has_poles) NameRadius(dialect, block);
}

}  // namespace axiscal::nc
