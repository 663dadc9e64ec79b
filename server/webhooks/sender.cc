#include "server/webhooks/sender.h"

#include <algorithm>
#include <random>
#include <utility>

namespace axiscal::webhooks {
namespace {

// How long nothing is looked at where nobody says that something has changed.
constexpr std::chrono::milliseconds kIdle = std::chrono::seconds(10);
// How often it is asked whether this process has become the one that sends.
constexpr std::chrono::milliseconds kAsksWhose = std::chrono::seconds(2);
// How often it is looked whether somebody has.
constexpr std::chrono::milliseconds kLooksAgain(200);
// After the store could not give what comes next: it is told of each time.
constexpr std::chrono::milliseconds kStoreWait = std::chrono::minutes(1);
constexpr std::chrono::milliseconds kFirstWait = std::chrono::seconds(5), kLongestWait = std::chrono::hours(1);

storage::Visible VisibleFor(const records::Scope& scope) {
  if (scope.kind == records::Scope::Kind::kAll) return {};
  return {false, {scope}, ""};
}

double Random() {
  thread_local std::mt19937_64 engine(std::random_device{}());
  return std::uniform_real_distribution<double>(0.0, 1.0)(engine);
}

}  // namespace

bool MayBeTakenLater(const records::WebhookTrial& trial) {
  if (trial.is_mail) return trial.status < 500;
  return trial.status == 0 || trial.status >= 500 || trial.status == 408 || trial.status == 425 || trial.status == 429;
}

std::chrono::milliseconds WaitAfter(int tries, double random) {
  std::chrono::milliseconds wait = kFirstWait;
  for (int i = 1; i < tries && wait < kLongestWait; ++i) wait *= 2;
  wait = std::min(wait, kLongestWait);
  return std::chrono::milliseconds(static_cast<int64_t>(static_cast<double>(wait.count()) * (0.5 + 0.5 * random)));
}

Sender::Sender(storage::Database& database, std::shared_ptr<watch::EventBoard> board, SenderOptions options)
    : database_(database), board_(std::move(board)), options_(std::move(options)), poster_(options_.post) {}

Sender::~Sender() { Stop(); }

void Sender::Start() {
  thread_ = std::thread([this] { Loop(); });
}

void Sender::Stop() {
  stopping_ = true;
  poster_.Wake();
  if (thread_.joinable()) thread_.join();
}

void Sender::LookSoon() {
  is_changed_ = true;
  poster_.Wake();
}

absl::StatusOr<records::WebhookTrial> Sender::Try(const records::WebhookRecord& webhook,
                                                  const std::function<bool()>& is_cancelled) const {
  return PostOnce(options_.post, TestLetter(webhook, options_.post.clock->UtcNow()),
                  [&] { return stopping_ || is_cancelled(); });
}

void Sender::SendDue() {
  while (true) {
    BeginDue();
    if (poster_.count() == 0) return;
    Take(poster_.Wait(kIdle));
  }
}

void Sender::Loop() {
  while (!stopping_) {
    const int64_t told = board_->told();
    is_changed_ = false;
    const auto until = std::chrono::steady_clock::now() + BeginDue();
    while (!stopping_ && !is_changed_ && board_->told() == told) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - std::chrono::steady_clock::now());
      if (left.count() <= 0) break;
      const std::vector<Poster::Ended> ended = poster_.Wait(std::min(left, kLooksAgain));
      Take(ended);
      if (!ended.empty()) break;
    }
  }
}

std::chrono::milliseconds Sender::BeginDue() {
  std::chrono::milliseconds wait = kIdle;
  if (options_.is_mine && !options_.is_mine()) return kAsksWhose;
  const absl::StatusOr<std::vector<records::WebhookRecord>> webhooks = database_.ListWebhooks();
  if (!webhooks.ok()) return wait;
  const base::UtcTime now = options_.post.clock->UtcNow();
  std::erase_if(lines_, [&](const auto& line) {
    return !poster_.is_under_way(line.first.number()) &&
           std::none_of(webhooks->begin(), webhooks->end(), [&](const auto& one) { return one.id == line.first; });
  });
  for (const records::WebhookRecord& webhook : *webhooks) {
    if (stopping_ || !webhook.content.is_enabled || poster_.is_under_way(webhook.id.number())) continue;
    Line& line = lines_[webhook.id];
    if (line.etag != webhook.etag) {
      line = Line();
      line.etag = webhook.etag;
    }
    if (options_.post.clock->SteadyNow() < line.held_until) continue;
    const absl::StatusOr<std::optional<records::EventChange>> wanted = database_.WantedLetter(webhook.id);
    if (!wanted.ok()) {
      HoldUp(webhook, line, wanted.status());
      continue;
    }
    if (wanted->has_value()) {
      line.is_wanted_letter = true;
      line.sent = webhook;
      line.change = (*wanted)->id;
      poster_.Begin(webhook.id.number(), LetterOf(webhook, **wanted));
      continue;
    }
    if (webhook.next_try_at && *webhook.next_try_at > now) {
      const auto ahead = std::chrono::duration_cast<std::chrono::milliseconds>(*webhook.next_try_at - now);
      wait = std::min(wait, ahead + std::chrono::milliseconds(1));
      // A clock that was set back holds up nobody.
      if (ahead <= kLongestWait) continue;
    }
    if (const absl::Status begun = BeginNext(webhook, line).status(); !begun.ok()) HoldUp(webhook, line, begun);
  }
  return wait;
}

void Sender::HoldUp(const records::WebhookRecord& webhook, Line& line, const absl::Status& status) {
  line.held_until = options_.post.clock->SteadyNow() + kStoreWait;
  if (options_.tell) options_.tell(webhook, std::string(status.message()), false);
}

absl::StatusOr<bool> Sender::BeginNext(const records::WebhookRecord& webhook, Line& line) {
  while (!stopping_) {
    const auto is_for_it = [&](const records::EventChange& change) {
      return change.id > webhook.after_change && (!IsMail(webhook.content.url) || IsToldByMail(change.what));
    };
    while (!line.next.empty() && !is_for_it(line.next.front())) line.next.pop_front();
    if (!line.next.empty()) {
      line.is_wanted_letter = false;
      line.sent = webhook;
      line.change = line.next.front().id;
      poster_.Begin(webhook.id.number(), LetterOf(webhook, line.next.front()));
      return true;
    }
    const int64_t after = std::max(line.up_to, webhook.after_change);
    ASSIGN_OR_RETURN(storage::EventChangePage page,
                     database_.ReadEventChanges(after, std::nullopt, VisibleFor(webhook.content.scope)));
    line.up_to = page.up_to;
    line.next.assign(std::make_move_iterator(page.changes.begin()), std::make_move_iterator(page.changes.end()));
    if (!line.next.empty() || !page.is_last) continue;
    // Changes that are none of its business are not gone through again.
    if (line.up_to > webhook.after_change) {
      storage::WebhookStep step;
      step.webhook = webhook.id;
      step.etag = webhook.etag;
      step.from = webhook.after_change;
      step.to = line.up_to;
      RETURN_IF_ERROR(database_.StepWebhook(step).status());
    }
    return false;
  }
  return false;
}

void Sender::Take(const std::vector<Poster::Ended>& ended) {
  for (const Poster::Ended& one : ended) {
    Line& line = lines_[WebhookId(one.key)];
    const absl::Status stored = End(line, one.trial);
    if (!stored.ok()) line.held_until = options_.post.clock->SteadyNow() + kIdle;
  }
}

absl::Status Sender::End(Line& line, const records::WebhookTrial& trial) {
  const records::WebhookRecord& webhook = line.sent;
  const auto count = [this](const std::string& outcome) {
    if (options_.count) options_.count(outcome);
  };
  if (trial.error.empty()) count("TAKEN");
  if (line.is_wanted_letter) {
    if (!trial.error.empty()) count("DEAD");
    if (!trial.error.empty() && options_.tell) options_.tell(webhook, trial.error, true);
    return database_.EndWantedLetter(webhook.id, line.change, trial.error).status();
  }
  storage::WebhookStep step;
  step.webhook = webhook.id;
  step.etag = webhook.etag;
  step.from = webhook.after_change;
  step.to = line.change;
  step.error = trial.error;
  step.is_sent = trial.error.empty();
  if (!trial.error.empty()) {
    // It is read again before it is tried again.
    line.next.clear();
    line.up_to = 0;
    const int tries = webhook.tries + 1;
    const bool is_dead = tries >= (MayBeTakenLater(trial) ? kTries : kTriesOfRefused);
    if (is_dead) {
      step.dead = {line.change, tries, trial.error};
    } else {
      step.to = step.from;
      step.tries = tries;
      step.next_try_at =
          options_.post.clock->UtcNow() + WaitAfter(tries, options_.random ? options_.random() : Random());
    }
    count(is_dead ? "DEAD" : "FAILED");
    if (options_.tell) options_.tell(webhook, trial.error, is_dead);
  }
  return database_.StepWebhook(step).status();
}

}  // namespace axiscal::webhooks
