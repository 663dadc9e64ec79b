#include "client/cli/positive_number.h"

#include <cmath>

#include "absl/strings/numbers.h"
#include "core/session/text.h"

namespace axiscal::cli {

CLI::Validator PositiveNumber() {
  const auto check = [](const std::string& text) -> std::string {
    double number = 0.0;
    return absl::SimpleAtod(text, &number) && number > 0.0 && std::isfinite(number)
               ? ""
               : session::Quoted(text) + ", expected a number above 0";
  };
  return CLI::Validator(check, "POSITIVE");
}

}  // namespace axiscal::cli
