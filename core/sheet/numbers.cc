#include "core/sheet/numbers.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "core/base/status.h"

namespace axiscal::sheet {
namespace {

// Without "-0" and "-0.00".
std::string Fixed(double number, int decimals) {
  std::string text = absl::StrFormat("%.*f", decimals, number);
  if (text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
}

// The power of ten at which the second digit of a positive number stands, once it is rounded to two: -2 of 0.153, of
// 0.0996 too, which is 0.10.
int PlaceOf(double uncertainty) {
  const int place = static_cast<int>(std::floor(std::log10(uncertainty))) - 1;
  return std::round(uncertainty / std::pow(10.0, place)) < 100.0 ? place : place + 1;
}

// Rounded to a power of ten.
std::string ToPlace(double number, int place, Language language) {
  constexpr int kMostDecimals = 9;
  if (place > 0) number = std::round(number / std::pow(10.0, place)) * std::pow(10.0, place);
  return base::NumberIn(language, Fixed(number, std::clamp(-place, 0, kMostDecimals)));
}

}  // namespace

std::string NumberText(double number, int digits, Language language) {
  if (!std::isfinite(number)) return kNone;
  const double size = std::abs(number);
  if (size != 0.0 && (size < 1e-4 || size >= 1e9))
    return base::NumberIn(language, absl::StrFormat("%.*g", digits, number));
  const int order = size == 0.0 ? 0 : static_cast<int>(std::floor(std::log10(size)));
  std::string text = Fixed(number, std::max(0, digits - 1 - order));
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return base::NumberIn(language, text);
}

std::string UncertaintyText(double uncertainty, Language language) {
  if (!std::isfinite(uncertainty)) return kNone;
  if (!(uncertainty > 0.0)) return NumberText(uncertainty, 2, language);
  return ToPlace(uncertainty, PlaceOf(uncertainty), language);
}

std::string ValueText(double value, double uncertainty, Language language) {
  if (!std::isfinite(value)) return kNone;
  if (!std::isfinite(uncertainty) || !(uncertainty > 0.0)) return NumberText(value, 4, language);
  return ToPlace(value, PlaceOf(uncertainty), language);
}

std::string IntervalText(double value, double low, double high, Language language) {
  const double half = 0.5 * (high - low);
  return absl::StrCat(ValueText(value, half, language), " [", ValueText(low, half, language), "; ",
                      ValueText(high, half, language), "]");
}

std::string CombinationText(const std::string& combination, Language language) {
  std::vector<std::string> words = absl::StrSplit(combination, ' ');
  for (std::string& word : words) {
    double factor = 0.0;
    if (absl::SimpleAtod(word, &factor)) word = base::NumberIn(language, word);
  }
  return absl::StrJoin(words, " ");
}

std::string TimeText(base::UtcTime time) {
  const auto day = std::chrono::floor<std::chrono::days>(time);
  const std::chrono::year_month_day date(day);
  const auto minutes = std::chrono::duration_cast<std::chrono::minutes>(time - day).count();
  return absl::StrFormat("%04d-%02d-%02d %02d:%02d UTC", static_cast<int>(date.year()),
                         static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), minutes / 60,
                         minutes % 60);
}

}  // namespace axiscal::sheet
