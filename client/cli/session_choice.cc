#include "client/cli/session_choice.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "core/session/case.h"

namespace axiscal::cli {
namespace {

bool IsNumber(const std::string& text) {
  return text.size() <= 18 &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

// A number is an id; anything else the name of exactly one stored session.
absl::StatusOr<SessionId> Resolve(const std::string& option, const std::string& text, const MachineId& machine,
                                  const std::vector<records::SessionRecord>& stored) {
  if (IsNumber(text)) return SessionId(std::stoll(text));
  std::string ids;
  SessionId found;
  int count = 0;
  for (const records::SessionRecord& record : stored) {
    if (record.name != text) continue;
    found = record.id;
    absl::StrAppend(&ids, count++ == 0 ? "" : ", ", record.id.number());
  }
  if (count == 1) return found;
  if (count == 0) {
    return absl::NotFoundError(
        absl::StrCat(option, ": machine ", machine.text(), " has no complete session '", text, "'"));
  }
  return absl::InvalidArgumentError(absl::StrCat(option, ": ", count, " sessions of machine ", machine.text(),
                                                 " are called '", text, "', give the number: one of ", ids));
}

}  // namespace

absl::StatusOr<std::vector<records::SessionRecord>> CompleteSessions(client::Client& client, const MachineId& machine) {
  std::vector<records::SessionRecord> sessions;
  client::SessionFilter filter{machine, records::SessionState::kComplete};
  records::PageRequest request{1000, ""};
  do {
    ASSIGN_OR_RETURN(const auto page, client.ListSessions(filter, request));
    sessions.insert(sessions.end(), page.rows.begin(), page.rows.end());
    request.token = page.next_token;
  } while (!request.token.empty());
  std::reverse(sessions.begin(), sessions.end());  // in the order in which they were stored
  return sessions;
}

absl::StatusOr<std::vector<SessionId>> NamedSessions(client::Client& client, const MachineId& machine,
                                                     const std::string& option, const std::vector<std::string>& texts) {
  std::vector<records::SessionRecord> stored;
  if (!std::all_of(texts.begin(), texts.end(), IsNumber)) {
    ASSIGN_OR_RETURN(stored, CompleteSessions(client, machine));
  }
  std::vector<SessionId> chosen;
  for (const std::string& text : texts) {
    ASSIGN_OR_RETURN(const SessionId id, Resolve(option, text, machine, stored));
    chosen.push_back(id);
  }
  return chosen;
}

absl::StatusOr<session::Session> SessionFrom(Context& context, const machine::Machine& machine,
                                             const std::string& option, const std::string& file_or_name) {
  if (std::filesystem::exists(file_or_name)) return session::ReadSessionFileOf(file_or_name, machine);
  const bool is_path = file_or_name.find_first_of("/.") != std::string::npos;
  if (is_path) return absl::NotFoundError(file_or_name + ": no such file");
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const std::vector<SessionId> ids,
                   NamedSessions(*client, MachineId(machine.id), option, {file_or_name}));
  return client->DownloadSession(ids[0]);
}

}  // namespace axiscal::cli
