// What a test in the tool setter will tell, before anything is measured: the evaluation of the readings that the exact
// model would give at the stated repeatability.
#ifndef AXISCAL_CORE_TOOLSETTER_PLAN_H_
#define AXISCAL_CORE_TOOLSETTER_PLAN_H_

#include <string>

#include "core/toolsetter/reference.h"
#include "core/toolsetter/wear.h"

namespace axiscal::toolsetter {

// `session.rods` with `readouts` (1 to 100) each. `turned`: the name of a rod that is measured in `holders` (2 to 360)
// evenly spaced positions of the spindle instead of one, "NAME@30" ...; empty: none. INVALID_ARGUMENT naming the
// number, or the rod that is not there.
absl::StatusOr<RodSession> PlanRods(RodSession session, const std::string& turned, int holders, int readouts);

// `starts` (inserts + 2 to 360) evenly spaced start angles of the unworn cutter. INVALID_ARGUMENT as Validate.
absl::StatusOr<CurveSession> PlanStarts(CurveSession session, int starts);

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_PLAN_H_
