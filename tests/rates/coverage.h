// How often the 95 % intervals that identification states hold the true value, counted on simulated machines.
#ifndef AXISCAL_TESTS_RATES_COVERAGE_H_
#define AXISCAL_TESTS_RATES_COVERAGE_H_

#include "tests/rates/intervals.h"
#include "tests/rates/simulated_case.h"

namespace axiscal::rates {

// Identifies the case with the terms that acted (declared errors and effects), their amplitudes unknown, and compares
// all that the data determine with the truth (AddResult). `keep_every` > 1 thins the fit sessions. False when
// identification refuses the case.
bool AddIdentified(const SimulatedCase& simulated, int keep_every, CoverageByKind* coverage);

// Closes the loop on the case and compares the effects that it named in exactly the terms that acted ("effect": the
// amplitude of a harmonic, the slope of a line). An effect counts only where it was found.
void AddClosed(const SimulatedCase& simulated, CoverageByKind* coverage);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_COVERAGE_H_
