#include "server/access/forwarded.h"

#include <utility>

namespace axiscal::access {

std::string PeerHost(const std::string& peer) {
  const bool has_port = peer.rfind("ipv4:", 0) == 0 || peer.rfind("ipv6:", 0) == 0;
  return has_port ? peer.substr(0, peer.rfind(':')) : peer;
}

ForwardedCalls::Place::Place(ForwardedCalls& calls, ForwardedCaller caller) : calls_(calls), ticket_(NewToken()) {
  const base::MutexLock lock(calls_.mutex_);
  calls_.callers_.emplace(ticket_, std::move(caller));
}

ForwardedCalls::Place::~Place() {
  const base::MutexLock lock(calls_.mutex_);
  calls_.callers_.erase(ticket_);
}

std::optional<ForwardedCaller> ForwardedCalls::Find(const std::string& ticket) const {
  const base::MutexLock lock(mutex_);
  const auto found = callers_.find(ticket);
  if (found == callers_.end()) return std::nullopt;
  return found->second;
}

}  // namespace axiscal::access
