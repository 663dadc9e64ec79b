#include "server/storage/machines.h"

#include "core/base/sha256.h"
#include "server/storage/access.h"
#include "server/storage/audit.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

constexpr char kSelectMachine[] =
    "SELECT m.name, r.revision, r.description_json, m.created_at_utc_us, r.created_at_utc_us, m.deleted_at_utc_us, "
    "r.sha256 FROM machine AS m JOIN machine_revision AS r ON r.machine_id = m.id ";

MachineRecord ReadMachine(const Statement& row) {
  return {MachineId(row.Text(0)), row.Int(1), row.Text(2), row.Time(3), row.Time(4), row.OptionalTime(5)};
}

absl::Status InsertRevision(Connection& connection, UtcTime now, int64_t key, int64_t revision,
                            const std::string& description_json, const Caller& caller) {
  return connection.Run(
      "INSERT INTO machine_revision (machine_id, revision, description_json, created_by, created_at_utc_us, "
      "sha256) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
      key, revision, description_json, caller.principal, now, base::Sha256Hex(description_json));
}

// With what tells whether the description is the one that was stored.
struct Found {
  MachineRecord record;
  bool is_intact = false;
};

absl::StatusOr<Found> ReadOne(Statement row, const std::string& what) {
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("machine", "MACHINE", what);
  Found machine = {ReadMachine(row), false};
  machine.is_intact = base::Sha256Hex(machine.record.description_json) == row.Text(6);
  return machine;
}

absl::StatusOr<Found> Find(Connection& connection, const MachineId& id) {
  ASSIGN_OR_RETURN(
      Statement row,
      connection.Ask(std::string(kSelectMachine) + "AND r.revision = m.revision WHERE m.name = ?1", id.text()));
  return ReadOne(std::move(row), id.text());
}

absl::StatusOr<MachineRecord> RequireIntact(absl::StatusOr<Found> machine) {
  if (!machine.ok()) return machine.status();
  if (machine->is_intact) return std::move(machine->record);
  const MachineRecord& record = machine->record;
  return base::Error(
      absl::StatusCode::kDataLoss,
      absl::StrCat("machine ", record.id.text(), ": the description of revision ", record.revision,
                   " is damaged: it is not what was stored; restore a backup, or store the description "
                   "again as a new revision"),
      {"MACHINE_DAMAGED", {{"machine", record.id.text()}, {"revision", std::to_string(record.revision)}}});
}

absl::StatusOr<MachineRecord> KeepExisting(const MachineRecord& present, const std::string& description_json) {
  if (!present.deleted_at.has_value() && present.description_json == description_json) return present;
  const std::string how =
      present.deleted_at.has_value() ? " existed and was deleted" : " exists with another description";
  return base::Error(absl::StatusCode::kAlreadyExists, "machine " + present.id.text() + how,
                     {"MACHINE_EXISTS", {{"machine", present.id.text()}}});
}

}  // namespace

absl::StatusOr<MachineRecord> CreateMachine(Connection& connection, UtcTime now, const MachineId& id,
                                            const std::string& description_json, const Caller& caller) {
  const absl::StatusOr<MachineRecord> present = GetMachine(connection, id);
  if (present.ok()) return KeepExisting(*present, description_json);
  if (!absl::IsNotFound(present.status())) return present;
  ASSIGN_OR_RETURN(
      const int64_t key,
      connection.Insert("INSERT INTO machine (name, revision, created_at_utc_us) VALUES (?1, 1, ?2)", id.text(), now));
  RETURN_IF_ERROR(InsertRevision(connection, now, key, 1, description_json, caller));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "machine.create", "machines/" + id.text(), "", "revision 1"));
  return GetMachine(connection, id);
}

absl::StatusOr<MachineRecord> GetMachine(Connection& connection, const MachineId& id) {
  return RequireIntact(Find(connection, id));
}

absl::StatusOr<MachineRecord> GetMachineRevision(Connection& connection, const MachineId& id, int64_t revision) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectMachine) + "WHERE m.name = ?1 AND r.revision = ?2",
                                                 id.text(), revision));
  return RequireIntact(ReadOne(std::move(row), absl::StrCat(id.text(), " revision ", revision)));
}

absl::StatusOr<MachineRecord> UpdateMachine(Connection& connection, UtcTime now, const MachineId& id,
                                            int64_t expected_revision, const std::string& description_json,
                                            const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t key, LiveMachineKey(connection, id));
  // Of a damaged description this is the way out.
  ASSIGN_OR_RETURN(const Found present, Find(connection, id));
  RETURN_IF_ERROR(CheckEtag("machine " + id.text(), expected_revision, present.record.revision));
  if (present.is_intact && present.record.description_json == description_json) return present.record;
  RETURN_IF_ERROR(InsertRevision(connection, now, key, present.record.revision + 1, description_json, caller));
  RETURN_IF_ERROR(connection.Run("UPDATE machine SET revision = revision + 1 WHERE id = ?1", key));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "machine.update", "machines/" + id.text(),
                              absl::StrCat("revision ", present.record.revision),
                              absl::StrCat("revision ", present.record.revision + 1)));
  return GetMachine(connection, id);
}

absl::StatusOr<MachineRecord> DeleteMachine(Connection& connection, UtcTime now, const MachineId& id,
                                            int64_t expected_revision, const Caller& caller) {
  ASSIGN_OR_RETURN(Found present, Find(connection, id));
  if (present.record.deleted_at.has_value()) return std::move(present.record);
  RETURN_IF_ERROR(CheckEtag("machine " + id.text(), expected_revision, present.record.revision));
  RETURN_IF_ERROR(connection.Run("UPDATE machine SET deleted_at_utc_us = ?2 WHERE name = ?1", id.text(), now));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "machine.delete", "machines/" + id.text(),
                              absl::StrCat("revision ", present.record.revision), "deleted"));
  ASSIGN_OR_RETURN(Found deleted, Find(connection, id));
  return std::move(deleted.record);
}

absl::StatusOr<Page<MachineRecord>> ListMachines(Connection& connection, const PageRequest& request,
                                                 const Visible& visible) {
  ASSIGN_OR_RETURN(const PageStart start, StartPage(request, "machines"));
  ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, visible.scopes));
  const std::string seen = visible.everything ? "" : "AND +m.id IN (SELECT value FROM json_each(?3)) ";
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectMachine) +
                                                     "AND r.revision = m.revision WHERE m.name > ?1 AND "
                                                     "m.deleted_at_utc_us IS NULL " +
                                                     seen + "ORDER BY m.name LIMIT ?2",
                                                 start.after.value_or(""), start.row_limit(), JsonOf(machines)));
  Page<MachineRecord> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ReadMachine(row));
  }
  EndPage(
      start, [](const MachineRecord& machine) { return machine.id.text(); },
      [](const MachineRecord& machine) { return machine.description_json.size(); }, page);
  return page;
}

absl::StatusOr<int64_t> MachineKey(Connection& connection, const MachineId& id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id FROM machine WHERE name = ?1", id.text()));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("machine", "MACHINE", id.text());
  return row.Int(0);
}

absl::StatusOr<int64_t> LiveMachineKey(Connection& connection, const MachineId& id) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT id, deleted_at_utc_us FROM machine WHERE name = ?1", id.text()));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("machine", "MACHINE", id.text());
  if (!row.IsNull(1)) return FailedPrecondition("machine " + id.text() + " was deleted", "MACHINE_DELETED");
  return row.Int(0);
}

}  // namespace axiscal::storage
