#include "server/storage/access.h"

#include <algorithm>

#include "absl/strings/str_join.h"
#include "server/storage/audit.h"
#include "server/storage/machines.h"
#include "server/storage/page_token.h"
#include "server/storage/refusal.h"

namespace axiscal::storage {
namespace {

using records::Role;
using records::Scope;

absl::Status CheckAccessName(const std::string& what, const std::string& name) {
  if (records::IsAccessName(name)) return absl::OkStatus();
  return base::Error(absl::StatusCode::kInvalidArgument,
                     absl::StrCat(what, " '", name,
                                  "', must be 1 to 64 letters, digits, '.', '_', '@' or '-', with a letter or digit at "
                                  "both ends"),
                     {"NAME_INVALID", {{"field", what}}});
}

std::string PlaceOf(const std::string& principal) { return "principals/" + principal; }

std::string RolesText(const std::vector<Grant>& grants) {
  if (grants.empty()) return "no role";
  return absl::StrJoin(grants, "; ", [](std::string* out, const Grant& grant) {
    absl::StrAppend(out, records::NameOf(grant.role), " of ", records::TextOf(grant.scope));
  });
}

absl::StatusOr<int64_t> PrincipalKey(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id FROM principal WHERE name = ?1", name));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("principal", "PRINCIPAL", name);
  return row.Int(0);
}

// Of one that was revoked nothing changes any more.
absl::StatusOr<int64_t> LivePrincipalKey(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(const int64_t key, PrincipalKey(connection, name));
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT revoked_at_utc_us FROM principal WHERE id = ?1", key));
  RETURN_IF_ERROR(row.Step().status());
  if (!row.IsNull(0)) return FailedPrecondition("principal " + name + " was revoked", "PRINCIPAL_REVOKED");
  return key;
}

absl::StatusOr<std::vector<Grant>> ReadGrants(Connection& connection, int64_t key) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT role, scope, scope_name FROM principal_role "
                                                 "WHERE principal_id = ?1 ORDER BY role, scope, scope_name",
                                                 key));
  std::vector<Grant> grants;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return grants;
    grants.push_back({row.As<Role>(0), {row.As<Scope::Kind>(1), row.Text(2)}});
  }
}

constexpr char kSelectToken[] =
    "SELECT t.id, p.name, t.note, t.created_by, t.created_at_utc_us, t.expires_at_utc_us, t.last_used_at_utc_us, "
    "t.revoked_at_utc_us FROM token AS t JOIN principal AS p ON p.id = t.principal_id ";

TokenRecord ReadToken(const Statement& row) {
  return {row.Int(0),  row.Text(1),         row.Text(2),         row.Text(3),
          row.Time(4), row.OptionalTime(5), row.OptionalTime(6), row.OptionalTime(7)};
}

absl::StatusOr<TokenRecord> GetToken(Connection& connection, int64_t id) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectToken) + "WHERE t.id = ?1", id));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("token", "TOKEN", std::to_string(id));
  return ReadToken(row);
}

absl::Status ReadAll(Connection& connection, int64_t key, PrincipalRecord& record) {
  ASSIGN_OR_RETURN(record.grants, ReadGrants(connection, key));
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask(std::string(kSelectToken) + "WHERE t.principal_id = ?1 ORDER BY t.id", key));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    record.tokens.push_back(ReadToken(row));
  }
}

constexpr char kSelectPrincipal[] =
    "SELECT name, note, created_by, created_at_utc_us, revoked_at_utc_us, id FROM principal ";

PrincipalRecord ReadPrincipal(const Statement& row) {
  return {row.Text(0), row.Text(1), row.Text(2), row.Time(3), row.OptionalTime(4), {}, {}};
}

absl::StatusOr<MachineAccess> AccessOf(Connection& connection, int64_t machine_key) {
  MachineAccess access;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT name, four_eyes FROM machine WHERE id = ?1", machine_key));
    RETURN_IF_ERROR(row.Step().status());
    access.machine = MachineId(row.Text(0));
    access.four_eyes = row.Bool(1);
  }
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT name FROM machine_group WHERE machine_id = ?1 ORDER BY name", machine_key));
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return access;
    access.groups.push_back(row.Text(0));
  }
}

absl::StatusOr<std::optional<Holder>> HolderIn(Connection& connection, Statement row) {
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return std::nullopt;
  Holder holder;
  holder.principal = row.Text(1);
  holder.is_revoked = !row.IsNull(2);
  if (!row.IsNull(3)) {
    holder.token = row.Int(3);
    holder.token_expires_at = row.OptionalTime(4);
    holder.token_last_used_at = row.OptionalTime(5);
    holder.is_revoked |= !row.IsNull(6);
  }
  ASSIGN_OR_RETURN(holder.grants, ReadGrants(connection, row.Int(0)));
  return holder;
}

// Asks for machine_id and created_by of the row with id ?1; of a program for its id, of a machine by its name.
std::string OwnerSql(ResourceKind kind) {
  switch (kind) {
    case ResourceKind::kSession:
      return "SELECT machine_id, created_by FROM session WHERE id = ?1";
    case ResourceKind::kJob:
      return "SELECT machine_id, created_by FROM job WHERE id = ?1";
    case ResourceKind::kCalibration:
      return "SELECT machine_id, created_by FROM calibration WHERE id = ?1";
    case ResourceKind::kProgram:
      return "SELECT coalesce(same_as, id), created_by FROM program WHERE id = ?1";
    case ResourceKind::kMachine:
      return "SELECT id, '' FROM machine WHERE name = ?1";
    case ResourceKind::kMark:
      return "SELECT machine_id, created_by FROM mark WHERE id = ?1";
    case ResourceKind::kEvent:
      return "SELECT machine_id, '' FROM event WHERE id = ?1";
  }
  return "";
}

absl::StatusOr<Belonging> ProgramBelongs(Connection& connection, int64_t program, const std::string& principal) {
  Belonging belonging;
  {
    ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT 1 FROM program_holder WHERE holder = ?1 AND program_id = ?2",
                                                   principal, program));
    ASSIGN_OR_RETURN(belonging.is_own, row.Step());
  }
  std::vector<int64_t> machines;
  {
    ASSIGN_OR_RETURN(Statement row,
                     connection.Ask("SELECT machine_id FROM program_machine WHERE program_id = ?1", program));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      machines.push_back(row.Int(0));
    }
  }
  for (const int64_t machine : machines) {
    ASSIGN_OR_RETURN(MachineAccess access, AccessOf(connection, machine));
    belonging.machines.push_back(std::move(access));
  }
  return belonging;
}

}  // namespace

absl::StatusOr<PrincipalRecord> CreatePrincipal(Connection& connection, UtcTime now, const std::string& name,
                                                const std::string& note, const Caller& caller) {
  RETURN_IF_ERROR(CheckAccessName("name", name));
  const absl::StatusOr<PrincipalRecord> present = GetPrincipal(connection, name);
  if (present.ok()) {
    if (!present->revoked_at && present->note == note) return present;
    return base::Error(absl::StatusCode::kAlreadyExists,
                       "principal " + name + (present->revoked_at ? " was revoked: take another name" : " exists"),
                       {"PRINCIPAL_EXISTS", {{"principal", name}}});
  }
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO principal (name, note, created_by, created_at_utc_us) VALUES (?1, ?2, ?3, ?4)", name,
                     note, caller.principal, now));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, "principal.create", PlaceOf(name), "", "no role"));
  return GetPrincipal(connection, name);
}

absl::StatusOr<PrincipalRecord> GetPrincipal(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask(std::string(kSelectPrincipal) + "WHERE name = ?1", name));
  ASSIGN_OR_RETURN(const bool found, row.Step());
  if (!found) return NotFound("principal", "PRINCIPAL", name);
  PrincipalRecord record = ReadPrincipal(row);
  RETURN_IF_ERROR(ReadAll(connection, row.Int(5), record));
  return record;
}

absl::StatusOr<PrincipalRecord> RevokePrincipal(Connection& connection, UtcTime now, const std::string& name,
                                                const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t key, PrincipalKey(connection, name));
  ASSIGN_OR_RETURN(PrincipalRecord present, GetPrincipal(connection, name));
  if (present.revoked_at) return present;
  RETURN_IF_ERROR(connection.Run("UPDATE principal SET revoked_at_utc_us = ?2 WHERE id = ?1", key, now));
  RETURN_IF_ERROR(connection.Run(
      "UPDATE token SET revoked_at_utc_us = ?2 WHERE principal_id = ?1 AND revoked_at_utc_us IS NULL", key, now));
  RETURN_IF_ERROR(
      AuditChange(connection, now, caller, "principal.revoke", PlaceOf(name), RolesText(present.grants), "revoked"));
  return GetPrincipal(connection, name);
}

absl::StatusOr<Page<PrincipalRecord>> ListPrincipals(Connection& connection, const PageRequest& request) {
  ASSIGN_OR_RETURN(const PageStart start, StartPage(request, "principals"));
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask(std::string(kSelectPrincipal) + "WHERE name > ?1 ORDER BY name LIMIT ?2",
                                  start.after.value_or(""), start.row_limit()));
  Page<PrincipalRecord> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    page.rows.push_back(ReadPrincipal(row));
    RETURN_IF_ERROR(ReadAll(connection, row.Int(5), page.rows.back()));
  }
  EndPage(
      start, [](const PrincipalRecord& record) { return record.name; },
      [](const PrincipalRecord& record) {
        constexpr size_t kTokenBytes = 200, kGrantBytes = 80;
        return record.note.size() + record.tokens.size() * kTokenBytes + record.grants.size() * kGrantBytes;
      },
      page);
  return page;
}

absl::StatusOr<TokenRecord> CreateToken(Connection& connection, UtcTime now, const NewToken& token,
                                        const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t key, LivePrincipalKey(connection, token.principal));
  RETURN_IF_ERROR(
      connection.Run("INSERT INTO token (principal_id, sha256, note, created_by, created_at_utc_us, expires_at_utc_us) "
                     "VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                     key, token.sha256, token.note, caller.principal, now, token.expires_at));
  const int64_t id = connection.last_insert_id();
  RETURN_IF_ERROR(
      AuditChange(connection, now, caller, "token.create", absl::StrCat(PlaceOf(token.principal), "/tokens/", id)));
  return GetToken(connection, id);
}

absl::StatusOr<TokenRecord> RevokeToken(Connection& connection, UtcTime now, int64_t id, const Caller& caller) {
  ASSIGN_OR_RETURN(TokenRecord present, GetToken(connection, id));
  if (present.revoked_at) return present;
  RETURN_IF_ERROR(connection.Run("UPDATE token SET revoked_at_utc_us = ?2 WHERE id = ?1", id, now));
  RETURN_IF_ERROR(
      AuditChange(connection, now, caller, "token.revoke", absl::StrCat(PlaceOf(present.principal), "/tokens/", id)));
  return GetToken(connection, id);
}

absl::Status TouchToken(Connection& connection, UtcTime now, int64_t id) {
  return connection.Run("UPDATE token SET last_used_at_utc_us = ?2 WHERE id = ?1", id, now);
}

absl::StatusOr<PrincipalRecord> ChangeRole(Connection& connection, UtcTime now, const std::string& name,
                                           const Grant& grant, bool holds, const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t key, LivePrincipalKey(connection, name));
  ASSIGN_OR_RETURN(const std::vector<Grant> before, ReadGrants(connection, key));
  if (grant.scope.kind == Scope::Kind::kMachine && holds)
    RETURN_IF_ERROR(MachineKey(connection, MachineId(grant.scope.name)).status());
  if (grant.scope.kind == Scope::Kind::kGroup) RETURN_IF_ERROR(CheckAccessName("group", grant.scope.name));
  const int role = static_cast<int>(grant.role), scope = static_cast<int>(grant.scope.kind);
  RETURN_IF_ERROR(
      holds ? connection.Run("INSERT OR IGNORE INTO principal_role (principal_id, role, scope, scope_name, created_by, "
                             "created_at_utc_us) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                             key, role, scope, grant.scope.name, caller.principal, now)
            : connection.Run(
                  "DELETE FROM principal_role WHERE principal_id = ?1 AND role = ?2 AND scope = ?3 AND scope_name = ?4",
                  key, role, scope, grant.scope.name));
  if (connection.changed_rows() > 0) {
    ASSIGN_OR_RETURN(const std::vector<Grant> after, ReadGrants(connection, key));
    RETURN_IF_ERROR(AuditChange(connection, now, caller, holds ? "role.grant" : "role.take", PlaceOf(name),
                                RolesText(before), RolesText(after)));
  }
  return GetPrincipal(connection, name);
}

absl::StatusOr<MachineAccess> ChangeGroup(Connection& connection, UtcTime now, const std::string& group,
                                          const MachineId& machine, bool belongs, const Caller& caller) {
  RETURN_IF_ERROR(CheckAccessName("group", group));
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  RETURN_IF_ERROR(
      belongs ? connection.Run("INSERT OR IGNORE INTO machine_group (name, machine_id) VALUES (?1, ?2)", group, key)
              : connection.Run("DELETE FROM machine_group WHERE name = ?1 AND machine_id = ?2", group, key));
  if (connection.changed_rows() > 0) {
    RETURN_IF_ERROR(AuditChange(connection, now, caller, belongs ? "group.add" : "group.remove",
                                absl::StrCat("groups/", group, "/machines/", machine.text())));
  }
  return AccessOf(connection, key);
}

absl::StatusOr<MachineAccess> SetFourEyes(Connection& connection, UtcTime now, const MachineId& machine, bool four_eyes,
                                          const Caller& caller) {
  ASSIGN_OR_RETURN(const int64_t key, MachineKey(connection, machine));
  ASSIGN_OR_RETURN(const MachineAccess present, AccessOf(connection, key));
  if (present.four_eyes == four_eyes) return present;
  RETURN_IF_ERROR(connection.Run("UPDATE machine SET four_eyes = ?2 WHERE id = ?1", key, four_eyes));
  RETURN_IF_ERROR(AuditChange(connection, now, caller, four_eyes ? "machine.four_eyes_on" : "machine.four_eyes_off",
                              "machines/" + machine.text(), four_eyes ? "one may do" : "four eyes",
                              four_eyes ? "four eyes" : "one may do"));
  return AccessOf(connection, key);
}

absl::StatusOr<Page<MachineAccess>> ListMachineAccess(Connection& connection, const PageRequest& request) {
  ASSIGN_OR_RETURN(const PageStart start, StartPage(request, "machine access"));
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id FROM machine WHERE name > ?1 AND deleted_at_utc_us IS NULL "
                                                 "ORDER BY name LIMIT ?2",
                                                 start.after.value_or(""), start.row_limit()));
  Page<MachineAccess> page;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) break;
    ASSIGN_OR_RETURN(MachineAccess access, AccessOf(connection, row.Int(0)));
    page.rows.push_back(std::move(access));
  }
  EndPage(
      start, [](const MachineAccess& access) { return access.machine.text(); },
      [](const MachineAccess& access) {
        size_t bytes = 0;
        for (const std::string& group : access.groups) bytes += group.size() + 2;
        return bytes;
      },
      page);
  return page;
}

absl::StatusOr<std::optional<Holder>> FindHolderOfToken(Connection& connection, const std::string& sha256) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT p.id, p.name, p.revoked_at_utc_us, t.id, t.expires_at_utc_us, "
                                  "t.last_used_at_utc_us, t.revoked_at_utc_us FROM token AS t JOIN principal AS p "
                                  "ON p.id = t.principal_id WHERE t.sha256 = ?1",
                                  sha256));
  return HolderIn(connection, std::move(row));
}

absl::StatusOr<std::optional<Holder>> FindHolderOfName(Connection& connection, const std::string& name) {
  ASSIGN_OR_RETURN(Statement row, connection.Ask("SELECT id, name, revoked_at_utc_us, NULL, NULL, NULL, NULL "
                                                 "FROM principal WHERE name = ?1",
                                                 name));
  return HolderIn(connection, std::move(row));
}

absl::StatusOr<Belonging> WhereBelongs(Connection& connection, const Resource& resource, const std::string& principal) {
  const std::string sql = OwnerSql(resource.kind);
  Belonging belonging;
  std::optional<int64_t> key;
  {
    ASSIGN_OR_RETURN(Statement row, resource.kind == ResourceKind::kMachine ? connection.Ask(sql, resource.name)
                                                                            : connection.Ask(sql, resource.number));
    ASSIGN_OR_RETURN(const bool found, row.Step());
    if (!found) return Missing(resource);
    if (!row.IsNull(0)) key = row.Int(0);
    belonging.created_by = row.Text(1);
  }
  if (resource.kind == ResourceKind::kProgram) return ProgramBelongs(connection, *key, principal);
  if (!key) return belonging;
  ASSIGN_OR_RETURN(MachineAccess access, AccessOf(connection, *key));
  belonging.machines.push_back(std::move(access));
  return belonging;
}

absl::StatusOr<std::vector<int64_t>> MachinesIn(Connection& connection, const std::vector<records::Scope>& scopes) {
  std::vector<int64_t> keys;
  for (const records::Scope& scope : scopes) {
    const std::string sql = scope.kind == Scope::Kind::kGroup ? "SELECT machine_id FROM machine_group WHERE name = ?1"
                                                              : "SELECT id FROM machine WHERE name = ?1";
    ASSIGN_OR_RETURN(Statement row, connection.Ask(sql, scope.name));
    while (true) {
      ASSIGN_OR_RETURN(const bool more, row.Step());
      if (!more) break;
      keys.push_back(row.Int(0));
    }
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

std::string JsonOf(const std::vector<int64_t>& ids) { return "[" + absl::StrJoin(ids, ",") + "]"; }

absl::StatusOr<std::string> NewestOfMachines(Connection& connection, const std::string& table,
                                             const std::vector<records::Scope>& scopes, int state, int64_t before,
                                             int64_t limit) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> machines, MachinesIn(connection, scopes));
  const std::string sql = absl::StrCat("SELECT id FROM ", table, " WHERE machine_id = ?1 AND id < ?2 AND id > ?3",
                                       state == 0 ? "" : " AND state = ?5", " ORDER BY id DESC LIMIT ?4");
  ASSIGN_OR_RETURN(const std::vector<int64_t> ids, NewestIds(connection, sql, machines, before, limit, state));
  return JsonOf(ids);
}

absl::StatusOr<LookedAt> LookAtNewest(Connection& connection, const std::string& table,
                                      const std::optional<int64_t>& machine, const Visible& visible, int state,
                                      int64_t before) {
  constexpr int64_t kMost = 1000;
  std::vector<int64_t> machines;
  if (machine.has_value()) {
    machines.push_back(*machine);
  } else if (!visible.everything) {
    ASSIGN_OR_RETURN(machines, MachinesIn(connection, visible.scopes));
  } else {
    machines.push_back(0);  // of all: it is not asked for
  }
  const bool is_of_all = visible.everything && !machine.has_value();
  const std::string sql =
      absl::StrCat("SELECT id FROM ", table, " WHERE ", is_of_all ? "" : "machine_id = ?1 AND ", "id < ?2 AND id > ?3",
                   state == 0 ? "" : " AND state = ?5", " ORDER BY id DESC LIMIT ?4");
  ASSIGN_OR_RETURN(const std::vector<int64_t> ids, NewestIds(connection, sql, machines, before, kMost, state));
  LookedAt looked = {JsonOf(ids)};
  if (static_cast<int64_t>(ids.size()) == kMost) looked.last = ids.back();
  return looked;
}

std::string InSpan(const std::string& time, const TimeSpan& span, int first_parameter) {
  return absl::StrCat(span.from ? absl::StrCat(" AND ", time, " >= ?", first_parameter) : "",
                      span.to ? absl::StrCat(" AND ", time, " < ?", first_parameter + 1) : "");
}

std::string TokenOf(const TimeSpan& span) {
  return absl::StrCat(span.from ? base::ToUtcUs(*span.from) : 0, "|", span.to ? base::ToUtcUs(*span.to) : 0);
}

}  // namespace axiscal::storage
