#include "server/embedded.h"

#include "absl/synchronization/mutex.h"

namespace axiscal::server {

absl::StatusOr<Embedded> StartEmbedded(const std::string& database_path, const client::Options& options) {
  // Debian's Abseil aborts on lock orders that gRPC takes while a server is stopped.
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
  ServerOptions server_options;
  server_options.database_path = database_path;
  // Whoever ends the process wants it to end: a job that runs is parked for the next one.
  server_options.drain = std::chrono::milliseconds(200);
  ASSIGN_OR_RETURN(std::unique_ptr<Server> server, Server::Start(server_options));
  ASSIGN_OR_RETURN(client::Client client, client::Client::InProcess(server->InProcessChannel(), options));
  return Embedded{std::move(server), std::move(client)};
}

}  // namespace axiscal::server
