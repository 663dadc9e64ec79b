#include "client/cli/drift_limit.h"

#include "absl/strings/numbers.h"

namespace axiscal::cli {

absl::StatusOr<records::DriftLimit> ReadDriftLimit(const std::string& option, const std::string& text) {
  const size_t equals = text.rfind('='), dots = text.find("..", equals == std::string::npos ? 0 : equals);
  records::DriftLimit limit;
  if (equals == std::string::npos || equals == 0 || dots == std::string::npos ||
      !absl::SimpleAtod(text.substr(equals + 1, dots - equals - 1), &limit.low) ||
      !absl::SimpleAtod(text.substr(dots + 2), &limit.high) || !(limit.low < limit.high)) {
    return absl::InvalidArgumentError(option + " " + text +
                                      ": expected ERROR=LOW..HIGH in um or urad with LOW < HIGH, as EX0C=-20..20");
  }
  limit.symbol = text.substr(0, equals);
  return limit;
}

}  // namespace axiscal::cli
