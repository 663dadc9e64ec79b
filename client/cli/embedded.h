// Without --server the service runs in the command line's own process: the one place of client/ that stands on server/.
#ifndef AXISCAL_CLIENT_CLI_EMBEDDED_H_
#define AXISCAL_CLIENT_CLI_EMBEDDED_H_

#include <string>

#include "client/cli/context.h"

namespace axiscal::cli {

// As server::StartEmbedded.
absl::StatusOr<Connection> StartServiceHere(const std::string& database, const client::Options& options);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_EMBEDDED_H_
