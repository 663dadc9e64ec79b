// What surrounds every call: who calls and whether it may (server/access), cancellation, the log, the status with its
// details, and the catch-all.
#ifndef AXISCAL_SERVER_RESPOND_H_
#define AXISCAL_SERVER_RESPOND_H_

#include <grpcpp/server_context.h>

#include <functional>
#include <string>

#include "server/handlers/core.h"

namespace axiscal::server {

// gRPC's status for ours, with google.rpc details (proto/README.md, "Errors").
grpc::Status ToGrpc(const absl::Status& status);

// Asks core.gate, runs `handler`, counts the call in core.open_calls, logs it, maps its status. `request` is null for
// calls whose first message comes later: for that the handler asks Call::admit. An exception becomes INTERNAL with the
// id under which it is logged.
grpc::Status RespondStream(handlers::Core& core, grpc::ServerContext* context, const std::string& method,
                           const google::protobuf::Message* request,
                           const std::function<absl::Status(const handlers::Call&)>& handler);

// The same for a handler that returns StatusOr<Response>.
template <typename Handler, typename Response>
grpc::Status Respond(handlers::Core& core, grpc::ServerContext* context, const std::string& method,
                     const google::protobuf::Message* request, const Handler& handler, Response* response) {
  return RespondStream(core, context, method, request, [&](const handlers::Call& call) -> absl::Status {
    absl::StatusOr<Response> result = handler(call);
    if (result.ok()) *response = *std::move(result);
    return result.status();
  });
}

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_RESPOND_H_
