// What gRPC does with a call before our handler and after it: a thread of the server waits until the caller has taken
// the reply, or serves a call of gRPC's own (health). Nothing but this ends it where the connection lives.
#ifndef AXISCAL_SERVER_CALL_GUARD_H_
#define AXISCAL_SERVER_CALL_GUARD_H_

#include <grpcpp/server_context.h>

#include "server/handlers/held_calls.h"

namespace axiscal::server {

// Before a server is built. Every call of every server of the process is cut off from then on whose caller is silent
// for as long as the last server's start says. Beyond so many calls at a time as `held` allows of each kind, and
// HeldLimits::max_replies of others, the one that is silent longest gives way.
void GuardCalls(const handlers::HeldLimits& held);

// While it lives, the call is in a handler of ours, which counts the silence of its caller itself (HeldCall).
class InHandler {
 public:
  explicit InHandler(grpc::ServerContext* context);
  ~InHandler();
  InHandler(const InHandler&) = delete;
  InHandler& operator=(const InHandler&) = delete;

 private:
  grpc::ServerContext* const context_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_CALL_GUARD_H_
