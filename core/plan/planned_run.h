// A planned session as the run that it will be once it is measured.
#ifndef AXISCAL_CORE_PLAN_PLANNED_RUN_H_
#define AXISCAL_CORE_PLAN_PLANNED_RUN_H_

#include "core/instruments/run.h"
#include "core/session/session.h"

namespace axiscal::plan {

// `session`: header and axis columns. All readings of the run are zero. INVALID_ARGUMENT as BindSession, or where the
// instrument is none that is evaluated.
absl::StatusOr<instruments::MeasuringRun> PlannedRun(const machine::Machine& machine, session::Session session);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_PLANNED_RUN_H_
