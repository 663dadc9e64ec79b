#include "core/base/number_text.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_format.h"

namespace axiscal::base {

std::string NumberText(const std::optional<double>& number) {
  if (!number || !std::isfinite(*number)) return "-";
  const double size = std::abs(*number);
  const int decimals = size == 0 || size >= 1000 ? 1 : std::max(0, 3 - static_cast<int>(std::floor(std::log10(size))));
  return absl::StrFormat("%.*f", std::min(decimals, 6), *number);
}

}  // namespace axiscal::base
