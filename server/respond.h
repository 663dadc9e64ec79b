// What surrounds every call: who calls, cancellation, the log, the status with its details, and the catch-all.
#ifndef AXISCAL_SERVER_RESPOND_H_
#define AXISCAL_SERVER_RESPOND_H_

#include <grpcpp/server_context.h>

#include <functional>
#include <string>

#include "server/handlers/core.h"

namespace axiscal::server {

// gRPC's status for ours, with google.rpc details (proto/README.md, "Errors").
grpc::Status ToGrpc(const absl::Status& status);

// Runs `handler`, counts the call in core.open_calls, logs it, maps its status. An exception becomes INTERNAL with the
// id under which it is logged.
grpc::Status RespondStream(handlers::Core& core, grpc::ServerContext* context, const std::string& method,
                           const std::function<absl::Status(const handlers::Call&)>& handler);

// The same for a handler that returns StatusOr<Response>.
template <typename Handler, typename Response>
grpc::Status Respond(handlers::Core& core, grpc::ServerContext* context, const std::string& method,
                     const Handler& handler, Response* response) {
  return RespondStream(core, context, method, [&](const handlers::Call& call) -> absl::Status {
    absl::StatusOr<Response> result = handler(call);
    if (result.ok()) *response = *std::move(result);
    return result.status();
  });
}

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_RESPOND_H_
