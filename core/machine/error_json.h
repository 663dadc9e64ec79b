// Identified errors as JSON, the form in which users bring and get them (docs/formats.md, "Identified errors"):
//   {"EA0B": -101.2, "EX0C": 53.1,          constant errors, um and urad; terms of other shapes:
//    "terms": [{"symbol": "EBB", "shape": "harmonic", "variable": "B", "order": 45, "amplitude": 21.3,
//    "phase_deg": 12.0}]}
// Amplitudes in um or urad, per reference where the shape has one: linear per m or rad, quadratic at 250 mm or 1 rad,
// drift per h, thermal per K, lag per mm/s or rad/s. backlash is peak to peak. harmonic is amplitude cos(order q -
// phase), with period_mm instead of order on a linear axis. reversal has length_mm or length_deg, drift-exp tau_s.
// tabulated is a map with all its nodes in one entry: error_map_json.h. How well they are known stands in `covariance`:
// error_covariance.h.
#ifndef AXISCAL_CORE_MACHINE_ERROR_JSON_H_
#define AXISCAL_CORE_MACHINE_ERROR_JSON_H_

#include <string>
#include <vector>

#include "core/machine/error_model.h"
#include "core/machine/written_term.h"

namespace axiscal::machine {

struct WrittenCovariance;  // error_covariance.h

inline constexpr char kCovarianceKey[] = "covariance";

// INVALID_ARGUMENT naming the entry, its value and what was expected: no JSON object, a symbol or axis that the machine
// has not, a number that is not finite, an unknown shape or field, the same error twice.
absl::StatusOr<ErrorModel> ReadErrors(const std::string& text, const Machine& machine);
// Every digit of NamedErrors() is kept: ReadErrors gives the same model to rounding of the unit factors.
std::string WriteErrors(const ErrorModel& model, const Machine& machine);
// With how well its numbers are known; left out where that is of none, or of more than kMostCovarianceNumbers.
std::string WriteErrors(const ErrorModel& model, const Machine& machine, const WrittenCovariance& covariance);

// An error that is asked for, not how large it is: a constant's symbol ("EZ0T") or a term without its amplitude
// ({"symbol": "EBB", "shape": "harmonic", "order": 45}); of amplitude 0. INVALID_ARGUMENT as ReadErrors.
absl::StatusOr<ErrorModel> ReadAskedError(const std::string& text, const Machine& machine);
// The errors of an errors.json as ReadAskedError takes them. INVALID_ARGUMENT where it has none or is no errors.json.
absl::StatusOr<std::vector<std::string>> ListErrors(const std::string& text);

// One term without its amplitude: symbol, shape, variable and the shape's own parameters.
WrittenTerm Written(const ErrorTerm& term, const Machine& machine);
// Unit of the amplitude in files: "um", "urad", "um/m", "urad/K" ...
std::string AmplitudeUnit(const ErrorTerm& term, const Machine& machine);
// mm or rad per file unit: 1e-3 or 1e-6.
double AmplitudeFactor(const ErrorTerm& term);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_ERROR_JSON_H_
