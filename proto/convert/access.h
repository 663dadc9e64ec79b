// Principals, roles and tokens on the wire.
#ifndef AXISCAL_PROTO_CONVERT_ACCESS_H_
#define AXISCAL_PROTO_CONVERT_ACCESS_H_

#include "axiscal/v1/access_service.pb.h"
#include "core/base/status.h"
#include "core/records/access.h"

namespace axiscal::convert {

v1::Scope ToProto(const records::Scope& scope);
v1::Grant ToProto(const records::Grant& grant);
v1::Token ToProto(const records::TokenRecord& token);
v1::Principal ToProto(const records::PrincipalRecord& principal);
v1::MachineAccess ToProto(const records::MachineAccess& access);

// FIELD_INVALID "scope" unless exactly one of its three is set.
absl::StatusOr<records::Scope> FromProto(const v1::Scope& message);
absl::StatusOr<records::Grant> FromProto(const v1::Grant& message);
absl::StatusOr<records::TokenRecord> FromProto(const v1::Token& message);
absl::StatusOr<records::PrincipalRecord> FromProto(const v1::Principal& message);
absl::StatusOr<records::MachineAccess> FromProto(const v1::MachineAccess& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_ACCESS_H_
