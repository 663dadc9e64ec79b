// Numbers of sentences.
#ifndef AXISCAL_CORE_REPORTS_DIGITS_H_
#define AXISCAL_CORE_REPORTS_DIGITS_H_

#include <string>

#include "absl/strings/str_format.h"

namespace axiscal::reports {

// To so many significant digits, those of a large number zeros: 1630, not 1.63e+03.
inline std::string Digits(double number, int digits) {
  const std::string text = absl::StrFormat("%.*g", digits, number);
  const bool is_large = text.find("e+") != std::string::npos;
  return is_large ? absl::StrFormat("%.0f", std::stod(text)) : text;
}

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_DIGITS_H_
