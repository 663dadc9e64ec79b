// Who calls on this machine, as the operating system tells: for the audit of a server that asks nobody.
#ifndef AXISCAL_SERVER_LOCAL_LOGIN_H_
#define AXISCAL_SERVER_LOCAL_LOGIN_H_

#include <sys/types.h>

#include <optional>
#include <string>

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

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_LOCAL_LOGIN_H_
