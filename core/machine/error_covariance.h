// How well the errors of an errors.json are known: its member `covariance` (docs/formats.md, "Identified errors").
//   "covariance": {"of": ["EA0B", "EBB:harmonic(45).cos", "EBB:harmonic(45).sin"],   numbers of the errors, by name
//                  "sigma": [0.4, 0.3, 0.3],                      standard uncertainties, units of the amplitudes
//                  "correlation": [[], [0.1], [0.0, -0.2]]}       of each number with those before it in `of`
// A number of an error: its amplitude, the cosine or sine part of one with a phase (amplitude cos(phase), amplitude
// sin(phase)), or its length, time constant or frequency. Errors that `of` does not name are taken for exact.
#ifndef AXISCAL_CORE_MACHINE_ERROR_COVARIANCE_H_
#define AXISCAL_CORE_MACHINE_ERROR_COVARIANCE_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/machine/error_model.h"

namespace axiscal::machine {

// A number of an error with its name and the unit of files: "EX0C", um; "EBB:harmonic(45).cos", urad;
// "EYX:reversal.length", mm. The name is that of the error where it has one number.
struct NamedNumber {
  std::string name, unit;
  double factor = 1.0;  // mm, rad or s per unit
};
// A free curve's amplitudes are numbered from 1: "EYX:curve.3". Of a model's term `term`, named as NamesOf().
NamedNumber NameNumber(const Machine& machine, const ErrorModel& model, int term, int basis, bool is_nonlinear);

// As in the file: units of the file, by name. Empty: nothing is known of how good the errors are.
struct WrittenCovariance {
  std::vector<std::string> of;
  std::vector<double> sigma;    // one each, of the unit that the name's error has in files
  Eigen::MatrixXd correlation;  // of.size() x of.size(); the lower triangle counts
};

// More numbers are neither written nor read: the matrix alone would fill a file (base::kMaxJsonBytes).
inline constexpr size_t kMostCovarianceNumbers = 600;

// One number of a model, and how all of them vary together.
struct ErrorCovariance {
  struct Number {
    int term = 0;   // of the model
    int basis = 0;  // which of its amplitudes
    bool is_nonlinear = false;
  };
  std::vector<Number> of;
  Eigen::MatrixXd root;  // of.size() rows; covariance = root root', in mm, rad and s

  bool is_empty() const { return of.empty(); }
};

// The errors and their covariance, empty where the text has none. INVALID_ARGUMENT as ReadErrors, and naming entry and
// rule for a covariance of another form, of numbers that the errors have not, or that is no covariance: correlations
// beyond 1, or that contradict each other.
struct KnownErrors {
  ErrorModel model;
  ErrorCovariance covariance;
};
absl::StatusOr<KnownErrors> ReadKnownErrors(const std::string& text, const Machine& machine);

// In mm, rad and s. INVALID_ARGUMENT where it names what is no number of the model, or its correlations contradict each
// other.
absl::StatusOr<ErrorCovariance> CovarianceOf(const WrittenCovariance& written, const Machine& machine,
                                             const ErrorModel& model);

// What of it is of the errors that errors.json holds of a model.
WrittenCovariance OfWritten(const WrittenCovariance& covariance, const Machine& machine, const ErrorModel& model);
// The member's text, a row of the matrix per line.
std::string CovarianceText(const WrittenCovariance& covariance);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_ERROR_COVARIANCE_H_
