// Part of binding a session (run.h), for whoever looks at its readings and fits nothing to them.
#ifndef AXISCAL_CORE_INSTRUMENTS_BIND_READINGS_H_
#define AXISCAL_CORE_INSTRUMENTS_BIND_READINGS_H_

#include "core/instruments/run.h"

namespace axiscal::instruments {

// As BindSession without what only a fit needs: axis_states stay empty, a tracker's starting pose is not looked for.
// `log_lines` as of CheckPlausible (plausible.h).
absl::StatusOr<MeasuringRun> BindReadings(const session::Session& session, const machine::Machine& machine,
                                          size_t readings_before, const std::vector<size_t>* log_lines = nullptr);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_BIND_READINGS_H_
