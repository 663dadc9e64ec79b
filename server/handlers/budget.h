// Memory that callers' files may take at a time.
#ifndef AXISCAL_SERVER_HANDLERS_BUDGET_H_
#define AXISCAL_SERVER_HANDLERS_BUDGET_H_

#include <atomic>
#include <cstdint>

#include "core/base/error_detail.h"

namespace axiscal::handlers {

// Bytes. Safe from any thread.
class Budget {
 public:
  explicit Budget(int64_t bytes) : left_(bytes) {}
  bool Take(int64_t bytes) {
    if (left_.fetch_sub(bytes) >= bytes) return true;
    left_ += bytes;
    return false;
  }
  void Give(int64_t bytes) { left_ += bytes; }

 private:
  std::atomic<int64_t> left_;
};

// What is taken of the budget for as long as this lives.
class Share {
 public:
  explicit Share(Budget& budget) : budget_(budget) {}
  ~Share() { budget_.Give(bytes_); }
  Share(const Share&) = delete;
  Share& operator=(const Share&) = delete;

  // RESOURCE_EXHAUSTED QUEUE_FULL.
  absl::Status Take(int64_t bytes) {
    if (!budget_.Take(bytes))
      return base::Error(absl::StatusCode::kResourceExhausted, "too many files are under way", {"QUEUE_FULL", {}});
    bytes_ += bytes;
    return absl::OkStatus();
  }

 private:
  Budget& budget_;
  int64_t bytes_ = 0;
};

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_BUDGET_H_
