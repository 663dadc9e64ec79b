// What callers may take together of something that is short: bytes of memory, requests under way.
#ifndef AXISCAL_SERVER_HANDLERS_BUDGET_H_
#define AXISCAL_SERVER_HANDLERS_BUDGET_H_

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "core/base/mutex.h"
#include "core/base/status.h"

namespace axiscal::handlers {

// Shared fairly: nobody gets more than kMostOfOne times what is left for the others, so that whoever comes next finds
// room, however much one has taken (dynamic thresholds: Choudhury and Hahne, IEEE/ACM Transactions on Networking 6,
// 1998). Who is alone may hold kMostOfOne / (kMostOfOne + 1) of it. Safe from any thread.
class Budget {
 public:
  static constexpr int64_t kMostOfOne = 7;

  explicit Budget(int64_t most) : most_(most) {}
  // False where it would be more than is there for `who`; nothing is taken then. `count` >= 0.
  bool Take(const std::string& who, int64_t count);
  // What was taken before.
  void Give(const std::string& who, int64_t count);

 private:
  const int64_t most_;
  base::Mutex mutex_;
  int64_t taken_ AXISCAL_GUARDED_BY(mutex_) = 0;
  std::map<std::string, int64_t> of_one_ AXISCAL_GUARDED_BY(mutex_);  // of those who hold something
};

// What `who` has taken of the budget for as long as this lives.
class Share {
 public:
  Share(Budget& budget, std::string who) : budget_(budget), who_(std::move(who)) {}
  ~Share() { budget_.Give(who_, count_); }
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;

  // RESOURCE_EXHAUSTED QUEUE_FULL.
  absl::Status Take(int64_t count);
  // Until it holds that much; the same errors.
  absl::Status GrowTo(int64_t count) { return count <= count_ ? absl::OkStatus() : Take(count - count_); }

 private:
  Budget& budget_;
  const std::string who_;
  int64_t count_ = 0;
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_BUDGET_H_
