// Which of the effects that were found are corrected: those whose correction could do harm where the sessions do not
// tell what they do are held back.
#ifndef AXISCAL_CORE_DECIDE_HOLD_BACK_H_
#define AXISCAL_CORE_DECIDE_HOLD_BACK_H_

#include "core/identify/identify.h"
#include "core/loop/extension.h"
#include "core/loop/report.h"
#include "core/objective/policy.h"

namespace axiscal::decide {

// `fit`: of the extension, as it was described in the report. Takes off what an acceleration of its axis could leave.
// Where the corrections together do more over the measured
// box than Policy::largest_hidden times what the declared model leaves of the readings, takes off effects until they do
// not, first the one without which that is least. Where then a machine corrected for it could be worse over the
// measured box than one corrected for constants alone, declared or found (Policy::harm_probability), takes off effects
// until it could not, first the one without which that is least likely, and fits what is left. Where no gain over the
// box is held then, takes off the rest that is corrected too. Constants stay: they are corrected as those that are
// declared, by the first of those that these sessions do not tell apart. Where they too gain nothing that matters
// (Policy::least_gain) the machine is left as it is corrected by the declared errors alone: `declared`, their fit. Sets
// the report's `volumetric`, and where something is taken off `held_back` and `fitted`. Errors of FitExtension.
absl::Status HoldBack(const machine::Machine& machine, const loop::Extension& extension, const identify::Fit& fit,
                      const identify::Result& declared, const objective::Policy& policy,
                      const identify::Options& options, loop::Report* report);

}  // namespace axiscal::decide

#endif  // AXISCAL_CORE_DECIDE_HOLD_BACK_H_
