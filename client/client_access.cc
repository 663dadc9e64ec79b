// Who may do what.
#include "client/client_impl.h"

namespace axiscal::client {

absl::StatusOr<PrincipalRecord> Client::GetIdentity() {
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::GetIdentityResponse>(
                                            *impl_->access, &v1::Access::Stub::GetIdentity, v1::GetIdentityRequest()));
  PrincipalRecord record;
  record.name = response.name();
  for (const v1::Grant& grant : response.grants()) {
    ASSIGN_OR_RETURN(records::Grant one, convert::FromProto(grant));
    record.grants.push_back(std::move(one));
  }
  return record;
}

absl::StatusOr<PrincipalRecord> Client::CreatePrincipal(const std::string& name, const std::string& note) {
  v1::CreatePrincipalRequest request;
  request.set_name(name);
  request.set_note(note);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::CreatePrincipalResponse>(
                                            *impl_->access, &v1::Access::Stub::CreatePrincipal, request));
  return convert::FromProto(response.principal());
}

absl::StatusOr<PrincipalRecord> Client::RevokePrincipal(const std::string& name) {
  v1::RevokePrincipalRequest request;
  request.set_name(name);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::RevokePrincipalResponse>(
                                            *impl_->access, &v1::Access::Stub::RevokePrincipal, request));
  return convert::FromProto(response.principal());
}

absl::StatusOr<Page<PrincipalRecord>> Client::ListPrincipals(const PageRequest& page) {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListPrincipalsResponse>(*impl_->access, &v1::Access::Stub::ListPrincipals,
                                                           PageOf<v1::ListPrincipalsRequest>(page)));
  return ReadPage<PrincipalRecord>(response.principals(), response.next_page_token());
}

absl::StatusOr<NewToken> Client::CreateToken(const std::string& principal, const std::string& note,
                                             const std::optional<base::UtcTime>& expires_at) {
  v1::CreateTokenRequest request;
  request.set_principal(principal);
  request.set_note(note);
  if (expires_at) request.set_expires_utc_us(base::ToUtcUs(*expires_at));
  // Not tried again by itself: each time would make one more.
  v1::CreateTokenResponse response;
  const auto context =
      impl_->connection.NewContext(base::SystemClock().SteadyNow() + impl_->connection.options().call_deadline);
  RETURN_IF_ERROR(impl_->connection.FromGrpc(impl_->access->CreateToken(context.get(), request, &response)));
  ASSIGN_OR_RETURN(TokenRecord record, convert::FromProto(response.token()));
  return NewToken{response.secret(), std::move(record)};
}

absl::StatusOr<TokenRecord> Client::RevokeToken(int64_t id) {
  v1::RevokeTokenRequest request;
  request.set_token_id(id);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::RevokeTokenResponse>(*impl_->access, &v1::Access::Stub::RevokeToken, request));
  return convert::FromProto(response.token());
}

absl::StatusOr<PrincipalRecord> Client::ChangeRole(const std::string& principal, const records::Grant& grant,
                                                   bool holds) {
  v1::ChangeRoleRequest request;
  request.set_principal(principal);
  *request.mutable_grant() = convert::ToProto(grant);
  request.set_holds(holds);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ChangeRoleResponse>(*impl_->access, &v1::Access::Stub::ChangeRole, request));
  return convert::FromProto(response.principal());
}

absl::StatusOr<MachineAccess> Client::ChangeGroup(const std::string& group, const MachineId& machine, bool belongs) {
  v1::ChangeGroupRequest request;
  request.set_group(group);
  request.set_machine_id(machine.text());
  request.set_belongs(belongs);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ChangeGroupResponse>(*impl_->access, &v1::Access::Stub::ChangeGroup, request));
  return convert::FromProto(response.machine());
}

absl::StatusOr<MachineAccess> Client::SetFourEyes(const MachineId& machine, bool four_eyes) {
  v1::SetFourEyesRequest request;
  request.set_machine_id(machine.text());
  request.set_four_eyes(four_eyes);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::SetFourEyesResponse>(*impl_->access, &v1::Access::Stub::SetFourEyes, request));
  return convert::FromProto(response.machine());
}

absl::StatusOr<Page<MachineAccess>> Client::ListMachineAccess(const PageRequest& page) {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListMachineAccessResponse>(*impl_->access, &v1::Access::Stub::ListMachineAccess,
                                                              PageOf<v1::ListMachineAccessRequest>(page)));
  return ReadPage<MachineAccess>(response.machines(), response.next_page_token());
}

absl::StatusOr<Page<AuditEntry>> Client::ListAudit(const AuditFilter& filter, const PageRequest& page) {
  auto request = PageOf<v1::ListAuditRequest>(page);
  if (filter.from) request.set_from_utc_us(base::ToUtcUs(*filter.from));
  if (filter.to) request.set_to_utc_us(base::ToUtcUs(*filter.to));
  request.set_principal(filter.principal);
  request.set_resource(filter.resource);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListAuditResponse>(*impl_->access, &v1::Access::Stub::ListAudit, request));
  Page<AuditEntry> entries;
  entries.next_token = response.next_page_token();
  for (const v1::AuditEntry& entry : response.entries()) {
    entries.rows.push_back({entry.entry_number(), base::FromUtcUs(entry.at_utc_us()), entry.principal(), entry.peer(),
                            entry.action(), entry.resource(), entry.outcome(), entry.was(), entry.became(),
                            entry.detail()});
  }
  return entries;
}

absl::StatusOr<AuditHead> Client::CheckAudit() {
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::CheckAuditResponse>(
                                            *impl_->access, &v1::Access::Stub::CheckAudit, v1::CheckAuditRequest()));
  return AuditHead{response.last_entry_number(), response.sha256()};
}

}  // namespace axiscal::client
