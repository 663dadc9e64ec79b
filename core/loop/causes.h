// What is no error of the machine, for the report.
#ifndef AXISCAL_CORE_LOOP_CAUSES_H_
#define AXISCAL_CORE_LOOP_CAUSES_H_

#include "core/identify/identify.h"
#include "core/loop/extension.h"
#include "core/loop/report.h"

namespace axiscal::loop {

// An effect of the extension that is an instrument's fault; `fit`: of the extension.
Cause CauseOf(const Extension& extension, size_t effect, const identify::Fit& fit);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_CAUSES_H_
