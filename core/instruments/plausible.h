// Could these readings have been taken at these commands? A reading that is centimetres away from what the nominal
// machine would give has another unit (metres, degrees where mm belong), a wrong sign in the machine's description, or
// the wrong table ball: nothing to identify from.
#ifndef AXISCAL_CORE_INSTRUMENTS_PLAUSIBLE_H_
#define AXISCAL_CORE_INSTRUMENTS_PLAUSIBLE_H_

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::instruments {

// Far above any error or mounting offset, far below any mistaken unit.
inline constexpr double kMaxDisagreementMm = 50.0;

// INVALID_ARGUMENT with line, number and session of the first reading that disagrees with the nominal machine by more
// than kMaxDisagreementMm. OK for instruments whose frame is not known beforehand (tracker) or that are no instruments
// of this library. The session must be valid and of this machine; a part of a session begins after `readings_before`.
absl::Status CheckPlausible(const session::Session& session, const machine::Machine& machine,
                            size_t readings_before = 0);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_PLAUSIBLE_H_
