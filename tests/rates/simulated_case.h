// Simulated machines with effects that their description does not declare: what the loop's rates are measured on. The
// plans (axis commands, places of the balls) are those of tests/data/loop, varied; machines' errors, effects, noise and
// bad readings are drawn.
#ifndef AXISCAL_TESTS_RATES_SIMULATED_CASE_H_
#define AXISCAL_TESTS_RATES_SIMULATED_CASE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/instruments/run.h"
#include "core/machine/error_model.h"
#include "core/session/case.h"
#include "core/synthetic/simulate.h"

namespace axiscal::rates {

// kWander: ball bars' noise is half slow wander, half white. kCoarse: readings are rounded to several sigma. Both with
// one effect, or none.
enum class Kind {
  kNull,
  kOne,
  kPair,
  kDirty,
  kDirtyNull,
  kMisstated,
  kBump,
  kSlip,
  kProbeSlip,
  kWander,
  kWanderNull,
  kCoarse,
  kCoarseNull
};

inline bool IsSlip(Kind kind) { return kind == Kind::kSlip || kind == Kind::kProbeSlip; }

struct SimulatedCase {
  machine::Machine machine;
  std::vector<instruments::MeasuringRun> fit, check;
  machine::ErrorModel declared, effects;   // what went in
  std::vector<double> signal_to_noise;     // per effect: rms of its unexplained signature over sigma
  std::vector<synthetic::BadReading> bad;  // of the fit sessions
  double sigma_scale = 1.0;                // true sigma over the stated one
  std::string slipped_session;             // of slips
  double slip_s = 0.0;
  instruments::Carrier carrier = instruments::Carrier::kTable;
};

// The case number `seed` of a kind; the same each time. `density`: so many readings where the plan's dense sessions
// have one; effects and bad readings are as large and as frequent, so that each shows more clearly.
SimulatedCase Draw(Kind kind, uint64_t seed, int density = 1);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_SIMULATED_CASE_H_
