#include "client/cli/context.h"

#include <pwd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>

#include "server/embedded.h"

namespace axiscal::cli {
namespace {

// The name under which work is written down: the login name.
std::string LoginName() {
  const passwd* entry = getpwuid(getuid());
  return entry != nullptr && entry->pw_name[0] != '\0' ? entry->pw_name : "anonymous";
}

}  // namespace

class Connection {
 public:
  explicit Connection(client::Client client) : remote_(std::move(client)) {}
  explicit Connection(server::Embedded embedded) : embedded_(std::move(embedded)) {}
  client::Client* client() { return remote_ ? &*remote_ : &embedded_->client; }

 private:
  std::optional<client::Client> remote_;
  std::optional<server::Embedded> embedded_;
};

Context::Context() : user(LoginName()) {}
Context::~Context() = default;

absl::StatusOr<client::Client*> Context::Connect() {
  if (connection_ == nullptr) {
    client::Options options;
    options.user = user;
    if (server.empty()) {
      ASSIGN_OR_RETURN(server::Embedded embedded, server::StartEmbedded(database, options));
      connection_ = std::make_unique<Connection>(std::move(embedded));
    } else {
      ASSIGN_OR_RETURN(client::Client client, client::Client::Connect(server, options));
      connection_ = std::make_unique<Connection>(std::move(client));
    }
  }
  return connection_->client();
}

void Context::Print(const Json& json_result, const std::string& text) const {
  const std::string out = json ? json_result.dump(1, ' ', false, Json::error_handler_t::replace) + "\n" : text;
  std::fwrite(out.data(), 1, out.size(), stdout);
}

void Context::Note(const std::string& line) const {
  if (!json) std::fprintf(stderr, "%s\n", line.c_str());
}

void SetAction(CLI::App* command, Context& context, std::function<absl::Status()> run) {
  command->fallthrough();  // --json and the like are read behind the sub-command too
  command->callback([&context, run = std::move(run)] { context.status = run(); });
}

}  // namespace axiscal::cli
