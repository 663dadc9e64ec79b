// One form of a line in a controller's log: literal text and fields in braces, "X{X_mm} Y{Y_mm} Z{Z_mm}".
//   {NAME}   a number, or for a name of `text_fields` a text up to the next literal
//   {*}      anything, passed over; it, too, ends where the next literal begins, or where nothing but a blank parts it
//            from the next field, at the next blank: "{*} {L_mm}"
// Blanks of the pattern stand for any number of blanks, none included. Controllers pad numbers: blanks may stand before
// a number and between its sign and its digits ("X-  390.0000"). A number may have an exponent ("1.5e-06") where no
// letter E of the pattern can follow it. Where every field is a number with a tag of letters of its own before it, the
// fields may come in any order.
#ifndef AXISCAL_CORE_LOGS_LINE_PATTERN_H_
#define AXISCAL_CORE_LOGS_LINE_PATTERN_H_

#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.h"

namespace axiscal::logs {

struct Piece {
  std::string literal;  // before the field; blanks at its ends are dropped
  std::string field;    // "X_mm", "*", or empty behind the last field
  bool is_text = false;
  bool ends_at_blank = false;  // of a text: a blank alone parts it from the next field
  int words = 1;               // of such a text: how many, with blanks between them
};

struct LinePattern {
  std::string text;  // as written
  std::vector<Piece> pieces;
  bool is_any_order = false;
  bool may_have_exponents = true;
  char decimal = '.';  // before the decimals of a number: '.' or ','
};

// INVALID_ARGUMENT: an unclosed or empty brace, a field named twice, two fields of text with nothing between them.
absl::StatusOr<LinePattern> ParsePattern(const std::string& text);

// Makes a text of the number `field`, if there is such a field: of so many words where a blank parts it from the next.
void MakeText(const std::string& field, int words, LinePattern* pattern);

bool HasField(const LinePattern& pattern, const std::string& field);

struct FieldValue {
  double number = 0.0;
  std::string text;
  int decimals = 0;  // digits behind the point, of a number
};

struct Match {
  bool is_match = false;
  std::vector<FieldValue> fields;  // per piece of the pattern
  // Where it failed, from 0, what stands there and what was expected. The line's own length: it ends too early.
  size_t column = 0;
  std::string expected;
};

Match MatchLine(const LinePattern& pattern, std::string_view line);

}  // namespace axiscal::logs

#endif  // AXISCAL_CORE_LOGS_LINE_PATTERN_H_
