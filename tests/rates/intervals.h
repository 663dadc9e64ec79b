// How often 95 % intervals hold the true value, counted by kind of number.
#ifndef AXISCAL_TESTS_RATES_INTERVALS_H_
#define AXISCAL_TESTS_RATES_INTERVALS_H_

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/identify/problem.h"
#include "core/identify/result.h"

namespace axiscal::rates {

struct Coverage {
  int intervals = 0, held = 0;
  int within_three = 0;  // of them whose estimate is within 3 sigma of the truth
  double squares = 0.0;  // of (estimate - truth) / sigma
  double share() const { return intervals > 0 ? static_cast<double>(held) / intervals : 0.0; }
};

// By kind of number: "length", "angle", "combination", "effect", "machine ..."; "all" counts each number once.
using CoverageByKind = std::map<std::string, Coverage>;

// One number with the half-width of its 95 % interval in standard uncertainties, counted under each of `names`, which
// differ.
void Count(double deviation, double sigma, double factor, const std::vector<std::string>& names,
           CoverageByKind* coverage);

// Counts all that a fit determines, errors alone and combinations, against `truth`, whose terms are the fit's. The
// interval is estimate +- coverage_factor times the stated sigma. Each number is counted under `names` and under the
// kind of its parameter, nullptr for a combination.
void AddResult(const identify::Result& result, const machine::ErrorModel& truth, const std::vector<std::string>& names,
               const std::function<std::string(const identify::Parameter*)>& kind, CoverageByKind* coverage);

std::string ToText(const CoverageByKind& coverage);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_INTERVALS_H_
