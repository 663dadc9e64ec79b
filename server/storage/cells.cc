#include "server/storage/cells.h"

#include <algorithm>

#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/events.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

constexpr int64_t kMaxCellsOfMachine = 16;

constexpr char kSelectCell[] =
    "SELECT c.id, m.name, c.name, c.reported_by, c.reported_at_utc_us, c.reported_at_up_us, c.version, "
    "c.silent_after_s, c.problem, c.waiting_files, c.waiting_bytes, c.quarantined_files, c.quarantined_bytes, "
    "c.max_bytes FROM cell AS c CROSS JOIN machine AS m ON m.id = c.machine_id ";

CellRecord ReadCell(const Statement& row, const Moment& now) {
  CellRecord cell;
  cell.id = row.Int(0);
  cell.report.machine = MachineId(row.Text(1));
  cell.report.name = row.Text(2);
  cell.reported_by = row.Text(3);
  cell.reported_at = row.Time(4);
  cell.silence = std::chrono::microseconds(std::max<int64_t>(0, now.up_us - row.Int(5)));
  cell.report.version = row.Text(6);
  cell.report.silent_after = std::chrono::seconds(row.Int(7));
  cell.report.problem = row.Text(8);
  cell.report.waiting_files = row.Int(9);
  cell.report.waiting_bytes = row.Int(10);
  cell.report.quarantined_files = row.Int(11);
  cell.report.quarantined_bytes = row.Int(12);
  cell.report.max_bytes = row.Int(13);
  return cell;
}

absl::Status CheckRoom(Connection& connection, int64_t machine_key, const CellReport& report) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT count(*), coalesce(sum(CASE WHEN name = ?2 THEN 1 ELSE 0 END), 0) FROM cell "
                                  "WHERE machine_id = ?1",
                                  machine_key, report.name));
  RETURN_IF_ERROR(row.Step().status());
  if (row.Int(0) < kMaxCellsOfMachine || row.Int(1) > 0) return absl::OkStatus();
  return base::Error(absl::StatusCode::kResourceExhausted,
                     absl::StrCat("machine ", report.machine.text(), " has ", row.Int(0),
                                  " cells already: forget those that are no longer there"),
                     {"TOO_MANY_CELLS", {}});
}

}  // namespace

absl::StatusOr<CellRecord> ReportCell(Connection& connection, const Moment& now, const CellReport& report,
                                      const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t machine_key, LiveMachineKey(connection, report.machine));
  RETURN_IF_ERROR(CheckRoom(connection, machine_key, report));
  RETURN_IF_ERROR(connection.Run(
      "INSERT INTO cell (machine_id, name, reported_by, reported_at_utc_us, reported_at_up_us, version, "
      "silent_after_s, problem, waiting_files, waiting_bytes, quarantined_files, quarantined_bytes, max_bytes) "
      "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13) ON CONFLICT (machine_id, name) DO UPDATE SET "
      "reported_by = ?3, reported_at_utc_us = ?4, reported_at_up_us = ?5, version = ?6, silent_after_s = ?7, "
      "problem = ?8, waiting_files = ?9, waiting_bytes = ?10, quarantined_files = ?11, quarantined_bytes = ?12, "
      "max_bytes = ?13",
      machine_key, report.name, caller.principal, now.utc, now.up_us, report.version,
      static_cast<int64_t>(report.silent_after.count()), report.problem, report.waiting_files, report.waiting_bytes,
      report.quarantined_files, report.quarantined_bytes, report.max_bytes));
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectCell) + "WHERE c.machine_id = ?1 AND c.name = ?2",
                                                 machine_key, report.name));
  RETURN_IF_ERROR(row.Step().status());
  return ReadCell(row, now);
}

absl::StatusOr<Page<CellRecord>> ListCells(Connection& connection, const Moment& now,
                                           const std::optional<MachineId>& machine, const PageRequest& request,
                                           const Visible& visible) {
  ASSIGN_OR_RETURN(const PageStart start, StartPageById(request, "cells|" + (machine ? machine->text() : "")));
  std::string where = "WHERE c.id < ?1 AND m.deleted_at_utc_us IS NULL", ids;
  int64_t machine_key = 0;
  if (machine) {
    ASSIGN_OR_RETURN(machine_key, MachineKey(connection, *machine));
    where += " AND c.machine_id = ?3";
  } else if (!visible.everything) {
    ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
    ids = JsonOf(machines);
    where += " AND c.machine_id IN (SELECT value FROM json_each(?4))";
  }
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectCell) + where + " ORDER BY c.id DESC LIMIT ?2",
                                                 start.before_id, start.row_limit(), machine_key, ids));
  Page<CellRecord> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ReadCell(row, now));
  }
  EndPage(
      start, [](const CellRecord& cell) { return std::to_string(cell.id); },
      [](const CellRecord& cell) { return cell.report.problem.size() + cell.report.name.size(); }, page);
  return page;
}

absl::Status ForgetCell(Connection& connection, const Moment& now, const MachineId& machine, const std::string& name,
                        const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t machine_key, LiveMachineKey(connection, machine));
  RETURN_IF_ERROR(connection.Run("DELETE FROM cell WHERE machine_id = ?1 AND name = ?2", machine_key, name));
  if (connection.changed_rows() == 0) return NotFound("cell", "CELL", name);
  // Its events are cleared when the machine is looked at next.
  RETURN_IF_ERROR(NoteChange(connection, machine_key));
  return AuditChange(connection, now.utc, caller, "cell.forget", "machines/" + machine.text(), "cell " + name,
                     "forgotten");
}

// A cell that serves two machines has one spool.
absl::StatusOr<CellSums> SumCells(Connection& connection, const Moment& now) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(
          "SELECT count(*) - coalesce(sum(CASE WHEN is_silent = 1 OR has_problem = 1 THEN 1 ELSE 0 END), 0), "
          "coalesce(sum(is_silent), 0), "
          "coalesce(sum(CASE WHEN has_problem = 1 AND is_silent = 0 THEN 1 ELSE 0 END), 0), "
          "CAST(coalesce(sum(files), 0) AS BIGINT), CAST(coalesce(sum(bytes), 0) AS BIGINT), "
          "CAST(coalesce(sum(bad), 0) AS BIGINT) FROM "
          "(SELECT min(CASE WHEN ?1 - c.reported_at_up_us > 1000000 * c.silent_after_s THEN 1 ELSE 0 END) "
          "AS is_silent, "
          "max(CASE WHEN c.problem <> '' THEN 1 ELSE 0 END) AS has_problem, max(c.waiting_files) AS files, "
          "max(c.waiting_bytes) AS bytes, max(c.quarantined_files) AS bad FROM cell AS c "
          "CROSS JOIN machine AS m ON m.id = c.machine_id WHERE m.deleted_at_utc_us IS NULL "
          "GROUP BY c.reported_by, c.name) AS spool",
          now.up_us));
  RETURN_IF_ERROR(row.Step().status());
  return CellSums{row.Int(0), row.Int(1), row.Int(2), row.Int(3), row.Int(4), row.Int(5)};
}

}  // namespace axiscal::storage
