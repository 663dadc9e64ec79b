// A session that is there twice, under whatever names.
#ifndef AXISCAL_CORE_INSTRUMENTS_REPEATED_H_
#define AXISCAL_CORE_INSTRUMENTS_REPEATED_H_

#include <vector>

#include "core/base/status.h"
#include "core/instruments/run.h"

namespace axiscal::instruments {

// INVALID_ARGUMENT that names both of two sessions with the same times, positions and readings: fitted twice they would
// count twice, and as a check they would prove nothing. `check`: sessions that are predicted, if any.
absl::Status CheckRepeated(const std::vector<MeasuringRun>& fit, const std::vector<MeasuringRun>& check = {});

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_REPEATED_H_
