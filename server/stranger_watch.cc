#include "server/stranger_watch.h"

#include <malloc.h>

#include <set>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/call_guard.h"
#include "server/listener.h"
#include "server/log.h"

namespace axiscal::server {
namespace {

// How often it is looked whether calls flood in that no handler hears of, and how many of them are a flood: more than
// people and dashboards that change their mind, or clients whose deadlines are over, take back. Until it is looked, all
// that come are in memory, 20 KB each.
constexpr std::chrono::milliseconds kFloodLook(10);
constexpr int64_t kMostUnheard = 20;
// After one it is looked for its connections so long: their calls wait in gRPC, and are counted when they have a
// thread.
constexpr std::chrono::seconds kFloodLasts(5);
// Who has brought so much and shown no identity is no caller that has just come: TLS and a first call take a fifth.
constexpr int64_t kMuchOfAStranger = 32 << 10;
// How often it is looked how many connections strangers have.
constexpr std::chrono::milliseconds kStrangersLook(500);
// What strangers are told is short: who leaves more of it than a hundred answers takes none, and what he is told stays
// in gRPC's memory.
constexpr int64_t kUntakenByAStranger = 16 << 10;
// Beyond so many peers that are known, 100 bytes each, those whose connections are gone are forgotten.
constexpr size_t kManyKnown = 65'536;

}  // namespace

StrangerWatch::StrangerWatch(int port, int most, access::KnownPeers& known, const CallHeads& heads,
                             handlers::CallRates& told)
    : port_(port),
      known_(known),
      heads_(heads),
      told_(told),
      unheard_(UnheardCalls() + heads.refused()),
      flood_until_(std::chrono::steady_clock::now()),
      strangers_(port, static_cast<size_t>(most), [&known](const std::string& peer) { return known.Has(peer); }) {}

void StrangerWatch::Start() {
  floods_.Start(Rounds::Begin::kAfterAPause, kFloodLook, [this] { LookForFloods(); });
  if (port_ != 0) counts_.Start(Rounds::Begin::kAfterAPause, kStrangersLook, [this] { LookForStrangers(); });
}

void StrangerWatch::Stop() {
  floods_.Stop();
  counts_.Stop();
}

void StrangerWatch::LookForFloods() {
  const auto now = std::chrono::steady_clock::now();
  const int64_t unheard = UnheardCalls() + heads_.refused();
  if (unheard - unheard_ >= kMostUnheard) flood_until_ = now + kFloodLasts;
  if (now < flood_until_) {
    is_flood_ = true;
    EndFlooding(unheard - unheard_);
  } else if (is_flood_) {
    is_flood_ = false;
    // The allocator keeps what calls had that were ended, hundreds of megabytes, until it is told that they are over.
    malloc_trim(0);
  }
  unheard_ = unheard;
}

void StrangerWatch::EndFlooding(int64_t calls) {
  const int count = EndConnections(port_, [this](const std::string& peer, const Traffic& traffic) {
    return traffic.brought >= kMuchOfAStranger && !known_.Has(peer);
  });
  if (count == 0 || !told_.Take("flood").ok()) return;
  Log(LogLevel::kWarning, "flood",
      {{"calls", absl::StrCat(calls)},
       {"connections", absl::StrCat(count)},
       {"text", "calls that no handler heard of: connections that brought much and showed no identity were ended"}});
}

void StrangerWatch::LookForStrangers() {
  known_.ForgetGone(kManyKnown, [this] { return PeersTo(port_); });
  const std::set<std::string> peers = strangers_.TooMany();
  int untaken = 0, count = 0;
  EndConnections(port_, [&](const std::string& peer, const Traffic& traffic) {
    if (known_.Has(peer)) return false;  // he may have called since
    const bool is_beyond = peers.contains(peer), takes_nothing = traffic.untaken >= kUntakenByAStranger;
    count += is_beyond ? 1 : 0;
    untaken += takes_nothing && !is_beyond ? 1 : 0;
    return is_beyond || takes_nothing;
  });
  if (untaken > 0 && told_.Take("untaken").ok()) {
    Log(LogLevel::kWarning, "strangers",
        {{"connections", absl::StrCat(untaken)},
         {"text", "they had shown no identity and took nothing of what they were told: they were ended"}});
  }
  if (count > 0 && told_.Take("strangers").ok()) {
    Log(LogLevel::kWarning, "strangers",
        {{"connections", absl::StrCat(count)},
         {"text",
          "more connections than are allowed had shown no identity: the first of the host that has most were ended"}});
  }
}

}  // namespace axiscal::server
