#include "server/access/crowd.h"

#include <iterator>
#include <map>
#include <set>
#include <utility>

namespace axiscal::access {

std::vector<size_t> BeyondTheMost(const std::vector<std::string>& hosts, size_t most) {
  std::vector<size_t> ended;
  if (hosts.size() <= most) return ended;
  std::map<std::string, std::vector<size_t>> places;  // of each host, the last to come first
  for (size_t i = hosts.size(); i-- > 0;) places[hosts[i]].push_back(i);
  std::set<std::pair<size_t, std::string>> by_count;
  for (const auto& [host, of_host] : places) by_count.emplace(of_host.size(), host);
  while (hosts.size() - ended.size() > most) {
    const auto largest = std::prev(by_count.end());
    const std::string host = largest->second;
    by_count.erase(largest);
    std::vector<size_t>& of_host = places[host];
    ended.push_back(of_host.back());
    of_host.pop_back();
    if (!of_host.empty()) by_count.emplace(of_host.size(), host);
  }
  return ended;
}

}  // namespace axiscal::access
