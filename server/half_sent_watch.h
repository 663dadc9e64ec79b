// Ends connections where callers have half sent more than a limit. Until a message is there in full it waits in gRPC's
// memory, where no handler sees it. gRPC 1.51 has a quota for that and cancels calls beyond it, but it cancels more
// slowly than messages come: of eight connections that sent 3.1 GB together, it let 3.0 GB in with a quota of 32 MB.
#ifndef AXISCAL_SERVER_HALF_SENT_WATCH_H_
#define AXISCAL_SERVER_HALF_SENT_WATCH_H_

#include <cstddef>
#include <cstdint>

#include "server/call_heads.h"
#include "server/half_sent.h"
#include "server/handlers/call_rates.h"
#include "server/rounds.h"

namespace axiscal::server {

class HalfSentWatch {
 public:
  // Of the connections to `port` of this process, which may have half sent `most_bytes` together. `told`: how often the
  // log says the same. What is referred to outlives this.
  HalfSentWatch(int port, int64_t most_bytes, CallHeads& heads, handlers::CallRates& told);

  // From then on until Stop().
  void Start();
  void Stop() { rounds_.Stop(); }

 private:
  void Look();

  const int port_;
  // More than these may have half sent half of the limit before anybody looks, and may have the other half since.
  const int64_t many_calls_;
  CallHeads& heads_;
  handlers::CallRates& told_;
  HalfSent half_sent_;
  size_t connections_ = 0;
  Rounds rounds_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_HALF_SENT_WATCH_H_
