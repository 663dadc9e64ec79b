// Which errors a state follows, and in which unit each is counted. For the detector alone.
#ifndef AXISCAL_CORE_DRIFT_ERRORS_OF_STATE_H_
#define AXISCAL_CORE_DRIFT_ERRORS_OF_STATE_H_

#include <vector>

#include "core/drift/calibration.h"
#include "core/drift/state.h"

namespace axiscal::drift {

// The calibration's errors are followed from now on, those long not seen no longer; units follow what good
// calibrations state. Returns the place of each value in State::errors.
std::vector<int> Follow(const Calibration& calibration, State* state);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_ERRORS_OF_STATE_H_
