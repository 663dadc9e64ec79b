// What a reader of numbers must know: a kind and the facts; here alone it is put into words.
#ifndef AXISCAL_CORE_REPORTS_WARNING_H_
#define AXISCAL_CORE_REPORTS_WARNING_H_

#include <string>
#include <variant>
#include <vector>

namespace axiscal::reports {

// Chi-square per degree of freedom above which a fit is poor: the readings scatter by more than twice their stated
// sigma.
inline constexpr double kPoorFitChi2PerDof = 4.0;

enum class WarningKind {
  kScatter,     // the readings scatter about the fit, beyond the stated sigma
  kSetAside,    // too many readings were
  kInterval,    // errors without one
  kNoNumber,    // errors without a number that the model holds at implausible sizes
  kHeld,        // two stages share what their sigmas take for independent
  kResolution,  // readings are rounded to more than they scatter by
  kOther,       // of a newer version; its text says what
};

// As it stands in a report.
struct Warning {
  WarningKind kind = WarningKind::kScatter;
  std::string text;
};

// The facts, a struct per kind.
struct Scatter {
  enum class About { kModel, kCutter };
  double times_sigma = 0.0;  // root of chi-square per degree of freedom
  About about = About::kModel;
};
struct SetAside {
  int set_aside = 0, readings = 0;
};
struct NoInterval {
  std::vector<std::string> errors;
};
struct NoNumber {
  struct Size {
    std::string error;
    double size = 0.0;  // in `unit`
    std::string unit;
  };
  std::vector<Size> errors;
};
// `sessions` whose readings gave both stages, else `offsets` ("run_out_x of set-up mount") that both know to one sigma.
struct SharedStages {
  std::vector<std::string> sessions, offsets;
};
struct CoarseReadings {
  std::string session;
  double step_um = 0.0, sigma_um = 0.0, rounding_sigma_um = 0.0;
  double most_sigmas = 0.0;  // a step of at most so many stated sigmas hides nothing
};
using WarningFacts = std::variant<Scatter, SetAside, NoInterval, NoNumber, SharedStages, CoarseReadings>;

Warning InWords(const WarningFacts& facts);

// The same scatter where a stored calibration is shown, with what to do about it: after the loop nothing, for it has
// looked already.
std::string PoorFitText(double chi2_per_dof, bool is_of_loop);

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_WARNING_H_
