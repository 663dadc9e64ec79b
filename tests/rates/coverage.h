// How often the 95 % intervals that identification states hold the true value, counted on simulated machines.
#ifndef AXISCAL_TESTS_RATES_COVERAGE_H_
#define AXISCAL_TESTS_RATES_COVERAGE_H_

#include <map>
#include <string>

#include "tests/rates/simulated_case.h"

namespace axiscal::rates {

struct Coverage {
  int intervals = 0, held = 0;
  double squares = 0.0;  // of (estimate - truth) / sigma
  double share() const { return intervals > 0 ? static_cast<double>(held) / intervals : 0.0; }
};

// By kind of number: "length", "angle", "combination", "effect", "machine ..."; "all" counts each number once.
using CoverageByKind = std::map<std::string, Coverage>;

// The case identified with the terms that acted (declared errors and effects), their amplitudes unknown: what the data
// determines, alone or as a combination, against what went in. The interval is estimate +- coverage_factor stated
// sigma. `keep_every` > 1 thins the fit sessions. False when identification refuses the case.
bool AddIdentified(const SimulatedCase& simulated, int keep_every, CoverageByKind* coverage);

// The case closed by the loop: effects that it named in the very terms that acted ("effect"; the amplitude of a
// harmonic, the slope of a line). A selected effect counts only where it was selected, so its interval is conditional.
void AddClosed(const SimulatedCase& simulated, CoverageByKind* coverage);

std::string ToText(const CoverageByKind& coverage);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_COVERAGE_H_
