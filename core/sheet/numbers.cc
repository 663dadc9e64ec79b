#include "core/sheet/numbers.h"

#include <algorithm>
#include <cmath>

#include "core/base/status.h"

namespace axiscal::sheet {
namespace {

// Without "-0" and "-0.00".
std::string Fixed(double number, int decimals) {
  std::string text = absl::StrFormat("%.*f", decimals, number);
  if (text[0] == '-' && text.find_first_not_of("-0.") == std::string::npos) text.erase(0, 1);
  return text;
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

std::string ValueText(double value, double sigma, Language language) {
  if (!std::isfinite(value)) return kNone;
  if (!std::isfinite(sigma) || !(sigma > 0.0)) return NumberText(value, 4, language);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 6);
  return base::NumberIn(language, Fixed(value, decimals));
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
