// Rows of `machine` and `machine_revision`. What each function returns: database.h.
#ifndef AXISCAL_SERVER_STORAGE_MACHINES_H_
#define AXISCAL_SERVER_STORAGE_MACHINES_H_

#include <string>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

absl::StatusOr<MachineRecord> CreateMachine(Connection& connection, UtcTime now, const MachineId& id,
                                            const std::string& description_json, const Caller& caller);
absl::StatusOr<MachineRecord> GetMachine(Connection& connection, const MachineId& id);
absl::StatusOr<MachineRecord> GetMachineRevision(Connection& connection, const MachineId& id, int64_t revision);
absl::StatusOr<MachineRecord> UpdateMachine(Connection& connection, UtcTime now, const MachineId& id,
                                            int64_t expected_revision, const std::string& description_json,
                                            const Caller& caller);
absl::StatusOr<MachineRecord> DeleteMachine(Connection& connection, UtcTime now, const MachineId& id,
                                            int64_t expected_revision, const Caller& caller);
absl::StatusOr<Page<MachineRecord>> ListMachines(Connection& connection, const PageRequest& request,
                                                 const Visible& visible);

// The number by which other tables name the machine. NOT_FOUND MACHINE_NOT_FOUND.
absl::StatusOr<int64_t> MachineKey(Connection& connection, const MachineId& id);
// The same, but FAILED_PRECONDITION MACHINE_DELETED for a deleted one.
absl::StatusOr<int64_t> LiveMachineKey(Connection& connection, const MachineId& id);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_MACHINES_H_
