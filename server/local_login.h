// Who calls on this machine, as the operating system tells: for the audit of a server that asks nobody.
#ifndef AXISCAL_SERVER_LOCAL_LOGIN_H_
#define AXISCAL_SERVER_LOCAL_LOGIN_H_

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/base/mutex.h"

namespace axiscal::server {

// The login name of a user, or its number where it has none.
std::string LoginOfUser(uid_t user);
// Of this process.
std::string LoginOfProcess();

// The user whose process holds the other end of a TCP connection within this machine. `peer` as gRPC has it
// ("ipv4:127.0.0.1:51234", "ipv6:%5B::1%5D:51234"), `port` is the server's. Nothing where the system does not tell.
std::optional<uid_t> UserOfPeer(const std::string& peer, int port);
// The user whose process connected to a unix socket; `connection` is our end.
std::optional<uid_t> UserOfUnixPeer(int connection);

// Who holds the other ends of a server's TCP connections, asked once a connection: the system tells by a table of all
// connections of the machine, which takes longer than most calls. Safe from any thread.
class PeerUsers {
 public:
  using Ask = std::function<std::optional<uid_t>(const std::string& peer)>;

  // `ask`: UserOfPeer() with the server's port.
  explicit PeerUsers(Ask ask) : ask_(std::move(ask)) {}

  // A connection has come, before its first call: whoever had its other end's port before is gone.
  void Connected(int connection);
  void Connected(const std::string& peer);
  // As UserOfPeer(). What the system does not tell is asked again.
  std::optional<uid_t> UserOf(const std::string& peer);

 private:
  struct User {
    uint64_t connection = 0;  // counts those that had the port
    std::optional<uid_t> id;
  };

  const Ask ask_;
  base::Mutex mutex_;
  std::map<std::string, User> users_ AXISCAL_GUARDED_BY(mutex_);  // by port: 64 Ki at most
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_LOCAL_LOGIN_H_
