// From which connections somebody has called whom the server knows.
#ifndef AXISCAL_SERVER_ACCESS_KNOWN_PEERS_H_
#define AXISCAL_SERVER_ACCESS_KNOWN_PEERS_H_

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "core/base/mutex.h"

namespace axiscal::access {

// What gRPC has as "ipv6:%5B::1%5D:40312" or "ipv6:%5Bfe80::1%252%5D:40312" without its escapes: "ipv6:[::1]:40312".
std::string PlainPeer(const std::string& peer);

// Peers as gRPC has them, "ipv4:192.0.2.7:40312" or "ipv6:%5B::1%5D:40312", also with plain brackets. Safe from any
// thread.
class KnownPeers {
 public:
  void Add(const std::string& peer);
  // A connection has come: who had its address before is gone.
  void Forget(const std::string& peer);
  // Where more than `most` are known: all that `connected` does not name, of those that were known before it was asked.
  void ForgetGone(size_t most, const std::function<std::vector<std::string>()>& connected);
  bool Has(const std::string& peer) const;

 private:
  mutable base::Mutex mutex_;
  std::set<std::string> peers_ AXISCAL_GUARDED_BY(mutex_);
};

}  // namespace axiscal::access

#endif  // AXISCAL_SERVER_ACCESS_KNOWN_PEERS_H_
