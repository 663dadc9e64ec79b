#include "client/cli/embedded.h"

#include "server/embedded.h"

namespace axiscal::cli {

absl::StatusOr<Connection> StartServiceHere(const std::string& database, const client::Options& options) {
  ASSIGN_OR_RETURN(server::Embedded embedded, server::StartEmbedded(database, options));
  return Connection{std::move(embedded.server), std::move(embedded.client)};
}

}  // namespace axiscal::cli
