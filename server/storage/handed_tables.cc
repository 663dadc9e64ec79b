#include "server/storage/handed_tables.h"

#include "server/storage/audit.h"
#include "server/storage/machines.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

absl::StatusOr<int64_t> MachineKeyOf(Connection& connection, CalibrationId calibration) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT machine_id FROM calibration WHERE id = ?1", calibration));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("calibration", "CALIBRATION", absl::StrCat(calibration.number()));
  return row.Int(0);
}

}  // namespace

absl::Status NoteHandedTable(Connection& connection, UtcTime now, CalibrationId calibration, const std::string& format,
                             const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKeyOf(connection, calibration));
  RETURN_IF_ERROR(connection.Run(
      "INSERT INTO handed_table (machine_id, calibration_id, format, handed_to, handed_at_utc_us) "
      "VALUES (?1, ?2, ?3, ?4, ?5) "
      "ON CONFLICT (machine_id, calibration_id, format) DO UPDATE SET handed_to = ?4, handed_at_utc_us = ?5",
      machine_key, calibration, format, caller.principal, now));
  return AuditChange(connection, now, caller, "table.make", absl::StrCat("calibrations/", calibration.number()), "",
                     format);
}

absl::StatusOr<std::vector<HandedTable>> ListHandedTables(Connection& connection, const MachineId& machine) {
  ASSIGN_OR_RETURN(const int64_t machine_key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT calibration_id, format, handed_to, handed_at_utc_us FROM handed_table "
                                  "WHERE machine_id = ?1 ORDER BY calibration_id, format",
                                  machine_key));
  std::vector<HandedTable> tables;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return tables;
    tables.push_back({CalibrationId(row.Int(0)), row.Text(1), row.Text(2), row.Time(3)});
  }
}

}  // namespace axiscal::storage
