#include "server/local_login.h"

#include <netinet/in.h>
#include <pwd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <sstream>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace axiscal::server {
namespace {

// The port behind the last colon of an "ADDRESS:PORT" with a port in base `base`; -1 where there is none.
int PortIn(const std::string& place, int base) {
  const size_t colon = place.rfind(':');
  if (colon == std::string::npos || colon + 1 == place.size()) return -1;
  char* end = nullptr;
  const long port = std::strtol(place.c_str() + colon + 1, &end, base);
  return *end == '\0' ? static_cast<int>(port) : -1;
}

std::string PortText(const std::string& peer) { return peer.substr(peer.rfind(':') + 1); }

}  // namespace

std::string LoginOfUser(uid_t user) {
  std::array<char, 16384> buffer;
  passwd entry = {};
  passwd* found = nullptr;
  const bool has_name = getpwuid_r(user, &entry, buffer.data(), buffer.size(), &found) == 0 && found != nullptr;
  return has_name && found->pw_name[0] != '\0' ? found->pw_name : std::to_string(user);
}

std::string LoginOfProcess() { return LoginOfUser(getuid()); }

std::optional<uid_t> UserOfUnixPeer(int connection) {
  ucred peer = {};
  socklen_t size = sizeof(peer);
  if (getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return std::nullopt;
  return peer.uid;
}

std::optional<uid_t> UserOfPeer(const std::string& peer, int port) {
  const int peer_port = PortIn(peer, 10);
  if (peer_port <= 0) return std::nullopt;
  // Each end of a connection within the machine has its line: number, local place, remote place, state, three fields
  // more, user (proc(5)).
  constexpr int kHex = 16, kFieldsBetween = 3;
  constexpr char kEstablished[] = "01";
  for (const char* const table : {"/proc/net/tcp", "/proc/net/tcp6"}) {
    std::ifstream lines(table);
    for (std::string line; std::getline(lines, line);) {
      std::istringstream fields(line);
      std::string number, local, remote, state, skipped;
      uid_t user = 0;
      fields >> number >> local >> remote >> state;
      if (PortIn(local, kHex) != peer_port || PortIn(remote, kHex) != port || state != kEstablished) continue;
      for (int i = 0; i < kFieldsBetween; ++i) fields >> skipped;
      if (fields >> user) return user;
    }
  }
  return std::nullopt;
}

void PeerUsers::Connected(int connection) {
  sockaddr_storage address = {};
  socklen_t size = sizeof(address);
  if (getpeername(connection, reinterpret_cast<sockaddr*>(&address), &size) != 0) return;
  if (address.ss_family == AF_INET)
    Connected(absl::StrCat(":", ntohs(reinterpret_cast<const sockaddr_in&>(address).sin_port)));
  if (address.ss_family == AF_INET6)
    Connected(absl::StrCat(":", ntohs(reinterpret_cast<const sockaddr_in6&>(address).sin6_port)));
}

void PeerUsers::Connected(const std::string& peer) {
  const base::MutexLock lock(mutex_);
  User& user = users_[PortText(peer)];
  ++user.connection;
  user.id.reset();
}

std::optional<uid_t> PeerUsers::UserOf(const std::string& peer) {
  const std::string port = PortText(peer);
  uint64_t connection = 0;
  {
    const base::MutexLock lock(mutex_);
    const auto found = users_.find(port);
    if (found == users_.end()) return std::nullopt;  // no connection of ours
    if (found->second.id) return found->second.id;
    connection = found->second.connection;
  }
  const std::optional<uid_t> id = ask_(peer);
  const base::MutexLock lock(mutex_);
  User& user = users_[port];
  if (user.connection == connection) user.id = id;
  return id;
}

}  // namespace axiscal::server
