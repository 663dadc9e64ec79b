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

// Identifies the case with the terms that acted (declared errors and effects), their amplitudes unknown, and compares
// all that the data determine, alone or as a combination, with the truth. The interval is estimate +- coverage_factor
// times the stated sigma. `keep_every` > 1 thins the fit sessions. False when identification refuses the case.
bool AddIdentified(const SimulatedCase& simulated, int keep_every, CoverageByKind* coverage);

// Closes the loop on the case and compares the effects that it named in exactly the terms that acted ("effect": the
// amplitude of a harmonic, the slope of a line). An effect counts only where it was found.
void AddClosed(const SimulatedCase& simulated, CoverageByKind* coverage);

std::string ToText(const CoverageByKind& coverage);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_COVERAGE_H_
