// Calls that were denied, for the audit: gathered for a while and written as one entry for each caller, method and
// resource, ever more rarely while they go on, so that a flood of them fills neither the disk nor the list.
#ifndef AXISCAL_SERVER_DENIALS_H_
#define AXISCAL_SERVER_DENIALS_H_

#include <cstdint>
#include <map>
#include <string>
#include <tuple>

#include "core/base/clock.h"
#include "core/base/mutex.h"
#include "server/storage/database.h"

namespace axiscal::server {

// Safe from any thread.
class Denials {
 public:
  // In one hour at most so many kinds (who, from where, method, resource, why) are told apart, in all and of one
  // principal; callers without identity share half of all. The rest is counted together.
  static constexpr size_t kMaxKinds = 1000, kMaxKindsOfOne = 100;

  explicit Denials(base::Clock& clock = base::SystemClock()) : clock_(clock), hour_began_(clock.SteadyNow()) {}

  // UNAUTHENTICATED, PERMISSION_DENIED and what access::DeniedResource() knows count, other statuses do not. `peer`:
  // access::PeerHost().
  void Add(const std::string& user, const std::string& peer, const std::string& method, const absl::Status& status);
  // Writes what was gathered: the first calls of a kind at once, then each time that their number has doubled, the rest
  // when the hour is over or with `all`. What cannot be written stays gathered.
  absl::Status Write(storage::Database& database, bool all = false);

 private:
  // An entry's principal, peer, method, resource, outcome, reason.
  using Kind = std::tuple<std::string, std::string, std::string, std::string, std::string, std::string>;
  struct Count {
    int64_t waiting = 0, written = 0;
  };
  Count& CountOf(const Kind& kind) AXISCAL_REQUIRES(mutex_);
  void BeginHour() AXISCAL_REQUIRES(mutex_);

  base::Clock& clock_;
  base::Mutex mutex_;
  base::SteadyTime hour_began_ AXISCAL_GUARDED_BY(mutex_);
  std::map<Kind, Count> counts_ AXISCAL_GUARDED_BY(mutex_);
  std::map<std::string, size_t> kinds_of_ AXISCAL_GUARDED_BY(mutex_);  // by principal
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_DENIALS_H_
