// E-mail by the plant's own SMTP server: what an address of "mailto:" is sent, and by which server.
#ifndef AXISCAL_SERVER_WEBHOOKS_MAIL_H_
#define AXISCAL_SERVER_WEBHOOKS_MAIL_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/status.h"
#include "core/records/event.h"
#include "server/webhooks/mail_server.h"

namespace axiscal::webhooks {

// Whether a webhook's URL is one of e-mail.
bool IsMail(const std::string& url);
// The addresses of "mailto:ann@plant.example,bob@plant.example": 1 to 10, each LOCAL@DOMAIN of letters, digits and
// ".!#$%&'*+/=?^_`{|}~-". INVALID_ARGUMENT, field "webhook.url".
absl::StatusOr<std::vector<std::string>> RecipientsOf(const std::string& url);

// What people hear of by mail: that an event was raised, is back, or is over. Not every new number, and not what they
// said themselves.
bool IsToldByMail(records::EventChangeKind what);

// For people: in one line, and the whole.
std::string SubjectOf(const records::EventChange& change);
std::string TextOf(const records::EventChange& change);

struct MailHead {
  std::string from, id, subject;
  std::vector<std::string> to;
  base::UtcTime at;
};
// As RFC 5322 has it, lines ended by CR LF: headers in ASCII (RFC 2047), the text as base64, so that nothing of a text
// can be taken for a header or for the end.
std::string MessageOf(const MailHead& head, const std::string& text);

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_MAIL_H_
