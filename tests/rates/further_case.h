// Instruments that no test of core/plan measures with: eccentricities of ball-bar runs, which are read off charts, and
// what the tool setter's own list plans. Each from what a log holds over `reduce` to numbers with intervals.
#ifndef AXISCAL_TESTS_RATES_FURTHER_CASE_H_
#define AXISCAL_TESTS_RATES_FURTHER_CASE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "tests/rates/planned_score.h"

namespace axiscal::rates {

struct FurtherCase {
  std::string instrument, test;  // test: what plans it, or how it is read
  // Draws truth and readings from `seed`, and counts the numbers that are told of them.
  absl::Status (*identify)(uint64_t seed, CoverageByKind* coverage);
  int most_intervals = 0;  // as many as are worth their time: a length curve is fitted in a second
};
const std::vector<FurtherCase>& FurtherCases();

// Measures and identifies until `intervals` numbers, or as many as the case asks for, are counted, or `most_fits` fits
// are done.
PlannedScore JudgeFurther(const FurtherCase& further, int intervals, int most_fits);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_FURTHER_CASE_H_
