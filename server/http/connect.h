// One call by the Connect protocol (https://connectrpc.com/docs/protocol): methods that are no streams, and those that
// stream their answer, in JSON or Protobuf's binary form, not compressed.
#ifndef AXISCAL_SERVER_HTTP_CONNECT_H_
#define AXISCAL_SERVER_HTTP_CONNECT_H_

#include <google/protobuf/descriptor.h>
#include <grpcpp/grpcpp.h>

#include <memory>

#include "server/handlers/core.h"
#include "server/http/exchange.h"

namespace axiscal::http {

// Most bytes of a request's body by the Content-Type that it has.
int64_t MostBodyBytes(const Request& request);

// Answers the request; `credentials` may be the error that the caller gets. What its messages take of memory beside its
// body is taken of `budget`: RESOURCE_EXHAUSTED QUEUE_FULL.
void ServeConnect(handlers::Core& core, const std::shared_ptr<grpc::Channel>& channel,
                  const google::protobuf::MethodDescriptor& method, const Request& request,
                  const absl::StatusOr<access::Credentials>& credentials, handlers::Budget& budget, Exchange& exchange);

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_CONNECT_H_
