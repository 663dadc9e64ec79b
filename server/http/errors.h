// Errors as the Connect protocol writes them (https://connectrpc.com/docs/protocol, "Error Codes"): google.rpc.Status
// as JSON, with the same details that gRPC carries.
#ifndef AXISCAL_SERVER_HTTP_ERRORS_H_
#define AXISCAL_SERVER_HTTP_ERRORS_H_

#include <grpcpp/support/status.h>

#include <string>

#include "core/base/status.h"
#include "google/rpc/status.pb.h"
#include "server/http/exchange.h"

namespace axiscal::http {

// "not_found" and 404 of NOT_FOUND; those of UNKNOWN for a number that is no code.
std::string CodeName(int code);
int HttpStatusOf(int code);

// `status` must not be OK. Without details there is a message at least.
google::rpc::Status ErrorOf(const grpc::Status& status);
google::rpc::Status ErrorOf(const absl::Status& status);

// {"code": ..., "message": ..., "details": [{"type", "value", "debug"}]}.
std::string ErrorJson(const google::rpc::Status& error);
// The whole answer to a call that is no stream.
Answer ErrorAnswer(const google::rpc::Status& error);
Answer ErrorAnswer(const absl::Status& status);
// The JSON of a stream's last envelope: "{}" of an OK status.
std::string EndOfStreamJson(const google::rpc::Status* error);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_ERRORS_H_
