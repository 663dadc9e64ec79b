#include "core/nc/plain_number.h"

#include "core/nc/char_class.h"

namespace axiscal::nc {

std::optional<Decimal> PlainNumber(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  Decimal number;
  const bool is_negative = !text.empty() && text[0] == '-';
  number.has_plus = !text.empty() && text[0] == '+';
  if (is_negative || number.has_plus) text.remove_prefix(1);
  for (const char c : text) {
    if (c == '.' && !number.has_point) {
      number.has_point = true;
    } else if (Class(c) == kDigit && number.digits < 12) {
      number.mantissa = 10 * number.mantissa + (c - '0');
      ++number.digits;
      number.decimals = static_cast<int8_t>(number.decimals + number.has_point);
    } else {
      return std::nullopt;
    }
  }
  if (number.digits == 0 || number.digits - number.decimals > 5) return std::nullopt;
  if (is_negative) number.mantissa = -number.mantissa;
  return number;
}

std::optional<Ticks> PlainTicks(std::string_view text, Ticks unit) {
  const std::optional<Decimal> number = PlainNumber(text);
  return number ? ToTicks(*number, unit) : std::nullopt;
}

}  // namespace axiscal::nc
