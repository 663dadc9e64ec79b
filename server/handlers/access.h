// The calls of the service Access: one small function each.
#ifndef AXISCAL_SERVER_HANDLERS_ACCESS_H_
#define AXISCAL_SERVER_HANDLERS_ACCESS_H_

#include "axiscal/v1/access_service.pb.h"
#include "server/handlers/core.h"

namespace axiscal::handlers {

absl::StatusOr<v1::GetIdentityResponse> GetIdentity(Core& core, const Call& call,
                                                    const v1::GetIdentityRequest& request);
absl::StatusOr<v1::CreatePrincipalResponse> CreatePrincipal(Core& core, const Call& call,
                                                            const v1::CreatePrincipalRequest& request);
absl::StatusOr<v1::RevokePrincipalResponse> RevokePrincipal(Core& core, const Call& call,
                                                            const v1::RevokePrincipalRequest& request);
absl::StatusOr<v1::ListPrincipalsResponse> ListPrincipals(Core& core, const Call& call,
                                                          const v1::ListPrincipalsRequest& request);
absl::StatusOr<v1::CreateTokenResponse> CreateToken(Core& core, const Call& call,
                                                    const v1::CreateTokenRequest& request);
absl::StatusOr<v1::RevokeTokenResponse> RevokeToken(Core& core, const Call& call,
                                                    const v1::RevokeTokenRequest& request);
absl::StatusOr<v1::ChangeRoleResponse> ChangeRole(Core& core, const Call& call, const v1::ChangeRoleRequest& request);
absl::StatusOr<v1::ChangeGroupResponse> ChangeGroup(Core& core, const Call& call,
                                                    const v1::ChangeGroupRequest& request);
absl::StatusOr<v1::SetFourEyesResponse> SetFourEyes(Core& core, const Call& call,
                                                    const v1::SetFourEyesRequest& request);
absl::StatusOr<v1::ListMachineAccessResponse> ListMachineAccess(Core& core, const Call& call,
                                                                const v1::ListMachineAccessRequest& request);

absl::StatusOr<v1::ListAuditResponse> ListAudit(Core& core, const Call& call, const v1::ListAuditRequest& request);
absl::StatusOr<v1::CheckAuditResponse> CheckAudit(Core& core, const Call& call, const v1::CheckAuditRequest& request);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_ACCESS_H_
