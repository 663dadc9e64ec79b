// Ends connections of strangers, callers who have shown no identity, where they flood a port with calls, are too many,
// or take nothing of what they are told.
#ifndef AXISCAL_SERVER_STRANGER_WATCH_H_
#define AXISCAL_SERVER_STRANGER_WATCH_H_

#include <chrono>
#include <cstdint>

#include "server/access/known_peers.h"
#include "server/call_heads.h"
#include "server/handlers/call_rates.h"
#include "server/rounds.h"
#include "server/strangers.h"

namespace axiscal::server {

class StrangerWatch {
 public:
  // Of the connections to `port` of this process, of which strangers may have `most`; 0: there is no port with peers
  // that have names. `known`: whose connections are left alone; `told`: how often the log says the same. What is
  // referred to outlives this.
  StrangerWatch(int port, int most, access::KnownPeers& known, const CallHeads& heads, handlers::CallRates& told);

  // From then on until Stop(), on two threads.
  void Start();
  void Stop();

 private:
  // gRPC has calls that no handler hears of without bound, and does not say from where they come.
  void LookForFloods();
  void EndFlooding(int64_t calls);
  void LookForStrangers();

  const int port_;
  access::KnownPeers& known_;
  const CallHeads& heads_;
  handlers::CallRates& told_;
  // The thread's alone that looks for floods.
  int64_t unheard_;
  std::chrono::steady_clock::time_point flood_until_;
  bool is_flood_ = false;
  Strangers strangers_;  // the other thread's alone
  Rounds floods_, counts_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_STRANGER_WATCH_H_
