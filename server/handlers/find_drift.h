// History.FindDrift: what happened to a machine, told from its calibrations and marks of people
// (core/drift, docs/drift.md; which calibrations count: server/inputs/machine_history.h).
#ifndef AXISCAL_SERVER_HANDLERS_FIND_DRIFT_H_
#define AXISCAL_SERVER_HANDLERS_FIND_DRIFT_H_

#include "axiscal/v1/history_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

// FIELD_INVALID: no machine, a limit whose low is not below its high, or that is no number.
absl::StatusOr<v1::FindDriftResponse> FindDrift(Core& core, const Call& call, const v1::FindDriftRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_FIND_DRIFT_H_
