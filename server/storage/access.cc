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
  ASSIGN_OR_RETURN(access.groups, GroupsOf(connection, machine_key));
  return access;
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

absl::StatusOr<std::vector<std::string>> GroupsOf(Connection& connection, int64_t machine_key) {
  ASSIGN_OR_RETURN(Statement row,
                   connection.Ask("SELECT name FROM machine_group WHERE machine_id = ?1 ORDER BY name", machine_key));
  std::vector<std::string> groups;
  while (true) {
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return groups;
    groups.push_back(row.Text(0));
  }
}

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
  ASSIGN_OR_RETURN(const int64_t id,
                   connection.Insert("INSERT INTO token (principal_id, sha256, note, created_by, created_at_utc_us, "
                                     "expires_at_utc_us) VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                                     key, token.sha256, token.note, caller.principal, now, token.expires_at));
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
      holds ? connection.Run("INSERT INTO principal_role (principal_id, role, scope, scope_name, created_by, "
                             "created_at_utc_us) VALUES (?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO NOTHING",
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
      belongs ? connection.Run("INSERT INTO machine_group (name, machine_id) VALUES (?1, ?2) ON CONFLICT DO NOTHING",
                               group, key)
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

namespace {

// The newest of some rows below a number: all from `reached` on, falling. 0: there are no more.
struct Newest {
  std::vector<int64_t> ids;
  int64_t reached = 0;

  // Of ids that NewestIds() has found, kMostLookedAt at most.
  static Newest Of(std::vector<int64_t> ids) {
    const int64_t reached = static_cast<int64_t>(ids.size()) < kMostLookedAt ? 0 : ids.back();
    return {std::move(ids), reached};
  }
};

// Whether a page that looks at one gets farther than with the other, or looks at fewer rows.
bool IsNarrower(const Newest& one, const Newest& other) {
  return one.reached != other.reached ? one.reached < other.reached : one.ids.size() < other.ids.size();
}

constexpr int kBlockBits = 10;           // of the indices TABLE_at and TABLE_of_machine_at: id >> 10
constexpr int64_t kMostBlocks = 1024;    // that a page looks at, of all machines
constexpr int64_t kFewestOfMachine = 8;  // ... of one, however many there are

std::string InSpan(const std::string& time, const TimeSpan& span, int first_parameter) {
  return absl::StrCat(span.from ? absl::StrCat(" AND ", time, " >= ?", first_parameter) : "",
                      span.to ? absl::StrCat(" AND ", time, " < ?", first_parameter + 1) : "");
}

// Statements on an index by blocks of numbers: ?1 is the machine, ?2 and ?3 are the span, ?4 is the block.
struct OfBlocks {
  std::string rows;    // of a block, in the span
  std::string before;  // the number of the block before it that has any row
};

OfBlocks BlocksOf(const std::string& table, bool is_of_all, const Narrowing& narrowing) {
  const std::string from_where = absl::StrCat(" FROM ", table, " INDEXED BY ", table, is_of_all ? "" : "_of_machine",
                                              "_at WHERE ", is_of_all ? "" : "machine_id = ?1 AND ");
  const std::string block = absl::StrCat("id >> ", kBlockBits);
  return {absl::StrCat("SELECT id", from_where, block, " = ?4", InSpan(narrowing.time, narrowing.span, 2)),
          absl::StrCat("SELECT ", block, from_where, block, " < ?4 ORDER BY ", block, " DESC LIMIT 1")};
}

// Of one machine, adding to what others have: looks at blocks from `before` down, at `most` of them, and no farther
// than where enough was found.
absl::Status AddInSpan(Connection& connection, const OfBlocks& sql, int64_t machine, int64_t before, int64_t most,
                       const TimeSpan& span, Newest* newest) {
  std::vector<int64_t>& ids = newest->ids;
  int64_t found = 0;
  for (int64_t block = (before - 1) >> kBlockBits, looked = 0;; ++looked) {
    const int64_t last = (block << kBlockBits) | ((1 << kBlockBits) - 1);  // number of the block
    if (last < newest->reached) return absl::OkStatus();
    if (looked == most || found >= kMostLookedAt) {
      newest->reached = last + 1;
      return absl::OkStatus();
    }
    {
      ASSIGN_OR_RETURN(Statement row, connection.Ask(sql.rows, machine, span.from, span.to, block));
      while (true) {
        ASSIGN_OR_RETURN(const bool more, row.Step());
        if (!more) break;
        if (row.Int(0) < before) ids.push_back(row.Int(0)), ++found;
      }
    }
    ASSIGN_OR_RETURN(Statement row, connection.Ask(sql.before, machine, span.from, span.to, block));
    ASSIGN_OR_RETURN(const bool more, row.Step());
    if (!more) return absl::OkStatus();
    block = row.Int(0);
  }
}

absl::StatusOr<Newest> NewestInSpan(Connection& connection, const OfBlocks& sql, const std::vector<int64_t>& machines,
                                    int64_t before, const TimeSpan& span) {
  Newest newest;
  const int64_t most = std::max(kFewestOfMachine, kMostBlocks / std::max<int64_t>(1, std::ssize(machines)));
  for (const int64_t machine : machines) {
    RETURN_IF_ERROR(AddInSpan(connection, sql, machine, before, most, span, &newest));
    std::sort(newest.ids.begin(), newest.ids.end(), std::greater<>());
    if (std::ssize(newest.ids) < kMostLookedAt) continue;
    newest.ids.resize(kMostLookedAt);
    newest.reached = std::max(newest.reached, newest.ids.back());
  }
  while (!newest.ids.empty() && newest.ids.back() < newest.reached) newest.ids.pop_back();
  return newest;
}

}  // namespace

absl::StatusOr<LookedAt> LookAtNarrowest(Connection& connection, const std::string& table,
                                         const std::optional<int64_t>& machine, const Visible& visible, int state,
                                         int64_t before, const Narrowing& narrowing) {
  const bool is_of_all = visible.everything && !machine.has_value();
  std::vector<int64_t> machines;
  LookedAt looked;
  if (machine.has_value()) {
    machines.push_back(*machine);
  } else if (!visible.everything) {
    ASSIGN_OR_RETURN(machines, MachinesIn(connection, visible.scopes));
    looked.machines = JsonOf(machines);
  } else {
    machines.push_back(0);  // of all: it is not asked for
  }
  const std::string of = is_of_all ? "" : "machine_id = ?1 AND ";
  const std::string by_index = table + (is_of_all ? "" : "_of_machine");
  const std::string newest = "id < ?2 AND id > ?3";
  ASSIGN_OR_RETURN(std::vector<int64_t> ids,
                   NewestIds(connection,
                             absl::StrCat("SELECT id FROM ", table, " WHERE ", of, newest,
                                          state == 0 ? "" : " AND state = ?5", " ORDER BY id DESC LIMIT ?4"),
                             machines, before, kMostLookedAt, state));
  Newest narrowest = Newest::Of(std::move(ids));
  const auto take = [&](Newest other) {
    if (IsNarrower(other, narrowest)) narrowest = std::move(other);
  };
  for (const Narrowing::Text& one : narrowing.texts) {
    const std::string sql = absl::StrCat("SELECT id FROM ", table, " INDEXED BY ", by_index, "_with_", one.column,
                                         " WHERE ", of, one.column, " = ?5 AND ", newest, " ORDER BY id DESC LIMIT ?4");
    ASSIGN_OR_RETURN(std::vector<int64_t> with, NewestIds(connection, sql, machines, before, kMostLookedAt, one.text));
    take(Newest::Of(std::move(with)));
  }
  if (narrowing.linked.has_value()) take(Newest::Of(*narrowing.linked));
  if (!narrowing.span.is_all()) {
    ASSIGN_OR_RETURN(Newest within,
                     NewestInSpan(connection, BlocksOf(table, is_of_all, narrowing), machines, before, narrowing.span));
    take(std::move(within));
  }
  looked.ids = JsonOf(narrowest.ids);
  if (narrowest.reached > 0) looked.last = narrowest.reached;
  return looked;
}

std::string HeldTo(const std::string& alias, const LookedAt& looked, bool has_machine, int state,
                   const std::string& time, const TimeSpan& span) {
  return absl::StrCat(
      "WHERE ", alias, ".id IN (SELECT value FROM json_each(?5))",
      has_machine ? absl::StrCat(" AND +", alias, ".machine_id = ?2") : "",
      state != 0 ? absl::StrCat(" AND +", alias, ".state = ?3") : "", InSpan(time, span, 6),
      looked.machines.empty() ? "" : absl::StrCat(" AND +", alias, ".machine_id IN (SELECT value FROM json_each(?8))"));
}

std::string TokenOf(const TimeSpan& span) {
  return absl::StrCat(span.from ? base::ToUtcUs(*span.from) : 0, "|", span.to ? base::ToUtcUs(*span.to) : 0);
}

}  // namespace axiscal::storage
