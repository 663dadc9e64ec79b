// Drift told from steps, calibration by calibration (docs/drift.md): the state of a machine and one more calibration
// give the next state and what there is to say. The work does not depend on how long the history is. All errors are
// followed together, with the covariance of each calibration: what a calibration could not tell stays unknown.
// Units: those of the calibrations; times UTC.
#ifndef AXISCAL_CORE_DRIFT_DETECTOR_H_
#define AXISCAL_CORE_DRIFT_DETECTOR_H_

#include <vector>

#include "core/drift/calibration.h"
#include "core/drift/finding.h"
#include "core/drift/state.h"

namespace axiscal::drift {

// INVALID_ARGUMENT where the calibration is not as Check() wants it or an error has another unit than before;
// FAILED_PRECONDITION where it is not later than the last calibration, or earlier than the last mark (then the history
// is gone through anew). The state is unchanged then.
absl::StatusOr<std::vector<Finding>> Advance(const Calibration& calibration, State* state);

// What was known of where the marked errors stand ends at the mark; of their scatter, season and (but for a service)
// wear it is kept. Symbols that the machine does not have are passed over: they start unknown anyway.
// FAILED_PRECONDITION where the mark is earlier than the last calibration or mark. The state is unchanged then.
absl::Status Put(const Mark& mark, State* state);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_DETECTOR_H_
