#include "server/handlers/access.h"

#include "proto/convert/access.h"
#include "proto/convert/field.h"
#include "server/access/gate.h"

namespace axiscal::handlers {
namespace {

constexpr size_t kMaxNoteBytes = 200;

}  // namespace

absl::StatusOr<v1::GetIdentityResponse> GetIdentity(Core& core, const Call& call,
                                                    const v1::GetIdentityRequest& request) {
  v1::GetIdentityResponse response;
  response.set_name(call.user);
  for (const records::Grant& grant : call.grants) *response.add_grants() = convert::ToProto(grant);
  return response;
}

absl::StatusOr<v1::CreatePrincipalResponse> CreatePrincipal(Core& core, const Call& call,
                                                            const v1::CreatePrincipalRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("note", request.note(), 0, kMaxNoteBytes));
  ASSIGN_OR_RETURN(const records::PrincipalRecord record,
                   core.database.CreatePrincipal(request.name(), request.note(), call.By()));
  v1::CreatePrincipalResponse response;
  *response.mutable_principal() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::RevokePrincipalResponse> RevokePrincipal(Core& core, const Call& call,
                                                            const v1::RevokePrincipalRequest& request) {
  ASSIGN_OR_RETURN(const records::PrincipalRecord record, core.database.RevokePrincipal(request.name(), call.By()));
  v1::RevokePrincipalResponse response;
  *response.mutable_principal() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::ListPrincipalsResponse> ListPrincipals(Core& core, const Call& call,
                                                          const v1::ListPrincipalsRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::PrincipalRecord> rows, core.database.ListPrincipals(page));
  v1::ListPrincipalsResponse response;
  for (const records::PrincipalRecord& row : rows.rows) *response.add_principals() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

absl::StatusOr<v1::CreateTokenResponse> CreateToken(Core& core, const Call& call,
                                                    const v1::CreateTokenRequest& request) {
  RETURN_IF_ERROR(convert::RequireText("note", request.note(), 0, kMaxNoteBytes));
  storage::NewToken token;
  token.principal = request.principal();
  token.note = request.note();
  if (request.has_expires_utc_us()) {
    if (request.expires_utc_us() <= base::ToUtcUs(base::SystemClock().UtcNow()))
      return convert::FieldError("expires_utc_us", "must be in the future");
    token.expires_at = base::FromUtcUs(request.expires_utc_us());
  }
  const std::string secret = access::NewToken();
  token.sha256 = access::HashOfToken(secret);
  ASSIGN_OR_RETURN(const records::TokenRecord record, core.database.CreateToken(token, call.By()));
  v1::CreateTokenResponse response;
  response.set_secret(secret);
  *response.mutable_token() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::RevokeTokenResponse> RevokeToken(Core& core, const Call& call,
                                                    const v1::RevokeTokenRequest& request) {
  ASSIGN_OR_RETURN(const records::TokenRecord record, core.database.RevokeToken(request.token_id(), call.By()));
  v1::RevokeTokenResponse response;
  *response.mutable_token() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::ChangeRoleResponse> ChangeRole(Core& core, const Call& call, const v1::ChangeRoleRequest& request) {
  const absl::StatusOr<records::Grant> grant = convert::FromProto(request.grant());
  if (!grant.ok()) return convert::InField("grant", grant.status());
  ASSIGN_OR_RETURN(const records::PrincipalRecord record,
                   core.database.ChangeRole(request.principal(), *grant, request.holds(), call.By()));
  v1::ChangeRoleResponse response;
  *response.mutable_principal() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::ChangeGroupResponse> ChangeGroup(Core& core, const Call& call,
                                                    const v1::ChangeGroupRequest& request) {
  ASSIGN_OR_RETURN(
      const records::MachineAccess access,
      core.database.ChangeGroup(request.group(), MachineId(request.machine_id()), request.belongs(), call.By()));
  v1::ChangeGroupResponse response;
  *response.mutable_machine() = convert::ToProto(access);
  return response;
}

absl::StatusOr<v1::SetFourEyesResponse> SetFourEyes(Core& core, const Call& call,
                                                    const v1::SetFourEyesRequest& request) {
  ASSIGN_OR_RETURN(const records::MachineAccess access,
                   core.database.SetFourEyes(MachineId(request.machine_id()), request.four_eyes(), call.By()));
  v1::SetFourEyesResponse response;
  *response.mutable_machine() = convert::ToProto(access);
  return response;
}

absl::StatusOr<v1::ListMachineAccessResponse> ListMachineAccess(Core& core, const Call& call,
                                                                const v1::ListMachineAccessRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<records::MachineAccess> rows, core.database.ListMachineAccess(page));
  v1::ListMachineAccessResponse response;
  for (const records::MachineAccess& row : rows.rows) *response.add_machines() = convert::ToProto(row);
  response.set_next_page_token(rows.next_token);
  return response;
}

absl::StatusOr<v1::ListAuditResponse> ListAudit(Core& core, const Call& call, const v1::ListAuditRequest& request) {
  storage::AuditFilter filter;
  if (request.has_from_utc_us()) filter.from = base::FromUtcUs(request.from_utc_us());
  if (request.has_to_utc_us()) filter.to = base::FromUtcUs(request.to_utc_us());
  filter.principal = request.principal();
  filter.resource = request.resource();
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  ASSIGN_OR_RETURN(const records::Page<storage::AuditEntry> rows, core.database.ListAudit(filter, page));
  v1::ListAuditResponse response;
  for (const storage::AuditEntry& row : rows.rows) {
    v1::AuditEntry& entry = *response.add_entries();
    entry.set_entry_number(row.id);
    entry.set_at_utc_us(base::ToUtcUs(row.at));
    entry.set_principal(row.principal);
    entry.set_peer(row.peer);
    entry.set_action(row.action);
    entry.set_resource(row.resource);
    entry.set_outcome(row.outcome);
    entry.set_was(row.was);
    entry.set_became(row.became);
    entry.set_detail(row.detail);
  }
  response.set_next_page_token(rows.next_token);
  return response;
}

absl::StatusOr<v1::CheckAuditResponse> CheckAudit(Core& core, const Call& call, const v1::CheckAuditRequest& request) {
  ASSIGN_OR_RETURN(const storage::AuditHead head, core.database.CheckAudit());
  v1::CheckAuditResponse response;
  response.set_last_entry_number(head.id);
  response.set_sha256(head.sha256);
  return response;
}

}  // namespace axiscal::handlers
