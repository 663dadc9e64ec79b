// What the reports of an identification and of the loop have in common: what was fitted to sessions. Plain data in the
// terms and units of the JSON (docs/formats.md), so that a text that is read and written again stays the same. Lengths
// in um and angles in urad unless the name says otherwise; NaN stands for "no number" (null).
#ifndef AXISCAL_CORE_REPORTS_FITTED_H_
#define AXISCAL_CORE_REPORTS_FITTED_H_

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/base/json_like.h"
#include "core/reports/axis_range.h"
#include "core/reports/warning.h"

namespace axiscal::reports {

inline constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// Of the errors with each other, as far as it is known.
using Correlation = std::vector<std::vector<double>>;

struct Error {
  std::string symbol = {};                      // EX0C, EXX
  std::string name = {};                        // the symbol, or EXX:backlash, EBB:harmonic(45).cos
  double value = kNoNumber, sigma = kNoNumber;  // in `unit`; sigma: standard uncertainty
  std::string unit = {};                        // um, urad, um/m ...
  bool identifiable = true;                     // false: the sessions cannot tell, there is no number
};

// What the sessions determine although they cannot tell its members: "EX0B + EX0C".
struct Combination {
  std::string name = {};
  double value = kNoNumber, sigma = kNoNumber;  // in `unit`
  std::string unit = {};
};

struct SetupOffset {
  double value = kNoNumber, sigma = kNoNumber;  // in `unit`
  std::string unit = {};
};

// A session, and the set-up that it may share with others.
struct MeasuredIn {
  std::string session = {}, setup = {};
};

struct SessionFit {
  MeasuredIn in = {};
  int readings = 0;
  double rms_um = kNoNumber, max_um = kNoNumber;
  base::Named<SetupOffset> setup = {};  // "ball_x" ...
};

// A gate that a reading failed before anything was fitted.
struct Gate {
  std::string gate = {};  // "sphere", "repeat"
  double off_um = kNoNumber, limit_um = kNoNumber;
};

// A reading that was set aside.
struct Outlier {
  std::string session = {};
  int row = 0, column = 0;  // line of data from 1, reading in it from 0
  double residual_um = kNoNumber;
  std::optional<Gate> gate = {};  // without: it stands out of its series
};

// Residuals. What a report does not say of them is not set.
struct Statistics {
  double rms_um = kNoNumber, max_um = kNoNumber;
  std::optional<double> rms_without_outliers_um = {}, chi2_per_dof = {};
  std::optional<int> readings = {}, degrees_of_freedom = {};
};

struct SimulatedError {
  std::string name = {};
  double value = kNoNumber;  // the truth of the simulation, in `unit` as all of these
  double mean = kNoNumber, sigma = kNoNumber;
  double low = kNoNumber, high = kNoNumber;  // 95 %
  double linear_sigma = kNoNumber;           // by linear propagation
  std::string unit = {};
};

// What a stated fact (an expansion, a certified value, a thermometer) has in the sigmas: how far the errors move where
// it is off by one standard uncertainty, in the unit of each; all errors move together, facts are independent.
struct StatedFact {
  std::string of = {};
  base::Named<double> moves = {};
};

struct MonteCarlo {
  int runs = 0, failed = 0;
  uint64_t seed = 0;
  std::vector<SimulatedError> errors = {};
  Correlation correlation = {};
};

struct Fitted {
  std::vector<Error> errors = {};
  double coverage_factor = kNoNumber;           // value +- this many sigma is the 95 % interval
  std::vector<std::string> not_separable = {};  // directions that change no reading: "EX0B - EX0C"
  std::vector<Combination> determined = {};
  std::vector<AxisRange> measured = {};  // where the readings stand, of each axis; empty: not known
  std::vector<Warning> warnings = {};
  std::vector<Outlier> outliers = {};
  std::vector<SessionFit> sessions = {};
  std::vector<StatedFact> stated = {};
  std::string budget_json = {};  // error budget of the simulation and the weights, as it was given; empty without
  std::optional<MonteCarlo> monte_carlo = {};
};

}  // namespace axiscal::reports

#endif  // AXISCAL_CORE_REPORTS_FITTED_H_
