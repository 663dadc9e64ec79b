// Which compensation tables were handed out of which calibration: a control may have them.
#ifndef AXISCAL_SERVER_STORAGE_HANDED_TABLES_H_
#define AXISCAL_SERVER_STORAGE_HANDED_TABLES_H_

#include "server/storage/connection.h"
#include "server/storage/records.h"

namespace axiscal::storage {

// As Database has them.
absl::Status NoteHandedTable(Connection& connection, UtcTime now, CalibrationId calibration, const std::string& format,
                             const Caller& caller);
absl::StatusOr<std::vector<HandedTable>> ListHandedTables(Connection& connection, const MachineId& machine);

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_HANDED_TABLES_H_
