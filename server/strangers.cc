#include "server/strangers.h"

#include <algorithm>
#include <vector>

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
  std::set<std::string> ended;
  if (strangers_.size() <= most_) return ended;
  std::vector<std::pair<int64_t, std::string>> by_look;
  for (const auto& [peer, look] : strangers_) by_look.emplace_back(look, peer);
  std::sort(by_look.begin(), by_look.end());
  for (size_t i = 0; i + most_ < by_look.size(); ++i) ended.insert(by_look[i].second);
  return ended;
}

}  // namespace axiscal::server
