// One of two sets of errors that are compared: what a fit found, how well, and what it could not tell.
#ifndef AXISCAL_CORE_COMPARE_SIDE_H_
#define AXISCAL_CORE_COMPARE_SIDE_H_

#include <string>
#include <vector>

#include "core/machine/error_covariance.h"
#include "core/reports/calibration.h"

namespace axiscal::compare {

struct Side {
  std::string label;            // how the user named it
  machine::KnownErrors errors;  // numbers that a fit held at zero because nothing tells them are in it at zero
  // Directions that changed no reading of the fit, as its report names them: "EX0B - EX0C", coefficients in um and
  // urad.
  std::vector<std::string> not_separable;
  std::vector<std::string> without_number;  // names of numbers that the fit did not determine
  bool has_report = false;                  // false: what it could not tell is known from its covariance alone
  double coverage_factor = 1.959964;        // value +- this many sigma is the 95 % interval
  std::vector<std::string> sessions;        // what it was fitted to, as far as it is known
};

// Fills what a report says beside the errors.
void AddReport(const reports::CalibrationReport& report, Side* side);

// An errors.json, or a calibration as `identify --json` and `calibration show --json` print it ("model" and "report").
// INVALID_ARGUMENT naming the entry; also for a calibration of another machine, or a report without its errors.
absl::StatusOr<Side> ReadSide(const std::string& text, const machine::Machine& machine);

// A term of a combination as reports write it.
struct Share {
  std::string name;
  double coefficient = 0.0;  // of files' units
};
// "EX0C - 0.1 EB0C". INVALID_ARGUMENT where the text has another form.
absl::StatusOr<std::vector<Share>> ParseCombination(const std::string& text);

}  // namespace axiscal::compare

#endif  // AXISCAL_CORE_COMPARE_SIDE_H_
