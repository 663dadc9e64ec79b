// Could these readings have been taken at these commands? A reading that is centimetres away from what the nominal
// machine would give has another unit (metres, degrees where mm belong), a wrong sign in the machine's description, or
// the wrong table ball: nothing to identify from. One that stays the same to the last digit while the machine moves
// comes from an instrument that is not there.
#ifndef AXISCAL_CORE_INSTRUMENTS_PLAUSIBLE_H_
#define AXISCAL_CORE_INSTRUMENTS_PLAUSIBLE_H_

#include "core/base/status.h"
#include "core/instruments/run.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::instruments {

// Far larger than any error or mounting offset, far smaller than the effect of a wrong unit.
inline constexpr double kMaxDisagreementMm = 50.0;

// INVALID_ARGUMENT with line, number and session of the first reading that disagrees with the nominal machine by more
// than kMaxDisagreementMm (of a tracker, whose frame is not known beforehand, where its readings fit best, but for
// reference targets; not of directions), or of readings that CheckAlive refuses. OK for instruments that this library
// does not know. The session must be valid and of this machine; `readings_before` counts the readings before it where
// it is a part of a session; `log_lines`: of all its readings, where they came from a log, whose lines are then named.
absl::Status CheckPlausible(const session::Session& session, const machine::Machine& machine,
                            size_t readings_before = 0, const std::vector<size_t>* log_lines = nullptr);

// Headers that speak of all readings of a session: each of a tracker's targets is read, and it was knocked between the
// first reading and the last. The session is valid and whole; of its columns `target` and `t_s` are looked at. OK for
// other instruments. INVALID_ARGUMENT naming session, header, value and rule.
absl::Status CheckWhole(const session::Session& session);

// INVALID_ARGUMENT with lines, numbers, session and value of the longest stretch of equal readings while the machine
// moves more than kDeadMoves times, if chance makes such a stretch in fewer than one of 1e9 sessions. Chance is judged
// from the session's resolution and its noise: as stated or that of its other readings, whichever is less. Readings
// on a coarse display or without noise may stay equal, but not through a whole session. `run` is the bound session or a
// part of it; a later part that is equal throughout passes here and is judged with the whole session.
inline constexpr int kDeadMoves = 20;
absl::Status CheckAlive(const session::Session& session, const MeasuringRun& run,
                        const std::vector<size_t>* log_lines = nullptr);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_PLAUSIBLE_H_
