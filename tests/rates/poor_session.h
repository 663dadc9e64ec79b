// Sessions that barely tell what they are asked: few rotary positions, one touch a face, artefacts mounted askew, more
// errors asked for than show. What identification then gives a number must hold.
#ifndef AXISCAL_TESTS_RATES_POOR_SESSION_H_
#define AXISCAL_TESTS_RATES_POOR_SESSION_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/machine/error_model.h"
#include "core/session/session.h"

namespace axiscal::rates {

struct PoorSession {
  machine::Machine machine;
  machine::ErrorModel truth;  // all that acts; it is what is asked for, too
  std::vector<session::Session> sessions;
};

// Number `seed` of an instrument: ballbar, rtest, touch, tracker.
PoorSession DrawPoorSession(const std::string& instrument, uint64_t seed);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_POOR_SESSION_H_
