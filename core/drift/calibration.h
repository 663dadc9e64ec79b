// What the detector of drift is given: calibrations of one machine in the order of time, and marks of people.
#ifndef AXISCAL_CORE_DRIFT_CALIBRATION_H_
#define AXISCAL_CORE_DRIFT_CALIBRATION_H_

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/status.h"

namespace axiscal::drift {

// Never renumber: written into states.
enum class Unit { kUm = 0, kUrad = 1 };
const char* Text(Unit unit);  // "um", "urad"

// More errors of one machine are not followed: the work of a calibration goes with the cube of their number.
inline constexpr int kMostErrors = 64;

struct Value {
  std::string symbol;  // "EX0C", or with its shape "EBB:harmonic:45"
  Unit unit = Unit::kUm;
  double value = 0.0;  // actual - nominal, in `unit`
};

// One point of a machine's history. An error that the calibration could not tell at all is not among `values`; a
// combination of errors that it could not tell has a huge variance.
struct Calibration {
  base::UtcTime at;
  std::vector<Value> values;
  Eigen::MatrixXd covariance;                 // row and column i: values[i]; products of their units
  std::optional<double> temperature_celsius;  // of the machine or shop, where it was recorded
};

// The covariance of values whose correlations are not known: sigma^2 on the diagonal.
Eigen::MatrixXd Uncorrelated(const std::vector<double>& sigmas);

// What a person says has happened. It ends what was: errors may stand elsewhere afterwards, and that is no finding.
// Never renumber: written into states.
enum class MarkKind { kCollision = 0, kService = 1, kRefixturing = 2 };
struct Mark {
  base::UtcTime at;
  MarkKind kind = MarkKind::kCollision;
  std::vector<std::string> symbols;  // the errors that it can have moved; empty: all
};

// The form of a calibration by itself. INVALID_ARGUMENT names the value and the rule: no values or more than
// kMostErrors, a symbol that is empty, longer than 200 bytes or there twice, a value that is not finite or beyond 1e9,
// a covariance of another size, not symmetric, with a sigma outside 1e-6 .. 1e9, or that is none (a negative
// eigenvalue), a temperature outside -60..150 degrees C.
absl::Status Check(const Calibration& calibration);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_CALIBRATION_H_
