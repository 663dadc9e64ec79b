// Makes measured sessions of a machine whose errors are known: for tests, for planning, and to judge a proposed
// measurement before it is made.
#ifndef AXISCAL_CORE_SYNTHETIC_SIMULATE_H_
#define AXISCAL_CORE_SYNTHETIC_SIMULATE_H_

#include <cstdint>

#include "core/machine/error_model.h"
#include "core/session/session.h"

namespace axiscal::synthetic {

struct NoiseOptions {
  double sigma_scale = 1.0;    // real noise over the session's stated sigma; 0 for exact readings
  double ar1 = 0.0;            // correlation of neighbouring readings, of the noise that is not white
  double white_share = 0.0;    // share of the variance that is white
  double bad_share = 0.0;      // share of readings that are off by 20 to 100 sigma
  double resolution_mm = 0.0;  // readings are rounded to this; 0 leaves them
  bool draw_setup = true;      // setup offsets drawn from their priors; false leaves them zero
  uint64_t seed = 1;
};

// The planned session (header and axis columns) with its reading columns filled or replaced. INVALID_ARGUMENT when it
// does not fit the machine.
absl::StatusOr<session::Session> Simulate(const machine::Machine& machine, const machine::ErrorModel& truth,
                                          const session::Session& planned, const NoiseOptions& noise);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_SIMULATE_H_
