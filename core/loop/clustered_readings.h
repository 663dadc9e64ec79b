// Bad readings that cluster in a variable are structure, not chips: each was set aside alone, but together they show
// that the model lacks something.
#ifndef AXISCAL_CORE_LOOP_CLUSTERED_READINGS_H_
#define AXISCAL_CORE_LOOP_CLUSTERED_READINGS_H_

#include <vector>

#include "core/identify/identify.h"
#include "core/loop/report.h"

namespace axiscal::loop {

// Ranges of an axis in which far more readings were set aside than chance puts there: a scan over all ranges that bad
// readings span, at most a fifth of what the axis moved, against a binomial share equal everywhere; the chance of one
// such range anywhere is below 1e-3. Neighbouring readings that are bad together count once. Where axes move together
// (a ball bar's X and B) the one with the least likely range is named.
std::vector<Unexplained> ClusteredReadings(const machine::Machine& machine, const identify::Fit& fit);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_CLUSTERED_READINGS_H_
