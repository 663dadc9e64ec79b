// Whether sessions count their times from one start.
#ifndef AXISCAL_CORE_INSTRUMENTS_CLOCK_H_
#define AXISCAL_CORE_INSTRUMENTS_CLOCK_H_

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/instruments/run.h"

namespace axiscal::instruments {

// Two sessions that overlap in time: a machine is not measured twice at a time, so each counts from a start of its own,
// against the rule of docs/formats.md (`t_s`). What happens within a session is known all the same; what lasts longer
// (drift, warming up, a carrier that moves) is not, as the same t_s means another moment in each. Nothing where the
// sessions follow each other, as those of one clock do; those without times, and readings along a path, do not count.
std::optional<std::pair<std::string, std::string>> FindOverlap(const std::vector<MeasuringRun>& runs);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_CLOCK_H_
