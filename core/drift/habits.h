// What an error does all the time: wear, season, scatter. For the detector alone.
#ifndef AXISCAL_CORE_DRIFT_HABITS_H_
#define AXISCAL_CORE_DRIFT_HABITS_H_

#include <vector>

#include "core/drift/finding.h"
#include "core/drift/scales.h"
#include "core/drift/state.h"

namespace axiscal::drift {

// A calibration goes into the outlook of error j, unless it is suspect there. The outlooks of a state hold what has
// left the window. `first_at`: State::first_at, from which weeks count.
void AbsorbInto(const Past& past, int j, base::UtcTime first_at, Outlook* outlook);

// What is to be said now and was not, or is no longer so. It is remembered in the state, with some play, so that
// nothing is said to and fro.
std::vector<Finding> TellHabits(const Scales& scales, State* state);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_HABITS_H_
