#include "server/access/known_peers.h"

#include "absl/strings/str_replace.h"

namespace axiscal::access {

std::string PlainPeer(const std::string& peer) {
  return absl::StrReplaceAll(peer, {{"%5B", "["}, {"%5D", "]"}, {"%25", "%"}});
}

void KnownPeers::Add(const std::string& peer) {
  const base::MutexLock lock(mutex_);
  peers_.insert(PlainPeer(peer));
}

void KnownPeers::Forget(const std::string& peer) {
  const base::MutexLock lock(mutex_);
  peers_.erase(PlainPeer(peer));
}

void KnownPeers::ForgetGone(size_t most, const std::function<std::vector<std::string>()>& connected) {
  std::set<std::string> gone;
  {
    const base::MutexLock lock(mutex_);
    if (peers_.size() <= most) return;
    gone = peers_;
  }
  for (const std::string& peer : connected()) gone.erase(PlainPeer(peer));
  const base::MutexLock lock(mutex_);
  for (const std::string& peer : gone) peers_.erase(peer);
}

bool KnownPeers::Has(const std::string& peer) const {
  const base::MutexLock lock(mutex_);
  return peers_.contains(PlainPeer(peer));
}

}  // namespace axiscal::access
