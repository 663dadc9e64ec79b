#include "core/nc/decimal.h"

#include <cmath>

#include "core/base/demand.h"

namespace axiscal::nc {

char* WriteLong(uint64_t mantissa, int decimals, bool point, char* to) {
  char digits[20];
  int count = 0;
  for (; mantissa > 0 || count <= decimals; mantissa /= 10) digits[count++] = static_cast<char>('0' + mantissa % 10);
  while (count > decimals) *to++ = digits[--count];
  if (decimals > 0 || point) *to++ = '.';
  while (count > 0) *to++ = digits[--count];
  return to;
}

std::string TicksText(Ticks ticks, Ticks unit, int least) {
  DEMAND(least >= 0 && least <= kMaxDecimals);
  const int decimals = ticks % GrainTicks(unit, least) == 0 ? least : kMaxDecimals;
  std::string text;
  AppendFixed(RoundToGrains(ticks, GrainTicks(unit, decimals)), decimals, false, true, &text);
  return text;
}

double ValueOf(const Decimal& number) {
  return static_cast<double>(number.mantissa) * std::pow(10.0, -static_cast<double>(number.decimals));
}

}  // namespace axiscal::nc
