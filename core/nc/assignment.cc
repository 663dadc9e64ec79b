#include "core/nc/assignment.h"

#include <algorithm>

#include "core/nc/char_class.h"

namespace axiscal::nc {
namespace {

// Of '#': what Fanuc, Haas and LinuxCNC all leave to programs. Every R of Sinumerik is.
bool IsOwnVariable(uint64_t number, const Dialect& dialect) {
  if (dialect.variable != '#') return true;
  return (number >= 1 && number <= 33) || (number >= 100 && number <= 199) || (number >= 500 && number <= 549);
}

// Where the variable ends, or nullptr.
const char* EndOfVariable(const char* at, const char* end, const Dialect& dialect) {
  if (*at == '_') {  // a name of Sinumerik's user variables
    while (at != end && (Class(*at) == kUpper || Class(*at) == kLower || Class(*at) == kDigit || *at == '_')) ++at;
    return at;
  }
  ++at;
  if (at != end && *at == '<' && dialect.variable == '#') {
    at = std::find(at, end, '>');
    return at == end ? nullptr : at + 1;
  }
  uint64_t number = 0;
  const char* const digits = at;
  at = ReadDigits(at, end, &number);
  return at == digits || at - digits > 9 || !IsOwnVariable(number, dialect) ? nullptr : at;
}

}  // namespace

const char* EndOfAssignment(const char* at, const char* end, bool is_first, const Dialect& dialect) {
  at = EndOfVariable(at, end, dialect);
  if (at == nullptr) return nullptr;
  const auto skip_blanks = [&] {
    while (at != end && Class(*at) == kBlank) ++at;
  };
  skip_blanks();
  if (at == end || *at != '=') return nullptr;
  if (dialect.has_assignment_blocks) return is_first ? end : nullptr;
  ++at;
  skip_blanks();
  if (at != end && (*at == '-' || *at == '+')) ++at;
  bool has_digit = false, has_point = false;
  for (; at != end && (Digit(*at) <= 9 || (*at == '.' && !has_point)); ++at) {
    has_point |= *at == '.';
    has_digit |= *at != '.';
  }
  skip_blanks();
  const bool ends = at == end || *at == dialect.variable || *at == '_' || *at == dialect.line_comment ||
                    (*at == '(' && dialect.has_parenthesis_comments);
  return has_digit && ends ? at : nullptr;
}

}  // namespace axiscal::nc
