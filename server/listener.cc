#include "server/listener.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <linux/tcp.h>  // glibc's tcp_info ends before tcpi_bytes_received
#include <netdb.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "absl/strings/numbers.h"
#include "core/base/demand.h"
#include "core/base/error_detail.h"

namespace axiscal::server {
namespace {

// How long to leave the queue of connections alone when there is neither descriptor nor memory for one.
constexpr int kNoRoomPauseMs = 100;

absl::Status Failed(const std::string& address, const std::string& why) {
  return base::Error(absl::StatusCode::kUnavailable, absl::StrCat("cannot listen on ", address, ": ", why),
                     {"LISTEN_FAILED", {}});
}

// What the words of gRPC's addresses may begin with, taken off.
std::string WithoutScheme(std::string address) {
  for (const std::string scheme : {"dns:///", "dns:", "ipv4:", "ipv6:"}) {
    if (address.rfind(scheme, 0) == 0) return address.substr(scheme.size());
  }
  return address;
}

void Set(int socket, int level, int option, int value) { setsockopt(socket, level, option, &value, sizeof(value)); }

// Where an address leads.
struct Spot {
  enum class Kind { kHost, kUnix, kAbstract };
  Kind kind = Kind::kHost;
  std::string name;  // host, without brackets, or name of the socket
  std::string port;
};

absl::StatusOr<Spot> ReadAddress(const std::string& address) {
  const std::string unix_socket = "unix:", abstract_socket = "unix-abstract:";
  if (address.rfind(abstract_socket, 0) == 0)
    return Spot{Spot::Kind::kAbstract, address.substr(abstract_socket.size()), ""};
  if (address.rfind(unix_socket, 0) == 0) {
    std::string path = address.substr(unix_socket.size());
    if (path.rfind("///", 0) == 0) path.erase(0, 2);
    return Spot{Spot::Kind::kUnix, path, ""};
  }
  const std::string place = WithoutScheme(address);
  const size_t colon = place.rfind(':');
  std::string host = place.substr(0, colon);
  const bool is_bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (is_bracketed) host = host.substr(1, host.size() - 2);
  int port = -1;
  if (colon == std::string::npos || host.empty() || !absl::SimpleAtoi(place.substr(colon + 1), &port) || port < 0 ||
      port > 65535 || (!is_bracketed && host.find(':') != std::string::npos)) {
    return Failed(address, "expected HOST:PORT with a port of 0 to 65535 and IPv6 addresses in brackets, or unix:PATH");
  }
  return Spot{Spot::Kind::kHost, host, std::to_string(port)};
}

using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

// What a name stands for; null with `why`.
Addresses Resolve(const std::string& host, const std::string& port, std::string* why) {
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int code = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); code != 0) *why = gai_strerror(code);
  return Addresses(found, &freeaddrinfo);
}

bool IsLoopback(const sockaddr* address) {
  constexpr uint32_t kLoopbackNet = 127;
  if (address->sa_family == AF_INET)
    return ntohl(reinterpret_cast<const sockaddr_in*>(address)->sin_addr.s_addr) >> 24 == kLoopbackNet;
  if (address->sa_family != AF_INET6) return false;
  const in6_addr& v6 = reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr;
  return IN6_IS_ADDR_LOOPBACK(&v6) || (IN6_IS_ADDR_V4MAPPED(&v6) && v6.s6_addr[12] == kLoopbackNet);
}

// A socket that listens there, or -1 with errno.
int Listening(const sockaddr* address, socklen_t size) {
  const int made = socket(address->sa_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (made < 0) return -1;
  // A port in TIME_WAIT may be taken again, one that another server has may not (no SO_REUSEPORT).
  Set(made, SOL_SOCKET, SO_REUSEADDR, 1);
  if (address->sa_family == AF_INET6) {
    const auto& v6 = *reinterpret_cast<const sockaddr_in6*>(address);
    Set(made, IPPROTO_IPV6, IPV6_V6ONLY, IN6_IS_ADDR_UNSPECIFIED(&v6.sin6_addr) ? 0 : 1);
  }
  if (bind(made, address, size) == 0 && listen(made, SOMAXCONN) == 0) return made;
  const int why = errno;
  close(made);
  errno = why;
  return -1;
}

void SetPort(sockaddr* address, int port) {
  if (address->sa_family == AF_INET) reinterpret_cast<sockaddr_in*>(address)->sin_port = htons(port);
  if (address->sa_family == AF_INET6) reinterpret_cast<sockaddr_in6*>(address)->sin6_port = htons(port);
}

int PortOf(int socket) {
  sockaddr_storage bound = {};
  socklen_t size = sizeof(bound);
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&bound), &size) != 0) return 0;
  return ntohs(bound.ss_family == AF_INET ? reinterpret_cast<sockaddr_in*>(&bound)->sin_port
                                          : reinterpret_cast<sockaddr_in6*>(&bound)->sin6_port);
}

// Closed by another thread meanwhile, one may be left out.
void ForEachConnection(
    int port, const std::function<void(int descriptor, const std::string& peer, const Traffic& traffic)>& look) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    int descriptor = -1;
    if (!absl::SimpleAtoi(entry.path().filename().string(), &descriptor) || PortOf(descriptor) != port) continue;
    const std::string peer = PeerOf(descriptor);
    tcp_info info = {};
    socklen_t size = sizeof(info);
    if (peer.empty() || getsockopt(descriptor, IPPROTO_TCP, TCP_INFO, &info, &size) != 0) continue;
    look(descriptor, peer, {static_cast<int64_t>(info.tcpi_bytes_received), info.tcpi_notsent_bytes});
  }
}

}  // namespace

int64_t RaiseDescriptorLimit() {
  rlimit limit = {};
  DEMAND(getrlimit(RLIMIT_NOFILE, &limit) == 0);
  rlimit raised = limit;
  raised.rlim_cur = limit.rlim_max;
  if (limit.rlim_cur != limit.rlim_max && setrlimit(RLIMIT_NOFILE, &raised) == 0) limit = raised;
  return static_cast<int64_t>(limit.rlim_cur);
}

std::string PeerOf(int connection) {
  sockaddr_storage address = {};
  socklen_t size = sizeof(address);
  if (getpeername(connection, reinterpret_cast<sockaddr*>(&address), &size) != 0) return "";
  char host[INET6_ADDRSTRLEN] = {};
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &v4.sin_addr, host, sizeof(host));
    return absl::StrCat("ipv4:", host, ":", ntohs(v4.sin_port));
  }
  if (address.ss_family != AF_INET6) return "";
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
  if (IN6_IS_ADDR_V4MAPPED(&v6.sin6_addr)) {
    inet_ntop(AF_INET, v6.sin6_addr.s6_addr + 12, host, sizeof(host));
    return absl::StrCat("ipv4:", host, ":", ntohs(v6.sin6_port));
  }
  inet_ntop(AF_INET6, &v6.sin6_addr, host, sizeof(host));
  // A link-local address is one of its interface.
  const std::string scope = v6.sin6_scope_id == 0 ? "" : absl::StrCat("%", v6.sin6_scope_id);
  return absl::StrCat("ipv6:[", host, scope, "]:", ntohs(v6.sin6_port));
}

std::map<std::string, Traffic> ConnectionsTo(int port) {
  std::map<std::string, Traffic> connections;
  ForEachConnection(port, [&](int, const std::string& peer, const Traffic& traffic) { connections[peer] = traffic; });
  return connections;
}

std::vector<std::string> PeersTo(int port) {
  std::vector<std::string> peers;
  ForEachConnection(port, [&](int, const std::string& peer, const Traffic&) { peers.push_back(peer); });
  return peers;
}

int EndConnections(int port, const std::function<bool(const std::string& peer, const Traffic& traffic)>& ends) {
  int count = 0;
  ForEachConnection(port, [&](int descriptor, const std::string& peer, const Traffic& traffic) {
    if (!ends(peer, traffic)) return;
    // Whoever is still sending hears of it when gRPC closes the socket, and not only when the system gives it up.
    const linger none = {.l_onoff = 1, .l_linger = 0};
    setsockopt(descriptor, SOL_SOCKET, SO_LINGER, &none, sizeof(none));
    count += shutdown(descriptor, SHUT_RDWR) == 0 ? 1 : 0;
  });
  return count;
}

absl::StatusOr<bool> IsLocalOnly(const std::string& address) {
  ASSIGN_OR_RETURN(const Spot spot, ReadAddress(address));
  if (spot.kind != Spot::Kind::kHost) return true;
  std::string why = "no address";
  const Addresses found = Resolve(spot.name, spot.port, &why);
  if (found == nullptr) return Failed(address, why);
  for (const addrinfo* at = found.get(); at != nullptr; at = at->ai_next) {
    if (!IsLoopback(at->ai_addr)) return false;
  }
  return true;
}

absl::Status Unprotected(const std::string& address) {
  return base::Error(absl::StatusCode::kFailedPrecondition,
                     address +
                         ", can be reached from other machines, and whoever reaches it could approve calibrations: "
                         "set tls.certificate and tls.key (deploy/make-certs makes them), or listen on "
                         "127.0.0.1:PORT, [::1]:PORT or unix:PATH",
                     {"LISTEN_UNPROTECTED", {{"address", address}}});
}

absl::StatusOr<std::unique_ptr<Listener>> Listener::Open(const std::string& address) {
  std::unique_ptr<Listener> listener(new Listener());
  ASSIGN_OR_RETURN(const Spot spot, ReadAddress(address));
  RETURN_IF_ERROR(spot.kind == Spot::Kind::kHost
                      ? listener->BindHost(address, spot.name, spot.port)
                      : listener->BindUnix(address, spot.name, spot.kind == Spot::Kind::kAbstract));
  listener->wake_ = eventfd(0, EFD_CLOEXEC);
  if (listener->wake_ < 0) return Failed(address, std::strerror(errno));
  return listener;
}

absl::Status Listener::BindHost(const std::string& address, const std::string& host, const std::string& port) {
  // Both families where no address is stated; IPv4 alone on a machine without the other.
  const bool is_any = host == "0.0.0.0" || host == "::";
  const std::vector<std::string> hosts = is_any ? std::vector<std::string>{"::", "0.0.0.0"} : std::vector{host};
  std::string why = "no address";
  for (const std::string& name : hosts) {
    const Addresses found = Resolve(name, port, &why);
    for (const addrinfo* at = found.get(); at != nullptr; at = at->ai_next) {
      if (port_ != 0) SetPort(at->ai_addr, port_);
      const int socket = Listening(at->ai_addr, at->ai_addrlen);
      if (socket < 0) {
        why = std::strerror(errno);
        // Part of a name's addresses may be of a family that this machine has not; one that is taken is taken.
        if (errno == EADDRINUSE || errno == EACCES) return Failed(address, why);
        continue;
      }
      sockets_.push_back(socket);
      is_local_only_ &= IsLoopback(at->ai_addr);
      port_ = PortOf(socket);
    }
    if (is_any && !sockets_.empty()) return absl::OkStatus();
  }
  return sockets_.empty() ? Failed(address, why) : absl::OkStatus();
}

absl::Status Listener::BindUnix(const std::string& address, const std::string& name, bool is_abstract) {
  sockaddr_un place = {};
  place.sun_family = AF_UNIX;
  const size_t offset = is_abstract ? 1 : 0;  // an abstract name begins with a zero byte
  if (name.empty() || name.size() + offset >= sizeof(place.sun_path)) {
    return Failed(address, absl::StrCat(name.size(), " bytes, a socket's name has 1 to ", sizeof(place.sun_path) - 2));
  }
  std::memcpy(place.sun_path + offset, name.data(), name.size());
  struct stat info;
  const size_t size = offsetof(sockaddr_un, sun_path) + offset + name.size() + (is_abstract ? 0 : 1);
  // A socket at which nobody listens is what a server that was killed has left.
  if (!is_abstract && stat(name.c_str(), &info) == 0 && S_ISSOCK(info.st_mode)) {
    const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool is_left = probe >= 0 &&
                         connect(probe, reinterpret_cast<const sockaddr*>(&place), static_cast<socklen_t>(size)) != 0 &&
                         errno == ECONNREFUSED;
    if (probe >= 0) close(probe);
    if (!is_left) return Failed(address, "another server listens there");
    unlink(name.c_str());
  }
  const int socket = Listening(reinterpret_cast<const sockaddr*>(&place), static_cast<socklen_t>(size));
  if (socket < 0) return Failed(address, std::strerror(errno));
  sockets_.push_back(socket);
  if (!is_abstract && stat(name.c_str(), &unlink_file_) == 0) unlink_path_ = name;
  return absl::OkStatus();
}

Listener::~Listener() {
  Stop();
  if (wake_ >= 0) close(wake_);
}

void Listener::Start(Take take, TellRefused tell_refused) {
  DEMAND(!thread_.joinable() && !sockets_.empty());
  take_ = std::move(take);
  tell_refused_ = std::move(tell_refused);
  rlimit limit = {};
  DEMAND(getrlimit(RLIMIT_NOFILE, &limit) == 0);
  first_kept_descriptor_ = static_cast<int64_t>(limit.rlim_cur - limit.rlim_cur / 4);
  thread_ = std::thread([this] { Loop(); });
}

void Listener::Stop() {
  if (thread_.joinable()) {
    eventfd_write(wake_, 1);
    thread_.join();
  }
  // While we listen nobody takes the path over. What stands there may be another server's all the same, where somebody
  // had removed ours.
  if (const std::string path = std::exchange(unlink_path_, ""); !path.empty()) {
    struct stat now = {};
    const bool is_ours =
        stat(path.c_str(), &now) == 0 && now.st_dev == unlink_file_.st_dev && now.st_ino == unlink_file_.st_ino;
    if (is_ours) unlink(path.c_str());
  }
  for (const int socket : std::exchange(sockets_, {})) close(socket);
}

void Listener::Loop() {
  std::vector<pollfd> polled = {{wake_, POLLIN, 0}};
  for (const int socket : sockets_) polled.push_back({socket, POLLIN, 0});
  while (true) {
    if (poll(polled.data(), polled.size(), -1) < 0) continue;
    if (polled[0].revents != 0) return;
    for (size_t i = 1; i < polled.size(); ++i) {
      if (polled[i].revents != 0) AcceptAll(polled[i].fd);
    }
  }
}

void Listener::AcceptAll(int listening) {
  while (true) {
    const int connection = accept4(listening, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (connection < 0) {
      if (errno == EAGAIN || errno == EWOULDBLOCK) return;
      if (errno != EMFILE && errno != ENFILE && errno != ENOBUFS && errno != ENOMEM) continue;  // this one is gone
      pollfd wake = {wake_, POLLIN, 0};
      poll(&wake, 1, kNoRoomPauseMs);
      return;
    }
    // The lowest free number is given: as many descriptors are open already.
    if (connection >= first_kept_descriptor_) {
      Refuse(connection);
      continue;
    }
    is_refusing_ = false;
    Set(connection, IPPROTO_TCP, TCP_NODELAY, 1);
    ucred peer = {};
    socklen_t size = sizeof(peer);
    if (port_ == 0 && getsockopt(connection, SOL_SOCKET, SO_PEERCRED, &peer, &size) == 0) {
      const base::MutexLock lock(users_mutex_);
      users_.insert(peer.uid);
    }
    take_(listening, connection);
  }
}

std::set<uid_t> Listener::users() const {
  const base::MutexLock lock(users_mutex_);
  return users_;
}

void Listener::Refuse(int connection) {
  close(connection);
  ++refused_;
  if (!std::exchange(is_refusing_, true)) tell_refused_(refused_);
}

}  // namespace axiscal::server
