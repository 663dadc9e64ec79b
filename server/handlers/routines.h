// What runs by itself: Routines.PutRoutine, RemoveRoutine, ListRoutines, StopRoutine, RetryRoutine, ListRoutineRuns
// (docs/routines.md).
#ifndef AXISCAL_SERVER_HANDLERS_ROUTINES_H_
#define AXISCAL_SERVER_HANDLERS_ROUTINES_H_

#include "axiscal/v1/routines_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::PutRoutineResponse> PutRoutine(Core& core, const Call& call, const v1::PutRoutineRequest& request);
absl::StatusOr<v1::RemoveRoutineResponse> RemoveRoutine(Core& core, const Call& call,
                                                        const v1::RemoveRoutineRequest& request);
absl::StatusOr<v1::ListRoutinesResponse> ListRoutines(Core& core, const Call& call,
                                                      const v1::ListRoutinesRequest& request);
// FIELD_INVALID "machine_id" of a machine that the routine does not work for; so of RetryRoutine.
absl::StatusOr<v1::StopRoutineResponse> StopRoutine(Core& core, const Call& call,
                                                    const v1::StopRoutineRequest& request);
absl::StatusOr<v1::RetryRoutineResponse> RetryRoutine(Core& core, const Call& call,
                                                      const v1::RetryRoutineRequest& request);
absl::StatusOr<v1::ListRoutineRunsResponse> ListRoutineRuns(Core& core, const Call& call,
                                                            const v1::ListRoutineRunsRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_ROUTINES_H_
