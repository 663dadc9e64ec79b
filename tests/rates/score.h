// What the loop made of a simulated case.
#ifndef AXISCAL_TESTS_RATES_SCORE_H_
#define AXISCAL_TESTS_RATES_SCORE_H_

#include <string>

#include "core/decide/close_loop.h"
#include "tests/rates/simulated_case.h"

namespace axiscal::rates {

struct Score {
  int effects = 0, named = 0;         // put in; found or in the class of a found one
  int first = 0;                      // of the named: reported under their own name
  int spurious = 0;                   // effects and unnamed structure that nothing put in explains
  bool is_structure_noticed = false;  // bumps, slips: verdict unexplained with the right variable and range
  int bad = 0, bad_listed = 0, good = 0, good_listed = 0;
  double sigma_ratio = 1.0;  // worst estimated over true sigma of all fit sessions
  double check_ratio = 1.0;  // check rms over that of a fit that knows what went in
  bool is_check_fitted = false;
  double seconds = 0.0;
  std::string text;  // what was put in and what was reported
};

// The same effect; a pitch's frequency is told to within half a period over the measured range (about 1 in 20 here).
bool IsSame(const machine::ErrorTerm& a, const machine::ErrorTerm& b);

Score Judge(const SimulatedCase& simulated, Kind kind, const decide::Options& options = {});

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_SCORE_H_
