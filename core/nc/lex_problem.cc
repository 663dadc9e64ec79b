// Why a block cannot be read as words, in words.
#include <cstring>

#include "absl/strings/str_cat.h"
#include "core/nc/char_class.h"
#include "core/nc/lexer.h"

namespace axiscal::nc {

bool IsBlockBehind(const char* at, const char* end) {
  bool is_acting = false;
  for (++at; at != end && *at != '(' && *at != ';';) {
    if (Class(*at) == kBlank) {
      ++at;
      continue;
    }
    const char letter = Capital(*at);
    if (letter < 'A' || letter > 'Z') return false;
    is_acting |= std::strchr("GMXYZABCUVWIJK", letter) != nullptr;
    ++at;
    while (at != end && (Class(*at) == kBlank || *at == '-' || *at == '+')) ++at;
    const char* const number = at;
    while (at != end && (Class(*at) == kDigit || *at == '.')) ++at;
    if (at == number) return false;
  }
  return is_acting;
}

std::string ToString(LexProblem problem, uint32_t at) {
  const std::string where = absl::StrCat(" at column ", at + 1);
  switch (problem) {
    case LexProblem::kNone:
      return "no problem";
    case LexProblem::kNestedComment:
      return "nested comment" + where + " (controllers differ on where it ends)";
    case LexProblem::kUnclosedComment:
      return "comment without end" + where;
    case LexProblem::kNoNumber:
      return "letter without a number" + where;
    case LexProblem::kNumberTooLong:
      return "number of more than 18 digits" + where;
    case LexProblem::kTooManyWords:
      return absl::StrCat("more than ", kMaxWords, " words", where);
    case LexProblem::kExpression:
      return "macro or expression" + where;
    case LexProblem::kStrayCharacter:
      return "unexpected character" + where;
    case LexProblem::kSemicolon:
      return "';' with words behind it" + where + " (a comment, or the end of the block: controllers differ)";
    case LexProblem::kSlashInside:
      return "'/' inside a block" + where;
  }
  return "unknown problem";
}

}  // namespace axiscal::nc
