// Sessions as people name them.
#ifndef AXISCAL_CLIENT_CLI_SESSION_CHOICE_H_
#define AXISCAL_CLIENT_CLI_SESSION_CHOICE_H_

#include <string>
#include <vector>

#include "client/cli/context.h"
#include "client/client.h"
#include "core/machine/machine.h"

namespace axiscal::cli {

// The machine's complete sessions in the order in which they were stored.
absl::StatusOr<std::vector<records::SessionRecord>> CompleteSessions(client::Client& client, const MachineId& machine);

// In the order of `texts`, each a session's number or its name. NOT_FOUND naming `option` when the machine has no
// complete session of that name, INVALID_ARGUMENT with their numbers when it has several.
absl::StatusOr<std::vector<SessionId>> NamedSessions(client::Client& client, const MachineId& machine,
                                                     const std::string& option, const std::vector<std::string>& texts);

// A session file of that name, checked against the machine, else a stored session of it by number or name. NOT_FOUND
// for a path without a file, and as above.
absl::StatusOr<session::Session> SessionFrom(Context& context, const machine::Machine& machine,
                                             const std::string& option, const std::string& file_or_name);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_SESSION_CHOICE_H_
