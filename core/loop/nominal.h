// Nominal data that are wrong: the readings say so before any error is looked for, as with the right ones the declared
// model leaves a hundredth of what it does with those that are stated.
#ifndef AXISCAL_CORE_LOOP_NOMINAL_H_
#define AXISCAL_CORE_LOOP_NOMINAL_H_

#include <optional>
#include <vector>

#include "core/identify/identify.h"
#include "core/loop/report.h"

namespace axiscal::loop {

// Tries a closed list in place of what machine.json and the columns say, for all sessions and for each alone: the
// direction of an axis the other way, two columns of a kind exchanged, a column in another unit. Those that come ten
// times nearer to the readings without any errors than what is stated are fitted; `declared`: the fit of the declared
// errors as stated, or why there is none. Nothing where no alternative explains 99 of 100 parts of what it leaves and
// pulls set-ups by; CANCELLED.
absl::StatusOr<std::optional<Cause>> FindNominalFault(const machine::Machine& machine,
                                                      const std::vector<instruments::MeasuringRun>& runs,
                                                      const absl::StatusOr<identify::Fit>& declared,
                                                      const identify::Options& options);

// Constants of a fit that are larger than any machine's errors: where a rotary axis stands, how long the tool is.
std::vector<Cause> NominalConstants(const machine::Machine& machine, const identify::Fit& fit);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_NOMINAL_H_
