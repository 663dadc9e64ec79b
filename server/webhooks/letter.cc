#include "server/webhooks/letter.h"

#include <curl/curl.h>
#include <google/protobuf/util/json_util.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <unistd.h>

#include <memory>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "axiscal/v1/webhooks_service.pb.h"
#include "core/base/demand.h"
#include "proto/convert/event.h"
#include "proto/convert/field.h"
#include "server/webhooks/mail.h"

namespace axiscal::webhooks {
namespace {

constexpr char kSecretPrefix[] = "whsec_";
constexpr size_t kSecretBytes = 32, kMostUrlBytes = 2000;

std::string JsonOf(const v1::WebhookLetter& letter) {
  std::string json;
  DEMAND(google::protobuf::util::MessageToJsonString(letter, &json).ok());
  return json;
}

std::string PartOf(CURLU* url, CURLUPart part, unsigned flags = 0) {
  char* text = nullptr;
  if (curl_url_get(url, part, &text, flags) != CURLUE_OK) return "";
  std::string copy = text;
  curl_free(text);
  return copy;
}

}  // namespace

std::string NewSecret() {
  std::string bytes(kSecretBytes, '\0');
  DEMAND(getentropy(bytes.data(), bytes.size()) == 0);
  return kSecretPrefix + absl::Base64Escape(bytes);
}

std::string Signature(const std::string& secret, const std::string& id, int64_t timestamp_s, const std::string& body) {
  std::string key;
  // A secret that the disk has changed signs nothing that a receiver takes.
  const bool is_whole =
      secret.rfind(kSecretPrefix, 0) == 0 && absl::Base64Unescape(secret.substr(sizeof(kSecretPrefix) - 1), &key);
  if (!is_whole) key = secret;
  const std::string text = absl::StrCat(id, ".", timestamp_s, ".", body);
  std::string digest(EVP_MAX_MD_SIZE, '\0');
  unsigned int size = 0;
  DEMAND(HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()),
              reinterpret_cast<const unsigned char*>(text.data()), text.size(),
              reinterpret_cast<unsigned char*>(digest.data()), &size) != nullptr);
  digest.resize(size);
  return "v1," + absl::Base64Escape(digest);
}

Letter LetterOf(const records::WebhookRecord& webhook, const records::EventChange& change) {
  const std::string id = absl::StrCat("webhook-", webhook.id.number(), "-change-", change.id);
  if (IsMail(webhook.content.url)) return {webhook.content.url, id, TextOf(change), "", SubjectOf(change)};
  v1::WebhookLetter letter;
  letter.set_type(absl::StrCat("event.", records::WordOf(change.what)));
  *letter.mutable_change() = convert::ToProto(change);
  return {webhook.content.url, id, JsonOf(letter), webhook.secret};
}

Letter TestLetter(const records::WebhookRecord& webhook, base::UtcTime now) {
  const std::string id = absl::StrCat("webhook-", webhook.id.number(), "-test-", base::ToUtcUs(now));
  if (IsMail(webhook.content.url)) {
    return {webhook.content.url, id, "This is a test: mails of events come here.\n", "", "[axiscal] test"};
  }
  v1::WebhookLetter letter;
  letter.set_type("test");
  return {webhook.content.url, id, JsonOf(letter), webhook.secret};
}

absl::Status CheckUrl(const std::string& url, const AddressRule* rule) {
  const auto refuse = [](const std::string& why) { return convert::FieldError("webhook.url", why); };
  RETURN_IF_ERROR(convert::RequireText("webhook.url", url, 1, kMostUrlBytes));
  if (IsMail(url)) return RecipientsOf(url).status();
  const std::unique_ptr<CURLU, decltype(&curl_url_cleanup)> parsed(curl_url(), &curl_url_cleanup);
  const CURLUcode code = curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), 0);
  if (code != CURLUE_OK) return refuse(absl::StrCat("is no URL: ", curl_url_strerror(code)));
  const std::string scheme = PartOf(parsed.get(), CURLUPART_SCHEME);
  if (scheme != "http" && scheme != "https")
    return refuse("must begin with http://, https:// or mailto:, not " + scheme + "://");
  if (!PartOf(parsed.get(), CURLUPART_USER).empty() || !PartOf(parsed.get(), CURLUPART_PASSWORD).empty())
    return refuse("must hold neither a user nor a password: letters are signed");
  if (!PartOf(parsed.get(), CURLUPART_FRAGMENT).empty()) return refuse("must hold no fragment (#...)");
  if (rule == nullptr) return absl::OkStatus();
  int port = 0;
  // Always there: the scheme's own where the URL has none.
  static_cast<void>(absl::SimpleAtoi(PartOf(parsed.get(), CURLUPART_PORT, CURLU_DEFAULT_PORT), &port));
  const std::string why_not = rule->WhyNotHost(PartOf(parsed.get(), CURLUPART_HOST), port);
  if (!why_not.empty()) return refuse(why_not);
  return absl::OkStatus();
}

}  // namespace axiscal::webhooks
