#include "core/nc/decimal.h"

#include <cmath>

namespace axiscal::nc {
namespace {

// Pairs of digits, so that one division gives two characters.
struct DigitPairs {
  char text[200];
  constexpr DigitPairs() : text() {
    for (int i = 0; i < 100; ++i) {
      text[2 * i] = static_cast<char>('0' + i / 10);
      text[2 * i + 1] = static_cast<char>('0' + i % 10);
    }
  }
};
constexpr DigitPairs kPairs;

}  // namespace

double ValueOf(const Decimal& number) {
  return static_cast<double>(number.mantissa) * std::pow(10.0, -static_cast<double>(number.decimals));
}

char* WriteFixed(int64_t mantissa, int decimals, bool plus, bool point, char* to) {
  char buffer[kMaxFixedBytes];
  char* const end = buffer + sizeof(buffer);
  char* begin = end;
  const bool negative = mantissa < 0;
  uint64_t rest = negative ? uint64_t{0} - static_cast<uint64_t>(mantissa) : static_cast<uint64_t>(mantissa);
  int left = decimals;
  for (; left >= 2; left -= 2, rest /= 100) {
    begin -= 2;
    __builtin_memcpy(begin, kPairs.text + 2 * (rest % 100), 2);
  }
  if (left == 1) {
    *--begin = static_cast<char>('0' + rest % 10);
    rest /= 10;
  }
  if (decimals > 0 || point) *--begin = '.';
  for (; rest >= 100; rest /= 100) {
    begin -= 2;
    __builtin_memcpy(begin, kPairs.text + 2 * (rest % 100), 2);
  }
  if (rest >= 10) {
    begin -= 2;
    __builtin_memcpy(begin, kPairs.text + 2 * rest, 2);
  } else {
    *--begin = static_cast<char>('0' + rest);
  }
  if (negative) {
    *--begin = '-';
  } else if (plus) {
    *--begin = '+';
  }
  const size_t size = static_cast<size_t>(end - begin);
  __builtin_memcpy(to, begin, size);
  return to + size;
}

void AppendFixed(int64_t mantissa, int decimals, bool plus, bool point, std::string* text) {
  char buffer[kMaxFixedBytes];
  text->append(buffer, static_cast<size_t>(WriteFixed(mantissa, decimals, plus, point, buffer) - buffer));
}

}  // namespace axiscal::nc
