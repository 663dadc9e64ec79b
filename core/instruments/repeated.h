// A session that is there twice, under whatever names.
#ifndef AXISCAL_CORE_INSTRUMENTS_REPEATED_H_
#define AXISCAL_CORE_INSTRUMENTS_REPEATED_H_

#include <vector>

#include "core/base/status.h"
#include "core/instruments/run.h"

namespace axiscal::instruments {

// INVALID_ARGUMENT that names both of two sessions with the same tool point, times, positions (or path) and readings:
// fitted twice they would count twice, and as a check they would prove nothing. `check`: sessions that are predicted,
// if any; without them two of one name are left to identify::MakeProblem, which says that the name is there twice.
absl::Status CheckRepeated(const std::vector<MeasuringRun>& fit, const std::vector<MeasuringRun>& check = {});

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_REPEATED_H_
