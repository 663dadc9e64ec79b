// What every sub-command shares: the global options, the connection, and where results go.
#ifndef AXISCAL_CLIENT_CLI_CONTEXT_H_
#define AXISCAL_CLIENT_CLI_CONTEXT_H_

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/cli/output.h"
#include "client/client.h"

namespace CLI {
class App;
}

namespace axiscal::cli {

// The way to a service.
struct Connection {
  std::shared_ptr<void> service;  // that the client speaks to, when it runs in this process; outlives it
  client::Client client;
};

struct Context {
  // Starts the service in this process on a database file (embedded.h).
  using StartService =
      std::function<absl::StatusOr<Connection>(const std::string& database, const client::Options& options)>;
  explicit Context(StartService start_service);

  std::string server;  // address; empty: the service runs in this process on `database`
  std::string database = "axiscal.db";
  client::Identity identity;  // for a server
  std::string user;
  bool json = false;

  absl::Status status;  // of the sub-command that ran

  // Connected on first use; valid as long as the context.
  absl::StatusOr<client::Client*> Connect();
  // One JSON document, or the text.
  void Print(const Json& json_result, const std::string& text) const;
  // A line for people on standard error; nothing with --json.
  void Note(const std::string& line) const;
  ProgressBar Bar(const std::string& what) const { return ProgressBar(what, !json); }

 private:
  const StartService start_service_;
  std::optional<Connection> connection_;
};

// Makes `run` the action of a sub-command.
void SetAction(CLI::App* command, Context& context, std::function<absl::Status()> run);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_CONTEXT_H_
