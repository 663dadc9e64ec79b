// Brings letters to addresses by HTTP, and mails to the plant's SMTP server, several at a time on one thread, with
// libcurl. A letter ends with its answer, or
// after `timeout`; redirects are not followed, no proxy is used, no cookie kept.
#ifndef AXISCAL_SERVER_WEBHOOKS_POSTER_H_
#define AXISCAL_SERVER_WEBHOOKS_POSTER_H_

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/records/webhook.h"
#include "server/webhooks/addresses.h"
#include "server/webhooks/letter.h"
#include "server/webhooks/mail.h"

namespace axiscal::webhooks {

struct PosterOptions {
  AddressRule addresses;
  // Authorities of https addresses, PEM; empty: those that the system trusts.
  std::string ca_file;
  // Of letters to mailto: addresses; absent: they fail.
  std::optional<MailServer> mail = {};
  // From the first byte to the end of the answer. > 0.
  std::chrono::milliseconds timeout = std::chrono::seconds(10);
  base::Clock* clock = &base::SystemClock();  // of the time that is signed
};

// Of one thread, but for Wake().
class Poster {
 public:
  explicit Poster(PosterOptions options);
  // Gives up what is under way.
  ~Poster();
  Poster(const Poster&) = delete;
  Poster& operator=(const Poster&) = delete;

  // `key`: not under way.
  void Begin(int64_t key, const Letter& letter);
  bool is_under_way(int64_t key) const { return under_way_.contains(key); }
  int count() const { return static_cast<int>(under_way_.size()); }
  struct Ended {
    int64_t key = 0;
    records::WebhookTrial trial;
  };
  // What has ended; where nothing has, waits for it, for Wake(), or for so long.
  std::vector<Ended> Wait(std::chrono::milliseconds timeout);
  // From any thread: Wait() returns.
  void Wake();

 private:
  struct Transfer;

  const PosterOptions options_;
  void* const multi_;
  std::map<int64_t, std::unique_ptr<Transfer>> under_way_;
};

// One letter, on this thread; CANCELLED where `is_cancelled` says so.
absl::StatusOr<records::WebhookTrial> PostOnce(const PosterOptions& options, const Letter& letter,
                                               const std::function<bool()>& is_cancelled);

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_POSTER_H_
