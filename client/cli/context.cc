#include "client/cli/context.h"

#include <pwd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>

namespace axiscal::cli {
namespace {

// The name under which work is written down: the login name.
std::string LoginName() {
  const passwd* entry = getpwuid(getuid());
  return entry != nullptr && entry->pw_name[0] != '\0' ? entry->pw_name : "anonymous";
}

}  // namespace

Context::Context(StartService start_service) : user(LoginName()), start_service_(std::move(start_service)) {}

absl::StatusOr<client::Client*> Context::Connect() {
  if (!connection_) {
    client::Options options;
    options.user = user;
    // Of whatever runs this command; one that is no traceparent is as none (W3C Trace Context).
    const char* const trace = std::getenv("TRACEPARENT");
    if (trace != nullptr && !client::TraceIdOf(trace).empty()) options.trace_parent = trace;
    if (server.empty()) {
      ASSIGN_OR_RETURN(connection_, start_service_(database, options));
    } else {
      options.identity = identity;
      ASSIGN_OR_RETURN(client::Client client, client::Client::Connect(server, options));
      connection_ = Connection{nullptr, std::move(client)};
    }
  }
  return &connection_->client;
}

void Context::Print(const Json& json_result, const std::string& text) const {
  const std::string out = json ? json_result.Dump() + "\n" : text;
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
