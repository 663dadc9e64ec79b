// The listening socket of the service, and a thread that takes connections from it. gRPC 1.51 has a listener of its
// own, which stops for good at the first connection for which the process has no descriptor; this one closes the
// connections that would leave too few for the service itself, and goes on.
#ifndef AXISCAL_SERVER_LISTENER_H_
#define AXISCAL_SERVER_LISTENER_H_

#include <sys/stat.h>

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/base/mutex.h"
#include "core/base/status.h"

namespace axiscal::server {

// Raises this process' soft limit of descriptors to its hard limit; the limit that holds then.
int64_t RaiseDescriptorLimit();

// Whether this machine alone can reach an address as Listener::Open() takes it: a unix socket, or a host all of whose
// addresses are loopback ones. Binds nothing. UNAVAILABLE LISTEN_FAILED.
absl::StatusOr<bool> IsLocalOnly(const std::string& address);

// The refusal of an address that others can reach by a server that asks nobody who he is: FAILED_PRECONDITION
// LISTEN_UNPROTECTED, which says what to do.
absl::Status Unprotected(const std::string& address);

// As gRPC writes it where it listens ("ipv4:192.0.2.7:40312"), but with plain brackets ("ipv6:[::1]:40312",
// "ipv6:[fe80::1%2]:40312" with the number of its interface); empty for a socket without address.
std::string PeerOf(int connection);

// Of a connection, in bytes.
struct Traffic {
  int64_t brought = 0;
  int64_t untaken = 0;  // what was written to it and cannot be sent, as the other side takes nothing or not so fast
};

// The connections to `port` of this process, by their peers (PeerOf).
std::map<std::string, Traffic> ConnectionsTo(int port);
// The same without what came and went.
std::vector<std::string> PeersTo(int port);

// Ends the connections to `port` of this process that `ends` chooses; how many. Their calls are cancelled. `peer`:
// PeerOf().
int EndConnections(int port, const std::function<bool(const std::string& peer, const Traffic& traffic)>& ends);

class Listener {
 public:
  // Gets each connection (non-blocking) with the socket that it came from, on the listener's thread, and owns it.
  using Take = std::function<void(int listening, int connection)>;
  // Told when connections begin to be closed for want of descriptors, with how many were so far.
  using TellRefused = std::function<void(int64_t refused)>;

  // Binds and listens. `address` as gRPC has it: "HOST:PORT" with a name, an IPv4 address or an IPv6 address in
  // brackets (the unspecified address of either: both families), also behind "dns:", "ipv4:" or "ipv6:";
  // "unix:PATH" or "unix-abstract:NAME". Port 0 picks a free one. UNAVAILABLE LISTEN_FAILED says what is wrong.
  static absl::StatusOr<std::unique_ptr<Listener>> Open(const std::string& address);
  // Stops.
  ~Listener();
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  // 0 for sockets without ports.
  int port() const { return port_; }
  // As IsLocalOnly(), of what was bound: what a name stands for may change.
  bool is_local_only() const { return is_local_only_; }
  // Of a unix socket: the users whose processes have connected so far.
  std::set<uid_t> users() const;
  // Once. A quarter of the descriptors that the process may have now is kept from connections.
  void Start(Take take, TellRefused tell_refused);
  // Takes no more; `take` is not called afterwards. Repeating is harmless.
  void Stop();

 private:
  Listener() = default;
  absl::Status BindHost(const std::string& address, const std::string& host, const std::string& port);
  absl::Status BindUnix(const std::string& address, const std::string& name, bool is_abstract);
  void Loop();
  void AcceptAll(int listening);
  void Refuse(int connection);

  std::vector<int> sockets_;
  int port_ = 0;
  bool is_local_only_ = true;
  std::string unlink_path_;       // of a socket in the file system
  struct stat unlink_file_ = {};  // what it was when it was made
  int wake_ = -1;                 // an eventfd that ends Loop()
  Take take_;
  TellRefused tell_refused_;
  int64_t first_kept_descriptor_ = 0;  // a connection with this number or a higher one is closed
  int64_t refused_ = 0;
  bool is_refusing_ = false;
  mutable base::Mutex users_mutex_;
  std::set<uid_t> users_ AXISCAL_GUARDED_BY(users_mutex_);
  std::thread thread_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_LISTENER_H_
