// Whether the sessions that the loop proposes do what they are proposed for: an effect whose class holds others is
// simulated in them too, and the loop is closed again.
#ifndef AXISCAL_TESTS_RATES_NEXT_SESSION_H_
#define AXISCAL_TESTS_RATES_NEXT_SESSION_H_

#include <string>

#include "tests/rates/simulated_case.h"

namespace axiscal::rates {

struct NextScore {
  bool held_others = false;  // the class of the first report held the truth and others; names of one effect count once
  bool is_alone = false;     // with the proposed sessions it holds the truth alone
  double seconds = 0.0;      // of the first report
  std::string text;          // the truth, the class before, what was proposed, the class after
};

// The machine number `seed` of Kind::kOne.
NextScore JudgeNext(uint64_t seed);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_NEXT_SESSION_H_
