// Numbers as programs write them, and axis positions as exact integers.
//
// A position is counted in ticks of 1e-10 mm (or deg): one inch word with nine decimals and one mm word with ten are
// whole ticks, so that sums of G91 words never round. Range +-9e8 mm.
#ifndef AXISCAL_CORE_NC_DECIMAL_H_
#define AXISCAL_CORE_NC_DECIMAL_H_

#include <bit>
#include <cstdint>
#include <optional>
#include <string>

namespace axiscal::nc {

// mantissa * 10^-decimals, as written.
struct Decimal {
  int64_t mantissa = 0;
  int8_t decimals = 0;
  int8_t digits = 0;  // written, leading zeros included
  bool has_point = false;
  bool has_plus = false;
};

using Ticks = int64_t;
inline constexpr double kTicksPerUnit = 1e10;  // per mm or deg
inline constexpr Ticks kTicksPerMm = 10'000'000'000;
inline constexpr Ticks kTicksPerInch = 254'000'000'000;
inline constexpr int kMaxDecimals = 9;

inline constexpr int64_t kPowersOfTen[] = {1,       10,       100,       1000,       10000,      100000,
                                           1000000, 10000000, 100000000, 1000000000, 10000000000};

// Ticks of the last decimal of a word. 0 <= decimals <= kMaxDecimals; ticks_per_unit is one of the two above.
inline Ticks GrainTicks(Ticks ticks_per_unit, int decimals) {
  if (ticks_per_unit == kTicksPerInch) return 254 * kPowersOfTen[kMaxDecimals - decimals];
  return kPowersOfTen[kMaxDecimals + 1 - decimals];
}

// The nearest tick of a value in ticks, within +-2^52; several times as fast as llround.
inline Ticks NearestTick(double ticks) { return static_cast<Ticks>(ticks + (ticks >= 0 ? 0.5 : -0.5)); }

// False when the number has more than nine decimals or is beyond the range.
inline bool ToTicks(const Decimal& number, Ticks ticks_per_unit, Ticks* ticks) {
  constexpr Ticks kRange = 9'000'000'000'000'000'000;
  if (number.decimals > kMaxDecimals) return false;
  if (__builtin_mul_overflow(number.mantissa, GrainTicks(ticks_per_unit, number.decimals), ticks)) return false;
  return *ticks <= kRange && *ticks >= -kRange;
}
inline std::optional<Ticks> ToTicks(const Decimal& number, Ticks ticks_per_unit) {
  Ticks ticks = 0;
  return ToTicks(number, ticks_per_unit, &ticks) ? std::optional<Ticks>(ticks) : std::nullopt;
}

double ValueOf(const Decimal& number);

// The whole number of grains nearest to `ticks`, halves away from zero.
inline int64_t RoundToGrains(Ticks ticks, Ticks grain_ticks) {
  constexpr Ticks kExactInDouble = Ticks{1} << 53;
  if (ticks < kExactInDouble && ticks > -kExactInDouble) {
    // Several times as fast as a division of integers, and exact for multiples of the grain.
    const double grains = static_cast<double>(ticks) / static_cast<double>(grain_ticks);
    return static_cast<int64_t>(grains + (grains >= 0 ? 0.5 : -0.5));
  }
  const int64_t half = grain_ticks / 2;
  return ticks >= 0 ? (ticks + half) / grain_ticks : (ticks - half) / grain_ticks;
}

// Eight digits as characters, the lowest byte first.
inline void StoreDigits(uint64_t digits, char* to) {
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
  StoreDigits(digits >> 8 * zeros, to);
  to += whole - zeros;
  if (decimals > 0 || point) *to++ = '.';
  if (decimals == 0) return to;
  StoreDigits(digits >> 8 * whole, to);
  return to + decimals;
}

// Any number, digit by digit.
char* WriteLong(uint64_t mantissa, int decimals, bool point, char* to);

// Appends units of 10^-decimals in fixed notation: "-12.0500", "+0.5000" with `plus`, never "-0.0000". No decimals:
// "12", or "12." with `point`.
// WriteFixed returns the end of what it wrote; it may touch kMaxFixedBytes.
inline constexpr int kMaxFixedBytes = 32;
inline char* WriteFixed(int64_t mantissa, int decimals, bool plus, bool point, char* to) {
  const bool is_negative = mantissa < 0;
  const uint64_t size = is_negative ? uint64_t{0} - static_cast<uint64_t>(mantissa) : static_cast<uint64_t>(mantissa);
  if (is_negative || plus) *to++ = is_negative ? '-' : '+';
  if (size < 100'000'000 && decimals < 8) return WriteShort(static_cast<uint32_t>(size), decimals, point, to);
  return WriteLong(size, decimals, point, to);
}
// Writes to a string or an OutBuffer.
template <typename Text>
void AppendFixed(int64_t mantissa, int decimals, bool plus, bool point, Text* text) {
  char buffer[kMaxFixedBytes];
  text->append(buffer, static_cast<size_t>(WriteFixed(mantissa, decimals, plus, point, buffer) - buffer));
}

// A length or angle in fixed notation, of `least` decimals where these say it exactly, else of kMaxDecimals.
std::string TicksText(Ticks ticks, Ticks unit, int least);

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_DECIMAL_H_
