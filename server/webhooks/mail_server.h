// The plant's SMTP server, as axiscald.toml has it.
#ifndef AXISCAL_SERVER_WEBHOOKS_MAIL_SERVER_H_
#define AXISCAL_SERVER_WEBHOOKS_MAIL_SERVER_H_

#include <string>

#include "core/base/status.h"

namespace axiscal::webhooks {

struct MailServer {
  std::string url;   // smtp://HOST[:PORT] (STARTTLS) or smtps://HOST[:PORT]
  std::string from;  // whom the mails are from: an address
  std::string user;  // empty: it is not asked who we are
  std::string
      password_file;    // read for each mail, so that a new one needs no restart; its last line end does not count
  std::string ca_file;  // authorities of its certificate, PEM; empty: those that the system trusts
  // Neither a mail nor the password goes over a connection that is not encrypted. False: only where no password is
  // sent.
  bool needs_tls = true;
};
// INVALID_ARGUMENT naming the member: no URL of SMTP, no address, a user without a password or without TLS.
absl::Status Check(const MailServer& server);
// LOCAL@DOMAIN of letters, digits and ".!#$%&'*+/=?^_`{|}~-", at most 254 bytes: nothing that ends a line or a command.
bool IsMailAddress(const std::string& text);

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_MAIL_SERVER_H_
