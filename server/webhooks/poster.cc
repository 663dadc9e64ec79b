#include "server/webhooks/poster.h"

#include <curl/curl.h>
#include <sys/socket.h>

#include <algorithm>

#include "absl/strings/ascii.h"
#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "core/base/utf8.h"

namespace axiscal::webhooks {
namespace {

// Of an answer it is its status that counts.
constexpr size_t kMostPasswordBytes = 4096;
constexpr size_t kMostAnswerBytes = 64 << 10, kShownAnswerBytes = 200;

void StartCurl() {
  static const bool started = curl_global_init(CURL_GLOBAL_DEFAULT) == CURLE_OK;
  DEMAND(started);
}

bool IsTaken(int status) { return status >= 200 && status < 300; }

// The beginning of what a receiver said, on one line.
std::string Shown(std::string text) {
  if (text.size() > kShownAnswerBytes) text = text.substr(0, kShownAnswerBytes) + "...";
  for (char& c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  return base::ToUtf8(text);
}

}  // namespace

struct Poster::Transfer {
  Transfer(int64_t name, const PosterOptions& poster, const Letter& letter)
      : key(name), options(poster), is_mail(IsMail(letter.url)), easy(curl_easy_init()), body(letter.body) {
    DEMAND(easy != nullptr);
    Set(CURLOPT_FOLLOWLOCATION, 0L);
    Set(CURLOPT_PROXY, "");
    Set(CURLOPT_NETRC, static_cast<long>(CURL_NETRC_IGNORED));
    Set(CURLOPT_NOSIGNAL, 1L);
    Set(CURLOPT_TIMEOUT_MS, static_cast<long>(options.timeout.count()));
    Set(CURLOPT_ERRORBUFFER, error);
    Set(CURLOPT_WRITEFUNCTION, &Transfer::Take);
    Set(CURLOPT_WRITEDATA, this);
    // Each letter's connection is judged by itself.
    Set(CURLOPT_FORBID_REUSE, 1L);
    Set(CURLOPT_FRESH_CONNECT, 1L);
    // A name that nobody resolves shall hold up neither other addresses nor the end of the server.
    Set(CURLOPT_QUICK_EXIT, 1L);
    if (is_mail) {
      AddressMail(letter);
    } else {
      AddressPost(letter);
    }
  }
  ~Transfer() {
    curl_easy_cleanup(easy);
    curl_slist_free_all(lines);
  }
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;

  void AddressPost(const Letter& letter) {
    const int64_t now_s = base::ToUtcUs(options.clock->UtcNow()) / 1'000'000;
    AddLine("Content-Type: application/json");
    AddLine("User-Agent: axiscald");
    AddLine("webhook-id: " + letter.id);
    AddLine(absl::StrCat("webhook-timestamp: ", now_s));
    AddLine("webhook-signature: " + Signature(letter.secret, letter.id, now_s, letter.body));
    AddLine("Expect:");  // else it waits for a word before it sends
    Set(CURLOPT_URL, letter.url.c_str());
    Set(CURLOPT_PROTOCOLS_STR, "http,https");
    Set(CURLOPT_POST, 1L);
    Set(CURLOPT_POSTFIELDS, body.data());
    Set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
    Set(CURLOPT_HTTPHEADER, lines);
    Set(CURLOPT_OPENSOCKETFUNCTION, &Transfer::OpenSocket);
    Set(CURLOPT_OPENSOCKETDATA, this);
    TrustOnly(options.ca_file);
  }
  // The server is the administrator's choice, in axiscald.toml: no rule of addresses holds for it.
  void AddressMail(const Letter& letter) {
    const absl::StatusOr<std::vector<std::string>> to = RecipientsOf(letter.url);
    if (!options.mail || !to.ok()) {
      refused =
          to.ok() ? "no mail server is configured (mail.server in axiscald.toml)" : std::string(to.status().message());
      Set(CURLOPT_URL, "smtp://mail.invalid");
      Set(CURLOPT_OPENSOCKETFUNCTION, &Transfer::OpenNothing);
      return;
    }
    const MailServer& server = *options.mail;
    body = MessageOf({server.from, letter.id, letter.subject, *to, options.clock->UtcNow()}, letter.body);
    for (const std::string& one : *to) AddLine(one);
    Set(CURLOPT_URL, server.url.c_str());
    Set(CURLOPT_PROTOCOLS_STR, "smtp,smtps");
    Set(CURLOPT_USE_SSL, static_cast<long>(server.needs_tls ? CURLUSESSL_ALL : CURLUSESSL_NONE));
    Set(CURLOPT_MAIL_FROM, server.from.c_str());
    Set(CURLOPT_MAIL_RCPT, lines);
    Set(CURLOPT_UPLOAD, 1L);
    Set(CURLOPT_READFUNCTION, &Transfer::Give);
    Set(CURLOPT_READDATA, this);
    TrustOnly(server.ca_file);
    if (server.user.empty()) return;
    const absl::StatusOr<std::string> password = base::ReadFile(server.password_file, kMostPasswordBytes);
    if (!password.ok()) {
      refused = "mail.password_file cannot be read: " + std::string(password.status().message());
      Set(CURLOPT_OPENSOCKETFUNCTION, &Transfer::OpenNothing);
      return;
    }
    Set(CURLOPT_USERNAME, server.user.c_str());
    Set(CURLOPT_PASSWORD, std::string(absl::StripTrailingAsciiWhitespace(*password)).c_str());
  }
  // Those in place of the system's: without the second line the folder of the system's own holds as well.
  void TrustOnly(const std::string& ca_file) {
    if (ca_file.empty()) return;
    Set(CURLOPT_CAINFO, ca_file.c_str());
    Set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));
  }

  template <typename T>
  void Set(CURLoption option, T value) {
    DEMAND(curl_easy_setopt(easy, option, value) == CURLE_OK);
  }
  void AddLine(const std::string& line) {
    curl_slist* const longer = curl_slist_append(lines, line.c_str());
    DEMAND(longer != nullptr);
    lines = longer;
  }

  static size_t Take(char* data, size_t size, size_t count, void* self) {
    Transfer& transfer = *static_cast<Transfer*>(self);
    transfer.answer_bytes += size * count;
    if (transfer.answer.size() <= kShownAnswerBytes) transfer.answer.append(data, std::min(size * count, kMostShown()));
    return transfer.answer_bytes > kMostAnswerBytes ? 0 : size * count;
  }
  static size_t kMostShown() { return kShownAnswerBytes + 1; }
  static size_t Give(char* to, size_t size, size_t count, void* self) {
    Transfer& transfer = *static_cast<Transfer*>(self);
    const size_t part = std::min(size * count, transfer.body.size() - transfer.given);
    std::copy_n(transfer.body.data() + transfer.given, part, to);
    transfer.given += part;
    return part;
  }
  static curl_socket_t OpenNothing(void*, curlsocktype, curl_sockaddr*) { return CURL_SOCKET_BAD; }
  static curl_socket_t OpenSocket(void* self, curlsocktype, curl_sockaddr* address) {
    Transfer& transfer = *static_cast<Transfer*>(self);
    const std::string why_not = transfer.options.addresses.WhyNot(&address->addr);
    if (why_not.empty()) return socket(address->family, address->socktype | SOCK_CLOEXEC, address->protocol);
    transfer.refused = why_not;
    return CURL_SOCKET_BAD;
  }

  std::string Failure(CURLcode code) const {
    return !refused.empty() ? refused : error[0] != '\0' ? Shown(error) : curl_easy_strerror(code);
  }
  records::WebhookTrial TrialOf(CURLcode code) const {
    records::WebhookTrial trial;
    trial.is_mail = is_mail;
    long status = 0;
    curl_off_t took_us = 0;
    curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &status);
    curl_easy_getinfo(easy, CURLINFO_TOTAL_TIME_T, &took_us);
    trial.status = static_cast<int>(status);
    trial.took_ms = took_us / 1000;
    if (is_mail) {
      // The reply to what failed, or to the mail.
      if (code != CURLE_OK) trial.error = Failure(code);
      if (trial.error.empty()) trial.status = 250;
      return trial;
    }
    // An answer that was cut off for its length has been given.
    const bool is_answered = code == CURLE_OK || (code == CURLE_WRITE_ERROR && answer_bytes > kMostAnswerBytes);
    if (!is_answered) {
      // A status whose answer never came is none.
      trial.status = 0;
      trial.error = Failure(code);
    } else if (status >= 300 && status < 400) {
      trial.error = absl::StrCat("HTTP ", status, ": redirects are not followed");
    } else if (!IsTaken(trial.status)) {
      trial.error = absl::StrCat("HTTP ", status, answer.empty() ? "" : ": ", Shown(answer));
    }
    return trial;
  }

  const int64_t key;
  const PosterOptions& options;
  const bool is_mail;
  CURL* const easy;
  std::string body;
  size_t given = 0;             // of the body, of mails
  curl_slist* lines = nullptr;  // headers; of mails whom they go to
  std::string answer, refused;
  size_t answer_bytes = 0;
  char error[CURL_ERROR_SIZE] = "";
};

Poster::Poster(PosterOptions options) : options_(std::move(options)), multi_((StartCurl(), curl_multi_init())) {
  DEMAND(multi_ != nullptr);
}

Poster::~Poster() {
  for (const auto& [key, transfer] : under_way_) curl_multi_remove_handle(multi_, transfer->easy);
  under_way_.clear();
  curl_multi_cleanup(multi_);
}

void Poster::Begin(int64_t key, const Letter& letter) {
  DEMAND(!is_under_way(key));
  auto transfer = std::make_unique<Transfer>(key, options_, letter);
  curl_easy_setopt(transfer->easy, CURLOPT_PRIVATE, transfer.get());
  DEMAND(curl_multi_add_handle(multi_, transfer->easy) == CURLM_OK);
  under_way_[key] = std::move(transfer);
}

std::vector<Poster::Ended> Poster::Wait(std::chrono::milliseconds timeout) {
  std::vector<Ended> ended;
  for (const bool may_wait : {true, false}) {
    int running = 0;
    DEMAND(curl_multi_perform(multi_, &running) == CURLM_OK);
    int left = 0;
    while (CURLMsg* const message = curl_multi_info_read(multi_, &left)) {
      if (message->msg != CURLMSG_DONE) continue;
      Transfer* transfer = nullptr;
      curl_easy_getinfo(message->easy_handle, CURLINFO_PRIVATE, &transfer);
      ended.push_back({transfer->key, transfer->TrialOf(message->data.result)});
      curl_multi_remove_handle(multi_, transfer->easy);
      under_way_.erase(ended.back().key);
    }
    if (!ended.empty() || !may_wait) break;
    curl_multi_poll(multi_, nullptr, 0, static_cast<int>(timeout.count()), nullptr);
  }
  return ended;
}

void Poster::Wake() { curl_multi_wakeup(multi_); }

absl::StatusOr<records::WebhookTrial> PostOnce(const PosterOptions& options, const Letter& letter,
                                               const std::function<bool()>& is_cancelled) {
  constexpr std::chrono::milliseconds kLooksAgain(100);
  Poster poster(options);
  poster.Begin(0, letter);
  while (!is_cancelled()) {
    const std::vector<Poster::Ended> ended = poster.Wait(kLooksAgain);
    if (!ended.empty()) return ended[0].trial;
  }
  return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
}

}  // namespace axiscal::webhooks
