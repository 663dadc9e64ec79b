#include "proto/convert/access.h"

#include "proto/convert/field.h"
#include "proto/convert/time.h"

namespace axiscal::convert {
absl::StatusOr<records::Scope> FromProto(const v1::Scope& message) {
  switch (message.of_case()) {
    case v1::Scope::kAll:
      if (!message.all()) break;
      return records::Scope{records::Scope::Kind::kAll, ""};
    case v1::Scope::kGroup:
      RETURN_IF_ERROR(RequireText("scope.group", message.group(), 1, 64));
      return records::Scope{records::Scope::Kind::kGroup, message.group()};
    case v1::Scope::kMachine:
      RETURN_IF_ERROR(RequireText("scope.machine", message.machine(), 1, 1000));
      return records::Scope{records::Scope::Kind::kMachine, message.machine()};
    default:
      break;
  }
  return FieldError("scope", "exactly one of all (true), group and machine must be set");
}

v1::Scope ToProto(const records::Scope& scope) {
  v1::Scope message;
  switch (scope.kind) {
    case records::Scope::Kind::kAll:
      message.set_all(true);
      break;
    case records::Scope::Kind::kGroup:
      message.set_group(scope.name);
      break;
    case records::Scope::Kind::kMachine:
      message.set_machine(scope.name);
      break;
  }
  return message;
}

v1::Grant ToProto(const records::Grant& grant) {
  v1::Grant message;
  message.set_role(static_cast<v1::Role>(grant.role));
  *message.mutable_scope() = ToProto(grant.scope);
  return message;
}

v1::Token ToProto(const records::TokenRecord& token) {
  v1::Token message;
  message.set_token_id(token.id);
  message.set_principal(token.principal);
  message.set_note(token.note);
  message.set_created_by(token.created_by);
  message.set_created_utc_us(base::ToUtcUs(token.created_at));
  SET_OPTIONAL_UTC(message, expires_utc_us, token.expires_at);
  SET_OPTIONAL_UTC(message, last_used_utc_us, token.last_used_at);
  SET_OPTIONAL_UTC(message, revoked_utc_us, token.revoked_at);
  return message;
}

v1::Principal ToProto(const records::PrincipalRecord& principal) {
  v1::Principal message;
  message.set_name(principal.name);
  message.set_note(principal.note);
  message.set_created_by(principal.created_by);
  message.set_created_utc_us(base::ToUtcUs(principal.created_at));
  SET_OPTIONAL_UTC(message, revoked_utc_us, principal.revoked_at);
  for (const records::Grant& grant : principal.grants) *message.add_grants() = ToProto(grant);
  for (const records::TokenRecord& token : principal.tokens) *message.add_tokens() = ToProto(token);
  return message;
}

v1::MachineAccess ToProto(const records::MachineAccess& access) {
  v1::MachineAccess message;
  message.set_machine_id(access.machine.text());
  for (const std::string& group : access.groups) message.add_groups(group);
  message.set_four_eyes(access.four_eyes);
  return message;
}

absl::StatusOr<records::Grant> FromProto(const v1::Grant& message) {
  if (!v1::Role_IsValid(message.role()) || message.role() == v1::ROLE_UNSPECIFIED)
    return FieldError("role", absl::StrCat(static_cast<int>(message.role()), " is no role"));
  ASSIGN_OR_RETURN(records::Scope scope, FromProto(message.scope()));
  return records::Grant{static_cast<records::Role>(message.role()), std::move(scope)};
}

absl::StatusOr<records::TokenRecord> FromProto(const v1::Token& message) {
  RETURN_IF_ERROR(RequirePositive("token_id", message.token_id()));
  return records::TokenRecord{message.token_id(),
                              message.principal(),
                              message.note(),
                              message.created_by(),
                              base::FromUtcUs(message.created_utc_us()),
                              OPTIONAL_UTC(message, expires_utc_us),
                              OPTIONAL_UTC(message, last_used_utc_us),
                              OPTIONAL_UTC(message, revoked_utc_us)};
}

absl::StatusOr<records::PrincipalRecord> FromProto(const v1::Principal& message) {
  records::PrincipalRecord record;
  record.name = message.name();
  record.note = message.note();
  record.created_by = message.created_by();
  record.created_at = base::FromUtcUs(message.created_utc_us());
  record.revoked_at = OPTIONAL_UTC(message, revoked_utc_us);
  for (const v1::Grant& grant : message.grants()) {
    ASSIGN_OR_RETURN(records::Grant one, FromProto(grant));
    record.grants.push_back(std::move(one));
  }
  for (const v1::Token& token : message.tokens()) {
    ASSIGN_OR_RETURN(records::TokenRecord one, FromProto(token));
    record.tokens.push_back(std::move(one));
  }
  return record;
}

absl::StatusOr<records::MachineAccess> FromProto(const v1::MachineAccess& message) {
  return records::MachineAccess{
      MachineId(message.machine_id()), {message.groups().begin(), message.groups().end()}, message.four_eyes()};
}

}  // namespace axiscal::convert
