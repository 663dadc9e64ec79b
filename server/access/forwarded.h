// Calls that come by another way than gRPC's port (server/http) go on to the handlers by a channel within the process,
// which knows neither connection nor certificate. What their callers showed waits here under a ticket, which the call
// brings along and which nobody can guess.
#ifndef AXISCAL_SERVER_ACCESS_FORWARDED_H_
#define AXISCAL_SERVER_ACCESS_FORWARDED_H_

#include <map>
#include <optional>
#include <string>

#include "core/base/mutex.h"
#include "server/access/gate.h"

namespace axiscal::access {

struct ForwardedCaller {
  Credentials credentials;
  std::string peer;  // as gRPC writes it: "ipv4:127.0.0.1:51234"
};

// Of a peer ("ipv4:192.0.2.7:51234") the address without the port, which is another one with each connection.
std::string PeerHost(const std::string& peer);

// The metadata key of the ticket.
inline constexpr char kTicketKey[] = "axiscal-ticket";

// Safe from any thread.
class ForwardedCalls {
 public:
  // While it lives, its ticket is good.
  class Place {
   public:
    Place(ForwardedCalls& calls, ForwardedCaller caller);
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    const std::string& ticket() const { return ticket_; }

   private:
    ForwardedCalls& calls_;
    const std::string ticket_;
  };

  // Nothing for a ticket that is not good.
  std::optional<ForwardedCaller> Find(const std::string& ticket) const;

 private:
  mutable base::Mutex mutex_;
  std::map<std::string, ForwardedCaller> callers_ AXISCAL_GUARDED_BY(mutex_);
};

}  // namespace axiscal::access

#endif  // AXISCAL_SERVER_ACCESS_FORWARDED_H_
