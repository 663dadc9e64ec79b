// Who may do what: principals (people, cells), their roles and tokens, and what is said of machines for it.
#ifndef AXISCAL_CORE_RECORDS_ACCESS_H_
#define AXISCAL_CORE_RECORDS_ACCESS_H_

#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"

namespace axiscal::records {

// Never renumber.
enum class Role {
  kViewer = 1,      // reads
  kCell = 2,        // uploads for its machines
  kTechnician = 3,  // jobs, programs, tables; a viewer too
  kApprover = 4,    // approves and retires calibrations; a viewer too
  kAdmin = 5,       // machines, principals; a technician, a cell and a viewer too, no approver
};
inline constexpr Role kAllRoles[] = {Role::kViewer, Role::kCell, Role::kTechnician, Role::kApprover, Role::kAdmin};

// "viewer", "cell", "technician", "approver", "admin".
std::string NameOf(Role role);
std::optional<Role> RoleNamed(const std::string& name);

// For which machines a role holds.
struct Scope {
  enum class Kind { kAll = 1, kGroup = 2, kMachine = 3 };  // Never renumber.
  Kind kind = Kind::kAll;
  std::string name;  // of the group or machine; empty for all

  auto operator<=>(const Scope&) const = default;
};
// "all machines", "group turning", "machine mt".
std::string TextOf(const Scope& scope);

struct Grant {
  Role role = Role::kViewer;
  Scope scope;

  auto operator<=>(const Grant&) const = default;
};

// A token without its secret.
struct TokenRecord {
  int64_t id = 0;
  std::string principal;
  std::string note;
  std::string created_by;
  base::UtcTime created_at;
  std::optional<base::UtcTime> expires_at, last_used_at, revoked_at;
};

struct PrincipalRecord {
  std::string name;
  std::string note;
  std::string created_by;
  base::UtcTime created_at;
  std::optional<base::UtcTime> revoked_at;  // for ever: the name does not come back
  std::vector<Grant> grants;
  std::vector<TokenRecord> tokens;
};

struct MachineAccess {
  MachineId machine;
  std::vector<std::string> groups;
  // Whoever identified a calibration may not approve it.
  bool four_eyes = false;
};

// What a principal's, group's name must be: 1 to 64 letters, digits, '.', '_', '@', '-', with a letter or digit at both
// ends. So no name of a principal is "local:LOGIN".
bool IsAccessName(const std::string& name);

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_ACCESS_H_
