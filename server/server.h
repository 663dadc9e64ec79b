// The service on a database file: over a port, in this process, or both.
#ifndef AXISCAL_SERVER_SERVER_H_
#define AXISCAL_SERVER_SERVER_H_

#include <memory>

#include "core/base/status.h"
#include "server/server_options.h"

namespace grpc {
class Channel;
}

namespace axiscal::server {

// Safe from any thread.
class Server {
 public:
  // Opens the database, starts the workers, listens on both addresses. The store's errors (STORE_LOCKED, SCHEMA_NEWER
  // ...), UNAVAILABLE LISTEN_FAILED when the address is taken, FAILED_PRECONDITION LISTEN_UNPROTECTED when other
  // machines could reach it, or ReadTls()'s.
  static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options);
  // Shuts down.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // A channel to this server without a port; not after Shutdown().
  std::shared_ptr<grpc::Channel> InProcessChannel();
  // The ports that were bound; 0 without one.
  int port() const;
  int http_port() const;

  // OK where the store reads: a machine, the queue of jobs, and something anew from its disk. Its errors otherwise;
  // blocks for as long as the store does. Not after Shutdown().
  absl::Status Check();

  // NOT_SERVING, no new work, lets calls and jobs finish for as long as options say, parks jobs that did not. Repeating
  // is harmless.
  void Shutdown();

 private:
  class Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_SERVER_H_
