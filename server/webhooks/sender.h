// Tells addresses of events: each change of the stream of events (docs/events.md), in order, one at a time for an
// address, several addresses at a time. What was taken is on the disk before the next is sent, so that a server that is
// killed goes on where it was; the one under way is then sent again under the same id.
#ifndef AXISCAL_SERVER_WEBHOOKS_SENDER_H_
#define AXISCAL_SERVER_WEBHOOKS_SENDER_H_

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/storage/database.h"
#include "server/watch/event_board.h"
#include "server/webhooks/poster.h"

namespace axiscal::webhooks {

// How often a change is tried: where the receiver is not there (no answer; of HTTP 5xx, 408, 425, 429; of SMTP 4xx),
// and where it refuses what came, or leads elsewhere (all other answers but 2xx). Then it is a dead letter.
inline constexpr int kTries = 12, kTriesOfRefused = 4;
bool MayBeTakenLater(const records::WebhookTrial& trial);
// Before the next try, after `tries` that failed: 5 s, twice as long each time, up to an hour; of that a part, half of
// it and `random` (0 .. 1) times the other half, so that not all come back at one moment.
std::chrono::milliseconds WaitAfter(int tries, double random);

struct SenderOptions {
  PosterOptions post;
  // Told of each try that failed, of what became a dead letter, and where the store does not give what comes next. May
  // be empty.
  std::function<void(const records::WebhookRecord& webhook, const std::string& error, bool is_dead)> tell;
  // Told of each try: "TAKEN", "FAILED", "DEAD". May be empty.
  std::function<void(const std::string& outcome)> count;
  // Where this is false, another process sends (Database::IsCaretaker()); asked each time before one is sent. Empty:
  // true.
  std::function<bool()> is_mine;
  // 0 .. 1; empty: evenly.
  std::function<double()> random;
};

class Sender {
 public:
  // `database` must outlive it.
  Sender(storage::Database& database, std::shared_ptr<watch::EventBoard> board, SenderOptions options);
  // Stops.
  ~Sender();
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  bool has_mail() const { return options_.post.mail.has_value(); }
  const AddressRule& addresses() const { return options_.post.addresses; }
  void Start();
  // Gives up what is under way, which is sent again after the next start. Harmless when repeated, or not started.
  void Stop();
  // Something was said of webhooks. Never waits; from any thread.
  void LookSoon();
  // A test letter, on this thread; what came of it is stored nowhere.
  absl::StatusOr<records::WebhookTrial> Try(const records::WebhookRecord& webhook,
                                            const std::function<bool()>& is_cancelled) const;

  // On this thread, for tests, not after Start(): until nothing is under way and nothing is to be sent now.
  void SendDue();

 private:
  // What is known of an address between two letters.
  struct Line {
    int64_t etag = 0;
    std::deque<records::EventChange> next;  // changes after the one that was handled last
    int64_t up_to = 0;                      // all up to it are in `next`, or handled
    bool is_wanted_letter = false;          // of the one under way
    records::WebhookRecord sent;            // as it was when the one under way began
    int64_t change = 0;                     // under way
    base::SteadyTime held_until{};          // what came of a letter could not be stored
  };

  void Loop();
  // Begins what is due; until when nothing more is, at most `kIdle` ahead.
  std::chrono::milliseconds BeginDue();
  // The store does not give what comes next: told of, and asked again later.
  void HoldUp(const records::WebhookRecord& webhook, Line& line, const absl::Status& status);
  // Whether something is under way now.
  absl::StatusOr<bool> BeginNext(const records::WebhookRecord& webhook, Line& line);
  void Take(const std::vector<Poster::Ended>& ended);
  absl::Status End(Line& line, const records::WebhookTrial& trial);

  storage::Database& database_;
  const std::shared_ptr<watch::EventBoard> board_;
  const SenderOptions options_;
  Poster poster_;
  std::map<WebhookId, Line> lines_;
  std::atomic<bool> stopping_ = false;
  std::atomic<bool> is_changed_ = true;
  std::thread thread_;
};

}  // namespace axiscal::webhooks

#endif  // AXISCAL_SERVER_WEBHOOKS_SENDER_H_
