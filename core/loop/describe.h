// Writes what an attempt has found into its report.
#ifndef AXISCAL_CORE_LOOP_DESCRIBE_H_
#define AXISCAL_CORE_LOOP_DESCRIBE_H_

#include <vector>

#include "core/identify/identify.h"
#include "core/loop/extension.h"
#include "core/loop/report.h"

namespace axiscal::loop {

// What an effect could be as well; the values are those of objective::Policy.
struct ClassRule {
  double alike = 0.0;          // what explains as much within this, chi-square units
  double order_falloff = 0.0;  // power of the frequency by which the odds of waves that read the same fall
};

// Fills effects with their classes, structure without a name, verdict, noise, proposed sessions and the fitted model.
// `runs`: the fit sessions; `fit`: of the extension; `named_by`: the sessions that the effects were named by. A
// harmonic that is no eccentricity is one of a class with those that read the same at their positions.
void Describe(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs,
              const std::vector<instruments::MeasuringRun>& named_by, const Extension& extension,
              const identify::Fit& fit, const ClassRule& rule, Report* report);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_DESCRIBE_H_
