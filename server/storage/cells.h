// Cells beside machines: the newest report of each.
#ifndef AXISCAL_SERVER_STORAGE_CELLS_H_
#define AXISCAL_SERVER_STORAGE_CELLS_H_

#include <optional>
#include <string>

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// As Database has them. `now`: their silence is counted in time that a server has had the file.
absl::StatusOr<CellRecord> ReportCell(Connection& connection, const Moment& now, const CellReport& report,
                                      const Caller& caller);
absl::StatusOr<Page<CellRecord>> ListCells(Connection& connection, const Moment& now,
                                           const std::optional<MachineId>& machine, const PageRequest& request,
                                           const Visible& visible);
absl::Status ForgetCell(Connection& connection, const Moment& now, const MachineId& machine, const std::string& name,
                        const Caller& caller);
absl::StatusOr<CellSums> SumCells(Connection& connection, const Moment& now);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_CELLS_H_
