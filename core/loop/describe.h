// Writes what an attempt has found into its report.
#ifndef AXISCAL_CORE_LOOP_DESCRIBE_H_
#define AXISCAL_CORE_LOOP_DESCRIBE_H_

#include <vector>

#include "core/identify/identify.h"
#include "core/loop/extension.h"
#include "core/loop/report.h"

namespace axiscal::loop {

// Fills effects with their classes, structure without a name, verdict, noise, proposed sessions and the fitted model.
// `runs`: the fit sessions; `fit`: of the extension.
void Describe(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs,
              const Extension& extension, const identify::Fit& fit, Report* report);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_DESCRIBE_H_
