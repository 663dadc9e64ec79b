// What gRPC does with a call before our handler and after it: a thread of the server waits until the caller has taken
// the reply, or serves a call of gRPC's own (health). Nothing but this ends it where the connection lives.
#ifndef AXISCAL_SERVER_CALL_GUARD_H_
#define AXISCAL_SERVER_CALL_GUARD_H_

#include <grpcpp/server_context.h>

#include "server/handlers/held_calls.h"

namespace axiscal::server {

// Before a server is built. Every call of every server of the process is cut off from then on whose caller is silent
// for as long as the last server's start says. Beyond so many calls at a time as `held` allows of each kind, and
// HeldLimits::max_replies of others, the one that is silent longest gives way. Returns how many that are together: each
// has a thread of gRPC.
int GuardCalls(const handlers::HeldLimits& held);

// Calls of this process so far of which no handler of ours has heard, or not yet: taken back by their caller (HTTP/2
// rapid reset, CVE-2023-44487; gRPC 1.51 does not count those among the calls that a connection may have at a time, and
// knows no address of them), without a message that can be read, or refused by gRPC for want of a thread.
int64_t UnheardCalls();

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
