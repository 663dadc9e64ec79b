#include "server/handlers/held_calls.h"

#include <algorithm>
#include <utility>

#include "core/base/error_detail.h"

namespace axiscal::handlers {
namespace {

int MostOf(const HeldLimits& limits, HeldKind kind) {
  switch (kind) {
    case HeldKind::kUpload:
      return limits.max_uploads;
    case HeldKind::kDownload:
      return limits.max_downloads;
    case HeldKind::kWatch:
      return limits.max_watches;
    case HeldKind::kRewrite:
      return limits.max_rewrites;
    case HeldKind::kReply:
      return limits.max_replies;
  }
  return 0;
}

const char* WordsOf(HeldKind kind) {
  switch (kind) {
    case HeldKind::kUpload:
      return "uploads";
    case HeldKind::kDownload:
      return "downloads";
    case HeldKind::kWatch:
      return "calls that wait for jobs";
    case HeldKind::kRewrite:
      return "programs are rewritten";
    case HeldKind::kReply:
      return "replies";
  }
  return "calls";
}

}  // namespace

HeldCalls::~HeldCalls() {
  {
    const base::MutexLock lock(mutex_);
    stopping_ = true;
  }
  stopped_.NotifyAll();
  if (thread_.joinable()) thread_.join();
}

int HeldCalls::count(HeldKind kind) const {
  const base::MutexLock lock(mutex_);
  return counts_[static_cast<size_t>(kind)];
}

// All callers may be silent equally long, so none that falls silent later is over before the first; and none is over
// earlier than that time from now. Nobody needs to wake this thread.
void HeldCalls::CutOffSilent() {
  const base::MutexLock lock(mutex_);
  while (!stopping_) {
    const base::SteadyTime now = clock_.SteadyNow();
    while (!silent_.empty() && now - silent_.front()->silent_since_ >= silence_) {
      silent_.front()->CutOff("the caller was silent for too long");
    }
    const base::SteadyTime next = (silent_.empty() ? now : silent_.front()->silent_since_) + silence_;
    clock_.WaitUntil(stopped_, mutex_, next);
  }
}

void HeldCalls::Count(const HeldCall& call, int more) {
  counts_[static_cast<size_t>(call.kind_)] += more;
  if (call.who_.empty()) return;
  int& of_one = of_one_[{call.kind_, call.who_}];
  of_one += more;
  if (of_one == 0) of_one_.erase({call.kind_, call.who_});
}

bool HeldCalls::MakeRoom(HeldKind kind, const std::string& who, std::chrono::milliseconds at_least) {
  const base::SteadyTime now = clock_.SteadyNow();
  const auto found = std::find_if(silent_.begin(), silent_.end(), [&](const HeldCall* call) {
    return call->kind_ == kind && (who.empty() || call->who_ == who) && call->GivesWay(now, at_least);
  });
  if (found == silent_.end()) return false;
  (*found)->CutOff("the caller was silent while others waited");
  return true;
}

HeldCall::HeldCall(HeldCalls& calls, const HeldLimits& limits, HeldKind kind, std::function<void()> cut_off,
                   std::string who)
    : calls_(calls),
      kind_(kind),
      who_(std::move(who)),
      cut_off_(std::move(cut_off)),
      began_at_(calls.clock_.SteadyNow()) {
  const base::MutexLock lock(calls_.mutex_);
  if (!who_.empty()) {
    const auto found = calls_.of_one_.find({kind_, who_});
    if (found != calls_.of_one_.end() && found->second >= limits.max_of_one &&
        !calls_.MakeRoom(kind, who_, limits.gives_way)) {
      status_ =
          base::Error(absl::StatusCode::kResourceExhausted,
                      absl::StrCat("more than ", limits.max_of_one, " ", WordsOf(kind), " of ", who_, " at a time"),
                      {"QUEUE_FULL", {{"principal", who_}}});
      return;
    }
  }
  const int count = calls_.counts_[static_cast<size_t>(kind)];
  const int most = MostOf(limits, kind);
  if (count >= most && !calls_.MakeRoom(kind, "", limits.gives_way) && kind != HeldKind::kReply) {
    status_ = base::Error(absl::StatusCode::kResourceExhausted,
                          absl::StrCat("more than ", most, " ", WordsOf(kind), " at a time"), {"QUEUE_FULL", {}});
    return;
  }
  calls_.Count(*this, 1);
  is_counted_ = true;
  calls_.silence_ = limits.silence;
  if (!calls_.thread_.joinable()) calls_.thread_ = std::thread([&calls] { calls.CutOffSilent(); });
}

HeldCall::~HeldCall() {
  const base::MutexLock lock(calls_.mutex_);
  if (is_silent_) calls_.silent_.erase(place_);
  if (is_counted_) calls_.Count(*this, -1);
}

absl::Status HeldCall::status() const {
  const base::MutexLock lock(calls_.mutex_);
  return status_;
}

void HeldCall::BeginSilence() {
  const base::MutexLock lock(calls_.mutex_);
  silent_since_ = calls_.clock_.SteadyNow();
  place_ = calls_.silent_.insert(calls_.silent_.end(), this);
  is_silent_ = true;
}

// Also waits for who cuts it off just now: what `cut_off_` needs is there until then.
void HeldCall::EndSilence() {
  const base::MutexLock lock(calls_.mutex_);
  if (!is_silent_) return;
  calls_.silent_.erase(place_);
  is_silent_ = false;
  was_silent_ += calls_.clock_.SteadyNow() - silent_since_;
}

bool HeldCall::GivesWay(base::SteadyTime now, std::chrono::milliseconds at_least) const {
  const base::SteadyTime::duration lately = now - silent_since_, in_all = was_silent_ + lately;
  return lately >= at_least ||
         (kind_ == HeldKind::kRewrite && in_all >= at_least && 10 * in_all >= 9 * (now - began_at_));
}

// Its place is free at once, though its handler has yet to return.
void HeldCall::CutOff(const std::string& why) {
  calls_.silent_.erase(place_);
  is_silent_ = false;
  if (is_counted_) calls_.Count(*this, -1);
  is_counted_ = false;
  status_ = base::Error(absl::StatusCode::kDeadlineExceeded, why, {"DEADLINE", {}});
  cut_off_();
}

}  // namespace axiscal::handlers
