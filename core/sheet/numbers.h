// Numbers and dates of a sheet as its reader's language writes them.
#ifndef AXISCAL_CORE_SHEET_NUMBERS_H_
#define AXISCAL_CORE_SHEET_NUMBERS_H_

#include <string>

#include "core/base/clock.h"
#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// What a cell without a number shows.
inline constexpr char kNone[] = "–";

// To `digits` significant digits, without an exponent from 1e-4 to 1e9; kNone where it is not finite.
std::string NumberText(double number, int digits, Language language);
// To the digits that two digits of `sigma` allow; without a sigma (not finite or not > 0) to four digits.
std::string ValueText(double value, double sigma, Language language);
// "2026-04-06 06:00 UTC", ISO 8601 in both languages.
std::string TimeText(base::UtcTime time);

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_NUMBERS_H_
