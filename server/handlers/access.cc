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
                   core.database.CreatePrincipal(request.name(), request.note(), {call.user, ""}));
  v1::CreatePrincipalResponse response;
  *response.mutable_principal() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::RevokePrincipalResponse> RevokePrincipal(Core& core, const Call& call,
                                                            const v1::RevokePrincipalRequest& request) {
  ASSIGN_OR_RETURN(const records::PrincipalRecord record,
                   core.database.RevokePrincipal(request.name(), {call.user, ""}));
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
  ASSIGN_OR_RETURN(const records::TokenRecord record, core.database.CreateToken(token, {call.user, ""}));
  v1::CreateTokenResponse response;
  response.set_secret(secret);
  *response.mutable_token() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::RevokeTokenResponse> RevokeToken(Core& core, const Call& call,
                                                    const v1::RevokeTokenRequest& request) {
  ASSIGN_OR_RETURN(const records::TokenRecord record, core.database.RevokeToken(request.token_id(), {call.user, ""}));
  v1::RevokeTokenResponse response;
  *response.mutable_token() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::ChangeRoleResponse> ChangeRole(Core& core, const Call& call, const v1::ChangeRoleRequest& request) {
  const absl::StatusOr<records::Grant> grant = convert::FromProto(request.grant());
  if (!grant.ok()) return convert::InField("grant", grant.status());
  ASSIGN_OR_RETURN(const records::PrincipalRecord record,
                   core.database.ChangeRole(request.principal(), *grant, request.holds(), {call.user, ""}));
  v1::ChangeRoleResponse response;
  *response.mutable_principal() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::ChangeGroupResponse> ChangeGroup(Core& core, const Call& call,
                                                    const v1::ChangeGroupRequest& request) {
  ASSIGN_OR_RETURN(
      const records::MachineAccess access,
      core.database.ChangeGroup(request.group(), MachineId(request.machine_id()), request.belongs(), {call.user, ""}));
  v1::ChangeGroupResponse response;
  *response.mutable_machine() = convert::ToProto(access);
  return response;
}

absl::StatusOr<v1::SetFourEyesResponse> SetFourEyes(Core& core, const Call& call,
                                                    const v1::SetFourEyesRequest& request) {
  ASSIGN_OR_RETURN(const records::MachineAccess access,
                   core.database.SetFourEyes(MachineId(request.machine_id()), request.four_eyes(), {call.user, ""}));
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

}  // namespace axiscal::handlers
