// Figures of sessions in which one axis alone moves: positioning (positioning.h) along it, straightness (line.h)
// across, how far it turns what it carries. Seen by a tracker, a length along a beam or a direction.
#ifndef AXISCAL_CORE_FIGURES_AXIS_SESSIONS_H_
#define AXISCAL_CORE_FIGURES_AXIS_SESSIONS_H_

#include <vector>

#include "core/base/status.h"
#include "core/figures/figures.h"

namespace axiscal::figures {

// Readings at one position that the axis came to from one side: that of its last move, or what the session states
// (X_sense), as in every other use of the session.
struct Stop {
  double position = 0.0;  // mm or rad
  double sense = 0.0;
  std::vector<int> readings;
};
std::vector<Stop> StopsOf(const instruments::MeasuringRun& run, int axis);

// `axis` is the one that moves. INVALID_ARGUMENT with the reason where no figure is known of such a session.
absl::StatusOr<MeasuredTest> AxisTest(const machine::Machine& machine, const instruments::MeasuringRun& run, int axis);

}  // namespace axiscal::figures

#endif  // AXISCAL_CORE_FIGURES_AXIS_SESSIONS_H_
