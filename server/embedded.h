// The whole service inside this process, for the command line without a server and for tests: the same handlers, jobs
// and store, reached through the client library.
#ifndef AXISCAL_SERVER_EMBEDDED_H_
#define AXISCAL_SERVER_EMBEDDED_H_

#include <memory>
#include <string>

#include "client/client.h"
#include "server/server.h"

namespace axiscal::server {

// Owns the service; the client is good as long as it lives.
struct Embedded {
  std::unique_ptr<Server> server;
  client::Client client;
};

// On a database file, made when it is not there. Nothing is logged. UNAVAILABLE STORE_LOCKED when another process has
// the file: use its server.
absl::StatusOr<Embedded> StartEmbedded(const std::string& database_path, const client::Options& options = {});

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_EMBEDDED_H_
