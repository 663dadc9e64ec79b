#include "server/webhooks/mail_server.h"

#include <algorithm>
#include <string_view>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_split.h"

namespace axiscal::webhooks {
namespace {

constexpr size_t kMostAddressBytes = 254;  // RFC 5321

}  // namespace

bool IsMailAddress(const std::string& text) {
  const std::pair<std::string, std::string> parts = absl::StrSplit(text, absl::MaxSplits('@', 1));
  const auto is_local = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
           std::string_view(".!#$%&'*+/=?^_`{|}~-").find(c) != std::string_view::npos;
  };
  const auto is_domain = [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '-';
  };
  return text.size() <= kMostAddressBytes && !parts.first.empty() && !parts.second.empty() &&
         std::all_of(parts.first.begin(), parts.first.end(), is_local) &&
         std::all_of(parts.second.begin(), parts.second.end(), is_domain) &&
         absl::ascii_isalnum(static_cast<unsigned char>(parts.second.front()));
}

absl::Status Check(const MailServer& server) {
  const bool is_smtps = absl::StartsWith(server.url, "smtps://");
  if (!is_smtps && !absl::StartsWith(server.url, "smtp://"))
    return absl::InvalidArgumentError("mail.server = " + server.url + ", must begin with smtp:// or smtps://");
  if (server.url.find('@') != std::string::npos)
    return absl::InvalidArgumentError(
        "mail.server must hold neither a user nor a password: mail.user, mail.password_file");
  if (!IsMailAddress(server.from))
    return absl::InvalidArgumentError("mail.from = '" + server.from + "', must be an address: axiscal@plant.example");
  if (server.user.empty() != server.password_file.empty())
    return absl::InvalidArgumentError("mail.user and mail.password_file must come together");
  if (!server.user.empty() && !server.needs_tls && !is_smtps)
    return absl::InvalidArgumentError("mail.without_tls = true: no password is sent without TLS, leave mail.user out");
  return absl::OkStatus();
}

}  // namespace axiscal::webhooks
