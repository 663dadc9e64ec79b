#include "server/strangers.h"

#include <algorithm>
#include <vector>

#include "server/access/crowd.h"
#include "server/access/forwarded.h"
#include "server/listener.h"

namespace axiscal::server {

std::set<std::string> Strangers::TooMany() {
  ++looks_;
  std::map<std::string, int64_t> present;
  for (const std::string& peer : PeersTo(port_)) {
    if (is_known_(peer)) continue;
    const auto before = strangers_.find(peer);
    present[peer] = before == strangers_.end() ? looks_ : before->second;
  }
  strangers_ = std::move(present);
  std::vector<std::pair<int64_t, std::string>> by_look;
  for (const auto& [peer, look] : strangers_) by_look.emplace_back(look, peer);
  std::sort(by_look.begin(), by_look.end());
  std::vector<std::string> hosts;
  for (const auto& [look, peer] : by_look) hosts.push_back(access::PeerHost(peer));
  std::set<std::string> ended;
  for (const size_t place : access::BeyondTheMost(hosts, most_)) ended.insert(by_look[place].second);
  return ended;
}

}  // namespace axiscal::server
