// Rows of `routine_run`: each time that a routine ran. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_ROUTINE_RUNS_H_
#define AXISCAL_SERVER_STORAGE_ROUTINE_RUNS_H_

#include <optional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

absl::StatusOr<std::vector<RoutineRun>> NewestRuns(Connection& connection, const MachineId& machine);
absl::StatusOr<std::optional<NamedSession>> NewSessionFor(Connection& connection, RoutineId routine,
                                                          const MachineId& machine, const std::string& name);
absl::StatusOr<RoutineRun> BeginRun(Connection& connection, UtcTime now, const RoutineRecord& routine,
                                    const MachineId& machine, const std::vector<SessionId>& sessions,
                                    const std::vector<SessionId>& check_sessions);
absl::StatusOr<RoutineRun> ChangeRun(Connection& connection, UtcTime now, const RunChange& change);
absl::StatusOr<RoutineRun> RetryRoutine(Connection& connection, UtcTime now, const std::string& name,
                                        const MachineId& machine, const Caller& caller);
absl::StatusOr<Page<RoutineRun>> ListRuns(Connection& connection, const RunFilter& filter, const PageRequest& request,
                                          const Visible& visible);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ROUTINE_RUNS_H_
