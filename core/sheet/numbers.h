// Numbers and dates of a sheet as its reader's language writes them. All digits of a sheet are decided here.
#ifndef AXISCAL_CORE_SHEET_NUMBERS_H_
#define AXISCAL_CORE_SHEET_NUMBERS_H_

#include <string>

#include "core/base/clock.h"
#include "core/sheet/sheet.h"

namespace axiscal::sheet {

// What a cell without a number shows.
inline constexpr char kNone[] = "–";

// Of numbers without an uncertainty: to `digits` significant digits, without zeros at the end, without an exponent from
// 1e-4 to 1e9; kNone where it is not finite.
std::string NumberText(double number, int digits, Language language);
// An uncertainty to two significant digits, zeros too: "0.10", "13", "230" of 234 (JCGM 100:2008, 7.2.6); kNone where
// it is not finite.
std::string UncertaintyText(double uncertainty, Language language);
// Rounded to the place of the second digit of its `uncertainty`; without one (not finite or not > 0) to four digits.
std::string ValueText(double value, double uncertainty, Language language);
// "15 [0; 37]": to the place of the second digit of half the interval.
std::string IntervalText(double value, double low, double high, Language language);
// "0.425 EZ0J3 - EB0J4": the factors as the language writes them; names stay as they are.
std::string CombinationText(const std::string& combination, Language language);
// "2026-04-06 06:00 UTC", ISO 8601 in both languages.
std::string TimeText(base::UtcTime time);

}  // namespace axiscal::sheet

#endif  // AXISCAL_CORE_SHEET_NUMBERS_H_
