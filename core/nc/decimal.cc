#include "core/nc/decimal.h"

#include <bit>
#include <cmath>

namespace axiscal::nc {
namespace {

// Eight digits as characters, the lowest byte first.
inline void Store(uint64_t digits, char* to) {
  digits |= 0x3030303030303030;
  if constexpr (std::endian::native == std::endian::big) digits = __builtin_bswap64(digits);
  __builtin_memcpy(to, &digits, sizeof(digits));
}

// Up to eight digits, with a point among them or behind, all at once. `mantissa` < 10^8, `decimals` < 8.
inline char* WriteShort(uint32_t mantissa, int decimals, bool point, char* to) {
  // Four digits in each half, two in each quarter, one in each byte; the first digit is the lowest byte.
  const uint64_t fours = mantissa / 10000 | static_cast<uint64_t>(mantissa % 10000) << 32;
  const uint64_t hundreds = ((fours * 10486) >> 20) & 0x0000007F0000007F;
  const uint64_t twos = hundreds | (fours - 100 * hundreds) << 16;
  const uint64_t tens = ((twos * 103) >> 10) & 0x000F000F000F000F;
  const uint64_t digits = tens | (twos - 10 * tens) << 8;
  const int whole = 8 - decimals;
  // One digit stands before the point, also when it is zero.
  const int zeros = std::countr_zero(digits | uint64_t{1} << (8 * whole - 8)) / 8;
  Store(digits >> 8 * zeros, to);
  to += whole - zeros;
  if (decimals > 0 || point) *to++ = '.';
  if (decimals == 0) return to;
  Store(digits >> 8 * whole, to);
  return to + decimals;
}

}  // namespace

char* WriteFixed(int64_t mantissa, int decimals, bool plus, bool point, char* to) {
  const bool negative = mantissa < 0;
  uint64_t rest = negative ? uint64_t{0} - static_cast<uint64_t>(mantissa) : static_cast<uint64_t>(mantissa);
  if (negative || plus) *to++ = negative ? '-' : '+';
  if (rest < 100'000'000 && decimals < 8) return WriteShort(static_cast<uint32_t>(rest), decimals, point, to);
  char digits[20];
  int count = 0;
  for (; rest > 0 || count <= decimals; rest /= 10) digits[count++] = static_cast<char>('0' + rest % 10);
  while (count > decimals) *to++ = digits[--count];
  if (decimals > 0 || point) *to++ = '.';
  while (count > 0) *to++ = digits[--count];
  return to;
}

double ValueOf(const Decimal& number) {
  return static_cast<double>(number.mantissa) * std::pow(10.0, -static_cast<double>(number.decimals));
}

}  // namespace axiscal::nc
