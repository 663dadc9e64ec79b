#include "server/access/gate.h"

#include <unistd.h>

#include <algorithm>

#include "absl/strings/cord.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_join.h"
#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "server/storage/refusal.h"

namespace axiscal::access {
namespace {

using records::Grant;
using records::Role;
using records::Scope;
using storage::Belonging;
using storage::Resource;

// The last use of a token is written down so often.
constexpr std::chrono::minutes kTouchAfter(1);
constexpr char kBearer[] = "Bearer ";

absl::Status Unauthenticated(const std::string& text, const std::string& reason) {
  return base::Error(absl::StatusCode::kUnauthenticated, text, {reason, {}});
}

bool IsEnough(const MethodRule& rule, Role held) {
  return std::any_of(rule.any_of.begin(), rule.any_of.end(), [&](Role needed) { return Includes(held, needed); });
}

bool Covers(const Scope& scope, const Belonging& belonging) {
  if (scope.kind == Scope::Kind::kAll || belonging.is_own) return true;
  return std::any_of(belonging.machines.begin(), belonging.machines.end(), [&](const records::MachineAccess& access) {
    return scope.kind == Scope::Kind::kMachine
               ? access.machine.text() == scope.name
               : std::find(access.groups.begin(), access.groups.end(), scope.name) != access.groups.end();
  });
}

// `where`: "machine mt", "session 12", "all machines", "any machine".
absl::Status RoleMissing(const Identity& identity, const MethodRule& rule, const std::string& where) {
  const std::string roles =
      absl::StrJoin(rule.any_of, " or ", [](std::string* out, Role role) { *out += records::NameOf(role); });
  return base::Error(
      absl::StatusCode::kPermissionDenied,
      absl::StrCat(identity.name, " may not call ", rule.method, ": it needs the role ", roles, " for ", where),
      {"ROLE_MISSING", {{"role", roles}, {"method", rule.method}}});
}

std::string TextOf(const Resource& named) {
  switch (named.kind) {
    case storage::ResourceKind::kMachine:
      return "machine " + named.name;
    case storage::ResourceKind::kSession:
      return absl::StrCat("session ", named.number);
    case storage::ResourceKind::kJob:
      return absl::StrCat("job ", named.number);
    case storage::ResourceKind::kCalibration:
      return absl::StrCat("calibration ", named.number);
    case storage::ResourceKind::kProgram:
      return absl::StrCat("program ", named.number);
    case storage::ResourceKind::kMark:
      return absl::StrCat("mark ", named.number);
    case storage::ResourceKind::kEvent:
      return absl::StrCat("event ", named.number);
  }
  return "";
}

constexpr char kDeniedUrl[] = "axiscal/denied-resource";

std::string PlaceOf(const Resource& named) {
  switch (named.kind) {
    case storage::ResourceKind::kMachine:
      return "machines/" + named.name;
    case storage::ResourceKind::kSession:
      return absl::StrCat("sessions/", named.number);
    case storage::ResourceKind::kJob:
      return absl::StrCat("jobs/", named.number);
    case storage::ResourceKind::kCalibration:
      return absl::StrCat("calibrations/", named.number);
    case storage::ResourceKind::kProgram:
      return absl::StrCat("programs/", named.number);
    case storage::ResourceKind::kMark:
      return absl::StrCat("marks/", named.number);
    case storage::ResourceKind::kEvent:
      return absl::StrCat("events/", named.number);
  }
  return "";
}

absl::Status Denied(const Resource& named, absl::Status status) {
  status.SetPayload(kDeniedUrl, absl::Cord(PlaceOf(named)));
  return status;
}

}  // namespace

std::optional<std::string> DeniedResource(const absl::Status& status) {
  const absl::optional<absl::Cord> resource = status.GetPayload(kDeniedUrl);
  if (!resource) return std::nullopt;
  return std::string(*resource);
}

std::string NewToken() {
  std::string bytes(32, '\0');
  DEMAND(getentropy(bytes.data(), bytes.size()) == 0);
  return "axt_" + absl::WebSafeBase64Escape(bytes);
}

std::string HashOfToken(const std::string& token) { return base::Sha256Hex(token); }

absl::StatusOr<Identity> Gate::Identify(const Credentials& credentials) const {
  if (!asks_) return Identity{"local:" + credentials.login, true, {}};
  const base::UtcTime now = clock_.UtcNow();
  if (credentials.authorization) {
    const absl::Status invalid =
        Unauthenticated("the token is not known, its time is over, or it was revoked", "TOKEN_INVALID");
    if (credentials.authorization->rfind(kBearer, 0) != 0) return invalid;
    const std::string token = credentials.authorization->substr(sizeof(kBearer) - 1);
    ASSIGN_OR_RETURN(const std::optional<storage::Holder> holder, database_.FindHolderOfToken(HashOfToken(token)));
    if (!holder || holder->is_revoked || (holder->token_expires_at && *holder->token_expires_at <= now)) return invalid;
    if (!holder->token_last_used_at || now - *holder->token_last_used_at >= kTouchAfter) {
      // A full disk keeps nobody out.
      static_cast<void>(database_.TouchToken(*holder->token));
    }
    return Identity{holder->principal, false, holder->grants};
  }
  if (!credentials.certificate_name) {
    return Unauthenticated("who calls must show a certificate or a token", "IDENTITY_MISSING");
  }
  const std::string& name = *credentials.certificate_name;
  if (credentials.certificate_ends && *credentials.certificate_ends <= now)
    return Unauthenticated("the certificate of " + name + " has ended", "CERTIFICATE_ENDED");
  ASSIGN_OR_RETURN(const std::optional<storage::Holder> holder, database_.FindHolderOfName(name));
  if (!holder || holder->is_revoked) {
    return Unauthenticated("the certificate names " + name + ", which is no principal here, or was revoked",
                           "PRINCIPAL_UNKNOWN");
  }
  return Identity{holder->principal, false, holder->grants};
}

absl::StatusOr<storage::Visible> Gate::Admit(const Identity& identity, const std::string& method,
                                             const std::optional<std::vector<Resource>>& named) const {
  const MethodRule* const rule = FindMethod(method);
  if (rule == nullptr) {
    return base::Error(absl::StatusCode::kPermissionDenied, "nobody may call " + method + ": it is not in the table",
                       {"METHOD_NOT_PLACED", {{"method", method}}});
  }
  const auto holds = [&](bool for_all) {
    return std::any_of(identity.grants.begin(), identity.grants.end(), [&](const Grant& grant) {
      return IsEnough(*rule, grant.role) && (!for_all || grant.scope.kind == Scope::Kind::kAll);
    });
  };
  const bool holds_for_all = identity.is_local || rule->reach == Reach::kAnyone || holds(true);
  if (rule->reach == Reach::kService && !holds_for_all) return RoleMissing(identity, *rule, "all machines");
  if (!named || (holds_for_all && !rule->four_eyes)) return storage::Visible{holds_for_all, {}, {}};
  for (const Resource& resource : *named) RETURN_IF_ERROR(AdmitNamed(identity, *rule, resource));
  if (holds_for_all) return storage::Visible{};
  if (!holds(false)) return RoleMissing(identity, *rule, "any machine");
  storage::Visible visible{false, {}, identity.name};
  for (const Grant& grant : identity.grants) {
    if (IsEnough(*rule, grant.role)) visible.scopes.push_back(grant.scope);
  }
  return visible;
}

absl::Status Gate::MayStill(const std::string& name, const std::string& method,
                            const std::vector<Resource>& named) const {
  ASSIGN_OR_RETURN(const std::optional<storage::Holder> holder, database_.FindHolderOfName(name));
  if (!holder) return absl::OkStatus();
  if (holder->is_revoked) return Unauthenticated(name + " was revoked", "PRINCIPAL_UNKNOWN");
  return Admit({name, false, holder->grants}, method, named).status();
}

absl::Status Gate::AdmitNamed(const Identity& identity, const MethodRule& rule, const Resource& named) const {
  ASSIGN_OR_RETURN(const Belonging belonging, database_.WhereBelongs(named, identity.name));
  bool is_in_scope = identity.is_local, is_enough = identity.is_local;
  for (const Grant& grant : identity.grants) {
    if (!Covers(grant.scope, belonging)) continue;
    is_in_scope = true;
    is_enough |= IsEnough(rule, grant.role);
  }
  if (!is_in_scope) return Denied(named, storage::Missing(named));
  if (!is_enough) return Denied(named, RoleMissing(identity, rule, TextOf(named)));
  const bool is_calibration = named.kind == storage::ResourceKind::kCalibration;
  if (!rule.four_eyes || !is_calibration || belonging.machines.empty()) return absl::OkStatus();
  const records::MachineAccess& machine = belonging.machines.front();
  if (!machine.four_eyes || belonging.created_by != identity.name) return absl::OkStatus();
  return Denied(named, base::Error(absl::StatusCode::kPermissionDenied,
                                   absl::StrCat(TextOf(named), " was identified by ", identity.name, ": machine ",
                                                machine.machine.text(), " asks that another person approves it"),
                                   {"FOUR_EYES", {{"machine", machine.machine.text()}, {"principal", identity.name}}}));
}

}  // namespace axiscal::access
