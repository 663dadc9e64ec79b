// Reads an `eccentricity` session: the paths of its header, and each sensed cell as one reading.
#ifndef AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_BIND_H_
#define AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_BIND_H_

#include "core/instruments/run.h"

namespace axiscal::eccentricity {

// Whether the header has any `path NAME`: without one the session is kept, but nothing can be identified from it.
bool HasPaths(const session::Session& session);

// Fills run->path_readings, and positions and measured_mm with one reading per sensed cell, in the order of the file.
// `run` has its header (tip, ball, bar). INVALID_ARGUMENT naming session, line, column and rule: a run without path, a
// sense other than -1, 0, 1, a component that the run's axis does not show, a line without any.
// `log_lines`: of the readings, where they came from a log, whose lines are then named.
absl::Status BindEccentricities(const machine::Machine& machine, const session::Session& session,
                                const std::vector<size_t>* log_lines, instruments::MeasuringRun* run);

// The columns ex_um, ey_um, ez_um of a planned session, 0 where its runs sense the component and empty elsewhere; what
// the session has already stays.
absl::Status AddReadingColumns(const machine::Machine& machine, session::Session* session);

}  // namespace axiscal::eccentricity

#endif  // AXISCAL_CORE_INSTRUMENTS_ECCENTRICITY_ECCENTRICITY_BIND_H_
