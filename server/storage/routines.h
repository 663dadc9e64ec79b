// Rows of `routine` and what belongs to them. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_ROUTINES_H_
#define AXISCAL_SERVER_STORAGE_ROUTINES_H_

#include <optional>
#include <string>
#include <vector>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

absl::StatusOr<RoutineRecord> PutRoutine(Connection& connection, UtcTime now, const Routine& routine,
                                         int64_t expected_etag, const Caller& caller);
absl::StatusOr<RoutineRecord> RemoveRoutine(Connection& connection, UtcTime now, const std::string& name,
                                            int64_t expected_etag, const Caller& caller);
absl::StatusOr<RoutineRecord> StopRoutine(Connection& connection, UtcTime now, const std::string& name,
                                          const MachineId& machine, bool stops, const std::string& note,
                                          const Caller& caller);
// NOT_FOUND ROUTINE_NOT_FOUND.
absl::StatusOr<RoutineRecord> GetRoutine(Connection& connection, const std::string& name);
absl::StatusOr<std::vector<RoutineRecord>> ListRoutines(Connection& connection, const Visible& visible);

absl::StatusOr<std::vector<MachineId>> MachinesWithRoutines(Connection& connection);
absl::StatusOr<std::vector<RoutineRecord>> RoutinesOf(Connection& connection, const MachineId& machine);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_ROUTINES_H_
