#include "core/compare/side.h"

#include <cmath>

#include "absl/strings/numbers.h"

namespace axiscal::compare {
namespace {

absl::Status NoCombination(const std::string& text) {
  return absl::InvalidArgumentError(
      absl::StrCat("not_separable: '", text, "', expected a combination such as EX0C - 0.1 EB0C"));
}

}  // namespace

absl::StatusOr<std::vector<Share>> ParseCombination(const std::string& text) {
  std::vector<Share> shares;
  double sign = 1.0;
  for (size_t at = 0; at <= text.size();) {
    // The next " + " or " - ": names have blanks and signs of their own, as in EYC:tabulated(60,A -30), never both.
    const size_t plus = text.find(" + ", at), minus = text.find(" - ", at);
    const size_t end = std::min({plus, minus, text.size()});
    std::string word = text.substr(at, end - at);
    double coefficient = 1.0;
    const size_t blank = word.find(' ');
    if (!word.empty() && word[0] != 'E' && blank != std::string::npos) {
      if (!absl::SimpleAtod(word.substr(0, blank), &coefficient) || !std::isfinite(coefficient))
        return NoCombination(text);
      word = word.substr(blank + 1);
    }
    if (word.empty() || word[0] != 'E') return NoCombination(text);
    shares.push_back({word, sign * coefficient});
    if (end == text.size()) break;
    sign = end == plus ? 1.0 : -1.0;
    at = end + 3;
  }
  return shares;
}

void AddReport(const reports::CalibrationReport& report, Side* side) {
  const reports::Fitted& fitted = reports::FittedOf(report);
  side->has_report = true;
  side->not_separable = fitted.not_separable;
  for (const reports::Error& error : fitted.errors)
    if (!error.identifiable) side->without_number.push_back(error.name);
  if (std::isfinite(fitted.coverage_factor)) side->coverage_factor = fitted.coverage_factor;
  for (const reports::SessionFit& session : fitted.sessions) side->sessions.push_back(session.in.session);
}

}  // namespace axiscal::compare
