#include "server/storage/handed_tables.h"

#include "server/storage/audit.h"

namespace axiscal::storage {

absl::Status NoteHandedTable(Connection& connection, UtcTime now, CalibrationId calibration, const std::string& format,
                             const Caller& caller) {
  RETURN_IF_ERROR(connection.Run(
      "INSERT INTO handed_table (calibration_id, format, handed_to, handed_at_utc_us) VALUES (?1, ?2, ?3, ?4) "
      "ON CONFLICT (calibration_id, format) DO UPDATE SET handed_to = ?3, handed_at_utc_us = ?4",
      calibration, format, caller.principal, now));
  return AuditChange(connection, now, caller, "table.make", absl::StrCat("calibrations/", calibration.number()), "",
                     format);
}

absl::StatusOr<std::vector<HandedTable>> ListHandedTables(Connection& connection, CalibrationId calibration) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT format, handed_to, handed_at_utc_us FROM handed_table "
                                                 "WHERE calibration_id = ?1 ORDER BY format",
                                                 calibration));
  std::vector<HandedTable> tables;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return tables;
    tables.push_back({row.Text(0), row.Text(1), row.Time(2)});
  }
}

}  // namespace axiscal::storage
