// Part of binding a tracker's session (run.h): which target each of its readings is of.
#ifndef AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_BIND_H_
#define AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_BIND_H_

#include "core/instruments/run.h"

namespace axiscal::tracker {

// Fills run->targets and the run's own setup offsets from the column `target` and the headers `# target NAME`,
// `# reference NAME` and `# knocked_s`. INVALID_ARGUMENT, without the session's name, with the header or the target and
// what is expected. `is_whole`: false of a part of a session, which need not show every target.
absl::Status BindTargets(const session::Session& session, bool is_whole, instruments::MeasuringRun* run);

}  // namespace axiscal::tracker

#endif  // AXISCAL_CORE_INSTRUMENTS_TRACKER_TRACKER_BIND_H_
