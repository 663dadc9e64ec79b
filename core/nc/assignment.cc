#include "core/nc/assignment.h"

#include <algorithm>

#include "core/nc/char_class.h"

namespace axiscal::nc {
const char* EndOfAssignment(const char* at, const char* end, bool is_first, const Dialect& dialect,
                            const Variables* variables, Assigned* assigned) {
  at = EndOfVariable(at, end, dialect, &assigned->first);
  if (at == nullptr) return nullptr;
  assigned->second.reset();
  const auto skip_blanks = [&] {
    while (at != end && Class(*at) == kBlank) ++at;
  };
  skip_blanks();
  if (at == end || *at != '=') return nullptr;
  ++at;
  skip_blanks();
  const auto ends_at = [&](const char* last) {
    return last == end || *last == dialect.variable || *last == '_' || *last == dialect.line_comment ||
           (*last == '(' && dialect.has_parenthesis_comments);
  };
  static const Variables kNone;
  const char* value_end = at;
  assigned->second = EvaluateSum(&value_end, end, dialect, variables != nullptr ? *variables : kNone);
  const char* rest = value_end;
  while (rest != end && Class(*rest) == kBlank) ++rest;
  if (!ends_at(rest)) assigned->second.reset();
  if (dialect.has_assignment_blocks) return is_first ? end : nullptr;
  if (assigned->second && variables != nullptr) return rest;
  if (at != end && (*at == '-' || *at == '+')) ++at;
  bool has_digit = false, has_point = false;
  for (; at != end && (Digit(*at) <= 9 || (*at == '.' && !has_point)); ++at) {
    has_point |= *at == '.';
    has_digit |= *at != '.';
  }
  skip_blanks();
  return has_digit && ends_at(at) ? at : nullptr;
}

}  // namespace axiscal::nc
