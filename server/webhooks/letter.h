// What is sent to an address, and how it is signed, by the Standard Webhooks
// (https://github.com/standard-webhooks/standard-webhooks): any of their libraries checks it.
#ifndef AXISCAL_SERVER_WEBHOOKS_LETTER_H_
#define AXISCAL_SERVER_WEBHOOKS_LETTER_H_

#include <string>

#include "core/base/clock.h"
#include "core/base/status.h"
#include "core/records/event.h"
#include "core/records/webhook.h"
#include "server/webhooks/addresses.h"

namespace axiscal::webhooks {

struct Letter {
  std::string url;
  std::string id;    // the same for each try: who has seen it passes it over
  std::string body;  // JSON; of e-mail text for people
  std::string secret;
  std::string subject = {};  // of e-mail
};

// "whsec_" and 32 random bytes as base64.
std::string NewSecret();
// "v1," and the HMAC-SHA256 of "id.timestamp.body" as base64. `timestamp_s`: seconds since 1970-01-01 UTC.
std::string Signature(const std::string& secret, const std::string& id, int64_t timestamp_s, const std::string& body);

// A change of an event as WatchEvents sends it, in JSON of a WebhookLetter; by e-mail in words.
Letter LetterOf(const records::WebhookRecord& webhook, const records::EventChange& change);
// Says that it is a test.
Letter TestLetter(const records::WebhookRecord& webhook, base::UtcTime now);

// INVALID_ARGUMENT, field "webhook.url": no URL by http or https, a user, a password or a fragment in it, more than
// 2000 bytes, no addresses behind mailto:, or an address that `rule` refuses as it stands there (null: who sends
// is not here, and judges it).
absl::Status CheckUrl(const std::string& url, const AddressRule* rule);

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_LETTER_H_
