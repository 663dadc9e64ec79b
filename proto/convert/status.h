// absl::Status <-> google.rpc.Status with details: how errors look on the wire (proto/README.md, "Errors").
#ifndef AXISCAL_PROTO_CONVERT_STATUS_H_
#define AXISCAL_PROTO_CONVERT_STATUS_H_

#include "core/base/status.h"
#include "google/rpc/status.pb.h"

namespace axiscal::convert {

inline constexpr char kErrorDomain[] = "axiscal";

// `status` must not be OK. ErrorInfo always (a status without a reason gets its code's name), BadRequest when the fact
// `field` is there, RetryInfo with RESOURCE_EXHAUSTED and UNAVAILABLE.
google::rpc::Status ToProto(const absl::Status& status);

// The status with its reason and facts as base::ErrorDetail. Reads what other servers send too: without details there
// is no reason.
absl::Status FromProto(const google::rpc::Status& message);

}  // namespace axiscal::convert

#endif  // AXISCAL_PROTO_CONVERT_STATUS_H_
