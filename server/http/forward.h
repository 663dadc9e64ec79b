// Calls that go on to the handlers: by the channel within the process, with what the caller showed (server/access), its
// deadline, and its end when the caller leaves. All block.
#ifndef AXISCAL_SERVER_HTTP_FORWARD_H_
#define AXISCAL_SERVER_HTTP_FORWARD_H_

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <string>

#include "server/handlers/core.h"
#include "server/http/exchange.h"

namespace axiscal::http {

// One call of one request, from its begin to its end.
class ForwardedCall {
 public:
  // INVALID_ARGUMENT FIELD_INVALID for a Connect-Timeout-Ms that is no number of at most 10 digits, and for an
  // axiscal-user that is no printable ASCII text.
  static absl::StatusOr<std::unique_ptr<ForwardedCall>> Begin(handlers::Core& core, const Request& request,
                                                              const access::Credentials& credentials,
                                                              Exchange& exchange);
  ~ForwardedCall();
  ForwardedCall(const ForwardedCall&) = delete;
  ForwardedCall& operator=(const ForwardedCall&) = delete;

  grpc::ClientContext& context() { return context_; }
  // Calls the method of a path with one message; `take` gets each message that comes back and returns false to end the
  // call.
  grpc::Status Run(const std::shared_ptr<grpc::Channel>& channel, const std::string& path, const std::string& message,
                   const std::function<bool(std::string)>& take);

 private:
  ForwardedCall(handlers::Core& core, access::ForwardedCaller caller, Exchange& exchange)
      : place_(core.forwarded, std::move(caller)), exchange_(exchange) {}

  const access::ForwardedCalls::Place place_;
  grpc::ClientContext context_;
  Exchange& exchange_;
};

}  // namespace axiscal::http

#endif  // AXISCAL_SERVER_HTTP_FORWARD_H_
