// A session run several times over without taking anything down: more weight, and a longer look at what goes with time.
#ifndef AXISCAL_CORE_PLAN_PASSES_H_
#define AXISCAL_CORE_PLAN_PASSES_H_

#include "core/plan/test.h"

namespace axiscal::plan {

// The path there, back along itself, there again ... `passes` times in all (>= 2) without a pause, at the pace of the
// session. Its name and its text say so.
PlannedSession InPasses(const PlannedSession& planned, int passes);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_PASSES_H_
