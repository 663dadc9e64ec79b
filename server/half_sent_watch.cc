#include "server/half_sent_watch.h"

#include <malloc.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/handlers/get_server_info.h"
#include "server/listener.h"
#include "server/log.h"

namespace axiscal::server {
namespace {

// What comes meanwhile is beyond the limit: at a gigabit a second 12 MB. A look asks the system for each connection,
// 5 ms for two thousand.
constexpr std::chrono::milliseconds kLook(100);
// Connections that are gone are forgotten when so many more are told of than there were: 5 KB each.
constexpr size_t kManyTold = 4096;

}  // namespace

HalfSentWatch::HalfSentWatch(int port, int64_t most_bytes, CallHeads& heads, handlers::CallRates& told)
    : port_(port),
      many_calls_(most_bytes / 2 / handlers::kMaxMessageBytes),
      heads_(heads),
      told_(told),
      half_sent_(most_bytes / 2, handlers::kMaxMessageBytes) {}

void HalfSentWatch::Start() {
  if (port_ != 0) rounds_.Start(Rounds::Begin::kAfterAPause, kLook, [this] { Look(); });
}

void HalfSentWatch::Look() {
  const bool is_much = heads_.waiting() > many_calls_;
  if (!is_much) half_sent_.Rest();
  if (!is_much && heads_.told() <= connections_ + kManyTold) return;
  std::map<std::string, Traffic> connections;
  heads_.ForgetGone([&] {
    connections = ConnectionsTo(port_);
    std::vector<std::string> peers;
    for (const auto& [peer, traffic] : connections) peers.push_back(peer);
    return peers;
  });
  connections_ = connections.size();
  if (!is_much) return;
  const std::set<std::string> too_much =
      half_sent_.TooMuch(connections, [this](const std::string& peer) { return heads_.WaitingOf(peer); });
  if (too_much.empty()) return;
  const int count =
      EndConnections(port_, [&](const std::string& peer, const Traffic&) { return too_much.contains(peer); });
  // The allocator keeps what they had until it is told that it is over.
  malloc_trim(0);
  if (!told_.Take("half_sent").ok()) return;
  Log(LogLevel::kWarning, "half_sent",
      {{"connections", absl::StrCat(count)},
       {"text", "they had half sent most of what callers together may (limits.waiting_bytes): they were ended"}});
}

}  // namespace axiscal::server
