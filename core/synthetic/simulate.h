// Makes measured sessions of a machine whose errors are known: for tests, for planning, and to judge a proposed
// measurement before it is made.
#ifndef AXISCAL_CORE_SYNTHETIC_SIMULATE_H_
#define AXISCAL_CORE_SYNTHETIC_SIMULATE_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/instruments/run.h"
#include "core/machine/error_model.h"
#include "core/session/session.h"

namespace axiscal::synthetic {

struct NoiseOptions {
  double sigma_scale = 1.0;    // real noise over the session's stated sigma; 0 for exact readings
  double ar1 = 0.0;            // correlation of neighbouring readings, of the noise that is not white
  double white_share = 0.0;    // share of the variance that is white
  double bad_share = 0.0;      // share of readings that are off by 20 to 100 sigma
  double resolution_mm = 0.0;  // readings are rounded to this; 0 leaves them
  int student_degrees = 0;     // above 2: noise of Student's t with so many degrees of freedom, variance as stated
  double heavy_share = 0.0;    // share of readings whose noise is five times as large
  double pose_share = 0.0;     // share of the variance that all readings at one pose (axis positions) have in common
  bool draw_setup = true;      // setup offsets drawn from their priors; false leaves them zero
  uint64_t seed = 1;
  // Of the set-up alone, so that sessions with the same set-up get the same offsets; from `seed` where absent.
  std::optional<uint64_t> setup_seed;
  // Of what headers state with an uncertainty (instruments/stated.h; the scale of an instrument of a serial number):
  // with one seed for all sessions the same fact is off by the same amount in all of them. Absent: facts are as they
  // are stated, scales off in each session by itself.
  std::optional<uint64_t> stated_seed;
};

// The planned session (header and axis columns) with its reading columns filled or replaced. INVALID_ARGUMENT when it
// does not fit the machine.
absl::StatusOr<session::Session> Simulate(const machine::Machine& machine, const machine::ErrorModel& truth,
                                          const session::Session& planned, const NoiseOptions& noise);

// How a reading comes about where the errors are no ErrorModel, or the instrument is at fault.
struct Measuring {
  // Errors of all joints at a reading, counted from 0, and its state (for readings along a path the state of a point).
  std::function<machine::JointErrors<double>(int reading, const shapes::State& state)> errors_at;
  // Where the axes stand when the instrument reads, as MeasuringRun::positions; empty: at their commands.
  std::vector<double> read_positions;
  // Changes what the instrument would read, `row_count` values in mm, before noise; absent: an instrument without
  // fault.
  std::function<void(int reading, double* reading_mm)> distort;
  NoiseOptions noise;
};

// As Simulate().
absl::StatusOr<session::Session> Measure(const machine::Machine& machine, const Measuring& measuring,
                                         const session::Session& planned);

// The planned session with reading columns, zeros where it had none: what can be bound. INVALID_ARGUMENT for an
// instrument that cannot be simulated.
absl::StatusOr<session::Session> WithReadingColumns(const machine::Machine& machine, const session::Session& planned);

// A reading that is bad: chips, an operator.
struct BadReading {
  std::string session;
  int row = 0;  // line of data, from 1
  int column = 0;
};
// Puts a share of all readings off by 20 to 100 times the stated sigma and `sigma_scale`, each row by itself. `run` is
// the session bound.
std::vector<BadReading> SpoilReadings(const instruments::MeasuringRun& run, double share, double sigma_scale,
                                      base::Random* random, session::Session* session);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_SIMULATE_H_
