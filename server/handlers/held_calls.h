// Calls that last as long as their caller likes: it sends when it wants, reads when it wants, or waits for a job. Each
// holds a thread of the server, so there is a limit for each kind, and one whose caller is silent for too long is cut
// off. Time in which the server works is not silence. Replies are held as well, by callers that do not take them.
#ifndef AXISCAL_SERVER_HANDLERS_HELD_CALLS_H_
#define AXISCAL_SERVER_HANDLERS_HELD_CALLS_H_

#include <array>
#include <chrono>
#include <functional>
#include <list>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "core/base/clock.h"
#include "core/base/status.h"

namespace axiscal::handlers {

class HeldCall;

enum class HeldKind { kUpload, kDownload, kWatch, kRewrite, kReply };

struct HeldLimits {
  // Calls at a time: streams that bring sessions or programs, streams that take them away, calls that wait for a job,
  // programs that are rewritten while they come (each uses one core). More are refused.
  int max_uploads = 500;
  int max_downloads = 500;
  int max_watches = 1000;
  int max_rewrites = 1;
  // Of one principal, of each of these kinds.
  int max_of_one = 100;
  // Calls beside those at a time: none is refused, but the one whose caller is silent longest gives way.
  int max_replies = 500;
  // A caller that neither sends nor takes anything for so long is cut off.
  std::chrono::milliseconds silence = std::chrono::minutes(5);
  // Where a kind is full, the caller that is silent longest gives way to a new one, if for at least so long. Of
  // programs that are rewritten, where each holds a core, also one that was silent for so long in all and for nine
  // tenths of its time: a writer of a byte a second.
  std::chrono::milliseconds gives_way = std::chrono::seconds(10);
};

// All of a server. Safe from any thread.
class HeldCalls {
 public:
  explicit HeldCalls(base::Clock* clock = &base::SystemClock()) : clock_(*clock) {}
  // No call may be held any more.
  ~HeldCalls();
  HeldCalls(const HeldCalls&) = delete;
  HeldCalls& operator=(const HeldCalls&) = delete;

  // Calls of that kind now.
  int count(HeldKind kind) const;

 private:
  friend class HeldCall;
  void CutOffSilent();
  // Cuts off the one of that kind, and of that principal unless `who` is empty, that gives way (HeldLimits::gives_way);
  // whether there was one.
  bool MakeRoom(HeldKind kind, const std::string& who, std::chrono::milliseconds at_least) AXISCAL_REQUIRES(mutex_);
  void Count(const HeldCall& call, int more) AXISCAL_REQUIRES(mutex_);

  base::Clock& clock_;
  mutable base::Mutex mutex_;
  base::CondVar stopped_;
  bool stopping_ AXISCAL_GUARDED_BY(mutex_) = false;
  std::chrono::milliseconds silence_ AXISCAL_GUARDED_BY(mutex_){0};
  std::array<int, 5> counts_ AXISCAL_GUARDED_BY(mutex_) = {};
  std::map<std::pair<HeldKind, std::string>, int> of_one_ AXISCAL_GUARDED_BY(mutex_);  // by principal
  std::list<HeldCall*> silent_ AXISCAL_GUARDED_BY(mutex_);  // who is silent longest comes first
  std::thread thread_;                                      // from the first call on
};

// One call while it runs. Its handler asks status() before it begins and when Await() gave false.
class HeldCall {
 public:
  // `cut_off` ends the call from another thread: what it waits for then returns false. `who`: the principal, for
  // max_of_one; empty: nobody in particular.
  HeldCall(HeldCalls& calls, const HeldLimits& limits, HeldKind kind, std::function<void()> cut_off,
           std::string who = "");
  ~HeldCall();
  HeldCall(const HeldCall&) = delete;
  HeldCall& operator=(const HeldCall&) = delete;

  // RESOURCE_EXHAUSTED QUEUE_FULL where too many of its kind were there, DEADLINE_EXCEEDED DEADLINE once it was cut
  // off, else OK.
  absl::Status status() const;
  // What `wait` returns, which blocks until the caller does something. One at a time.
  template <typename Wait>
  auto Await(const Wait& wait) {
    BeginSilence();
    auto result = wait();
    EndSilence();
    return result;
  }
  // Await() in two calls, where what waits is not ours. Ending what did not begin is harmless.
  void BeginSilence();
  void EndSilence();

 private:
  friend class HeldCalls;
  void CutOff(const std::string& why);  // the mutex of calls_ is held, as for GivesWay()
  bool GivesWay(base::SteadyTime now, std::chrono::milliseconds at_least) const;

  HeldCalls& calls_;
  const HeldKind kind_;
  const std::string who_;
  const std::function<void()> cut_off_;
  // Guarded by the mutex of calls_.
  absl::Status status_;
  bool is_counted_ = false;
  bool is_silent_ = false;
  base::SteadyTime silent_since_{};
  const base::SteadyTime began_at_;
  base::SteadyTime::duration was_silent_{};  // before it was silent last
  std::list<HeldCall*>::iterator place_{};
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_HELD_CALLS_H_
