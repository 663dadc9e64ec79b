// Does a session belong to a machine: its name, its axes, their units and their travel.
#ifndef AXISCAL_CORE_SESSION_CHECK_MACHINE_H_
#define AXISCAL_CORE_SESSION_CHECK_MACHINE_H_

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::session {

// The session must be valid (see Validate). INVALID_ARGUMENT with the place in the session's file when the header names
// another machine, a column names an axis that the machine has not or has in the other unit, an axis that the
// instrument needs has no column, or a position lies beyond the travel that the description states.
absl::Status CheckAgainstMachine(const Session& session, const machine::Machine& machine);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_CHECK_MACHINE_H_
