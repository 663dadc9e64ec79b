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

// Far above any error or mounting offset, far below any mistaken unit.
inline constexpr double kMaxDisagreementMm = 50.0;

// INVALID_ARGUMENT with line, number and session of the first reading that disagrees with the nominal machine by more
// than kMaxDisagreementMm (not of instruments whose frame is not known beforehand: tracker), or of readings that
// CheckAlive refuses. OK for what is no instrument of this library. The session must be valid and of this machine; a
// part of a session begins after `readings_before`.
absl::Status CheckPlausible(const session::Session& session, const machine::Machine& machine,
                            size_t readings_before = 0);

// INVALID_ARGUMENT with lines, numbers, session and value of the longest stretch of readings that are all the same
// while the machine moves more than kDeadMoves times, where noise must have changed them: by what the session's other
// readings scatter and by what it states, whichever is less, and its resolution, such a stretch comes once in 1e9
// sessions. A coarse display or a signal without noise may stand still as long as it likes, but not for a whole
// session. `run` is the session bound, or a part of it; what is all the same in a later part is left to the whole.
inline constexpr int kDeadMoves = 20;
absl::Status CheckAlive(const session::Session& session, const MeasuringRun& run);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_PLAUSIBLE_H_
