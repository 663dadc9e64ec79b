// How well what was planned, measured and identified agrees with the truth, and with each other.
#ifndef AXISCAL_TESTS_RATES_PLANNED_SCORE_H_
#define AXISCAL_TESTS_RATES_PLANNED_SCORE_H_

#include <map>
#include <string>
#include <vector>

#include "tests/rates/intervals.h"
#include "tests/rates/planned_case.h"

namespace axiscal::rates {

struct PlannedScore {
  int cases = 0, fits = 0;
  std::vector<std::string> refused;  // session and reason of each fit that gave no result
  CoverageByKind coverage;           // "all", "together" and "alone" (sessions of a test), "instrument ..."
};

// Identifies the cases of a test in turn, with other errors, set-ups and noise each time, round by round with the
// motions of all axes and with the declared constants alone, until each was identified and `intervals` numbers are
// counted, or `most_fits` fits are done.
PlannedScore JudgePlanned(const std::string& test, int intervals, int most_fits);

// Several tests of one machine with the same errors, as laboratories compare what they measured of one artefact: for
// every error that two tests tell, E_n = (x1 - x2) / (k sqrt(sigma1^2 + sigma2^2)), within 1 in 95 of 100 cases.
struct Compared {
  int pairs = 0, agree = 0;
};
// By machine. `machines`: so many draws of the errors of each structure.
std::map<std::string, Compared> CompareTests(const std::vector<std::string>& tests, int machines);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_PLANNED_SCORE_H_
