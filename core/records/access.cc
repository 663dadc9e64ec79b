#include "core/records/access.h"

#include <algorithm>

namespace axiscal::records {

std::string NameOf(Role role) {
  switch (role) {
    case Role::kViewer:
      return "viewer";
    case Role::kCell:
      return "cell";
    case Role::kTechnician:
      return "technician";
    case Role::kApprover:
      return "approver";
    case Role::kAdmin:
      return "admin";
  }
  return "";
}

std::optional<Role> RoleNamed(const std::string& name) {
  for (const Role role : kAllRoles) {
    if (NameOf(role) == name) return role;
  }
  return std::nullopt;
}

std::string TextOf(const Scope& scope) {
  switch (scope.kind) {
    case Scope::Kind::kAll:
      return "all machines";
    case Scope::Kind::kGroup:
      return "group " + scope.name;
    case Scope::Kind::kMachine:
      return "machine " + scope.name;
  }
  return "";
}

bool IsAccessName(const std::string& name) {
  constexpr size_t kMaxBytes = 64;
  const auto is_alphanumeric = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
  };
  const auto is_inside = [&](char c) { return is_alphanumeric(c) || c == '.' || c == '_' || c == '@' || c == '-'; };
  return !name.empty() && name.size() <= kMaxBytes && is_alphanumeric(name.front()) && is_alphanumeric(name.back()) &&
         std::all_of(name.begin(), name.end(), is_inside);
}

}  // namespace axiscal::records
