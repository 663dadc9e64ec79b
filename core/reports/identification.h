// The report of an identification (docs/formats.md, "Identification report").
#ifndef AXISCAL_CORE_REPORTS_IDENTIFICATION_H_
#define AXISCAL_CORE_REPORTS_IDENTIFICATION_H_

#include "core/base/status.h"
#include "core/reports/fitted.h"

namespace axiscal::reports {

// An error of an earlier identification that was held at its value.
struct HeldError {
  std::string symbol = {}, name = {};                     // as Error
  double value = kNoNumber, sigma = kNoNumber;  // in `unit`; sigma: NaN where none is known
  std::string unit = {};
};

struct Held {
  std::vector<HeldError> errors = {};
  Correlation correlation = {};           // a row per held error: with the fitted errors, then with the held ones
  std::vector<MeasuredIn> sessions = {};  // what they come from, as far as it is known
};

struct Identification {
  Fitted fitted = {};
  int rank = 0;
  double condition = kNoNumber;
  Statistics nominal = {};                // of the nominal machine, without set-ups
  std::optional<Statistics> before = {};  // with the set-ups fitted, no errors but the held ones
  Statistics fit = {};
  Correlation correlation = {};  // of the errors
  std::optional<Held> held = {};
  int iterations = 0;
  double noise_scale = 1.0;  // factor on every stated sigma
};

std::string ToJson(const Identification& report);
// INVALID_ARGUMENT naming line and column, or the member that is wrong.
absl::StatusOr<Identification> ReadIdentification(const std::string& text);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_IDENTIFICATION_H_
