#include "server/handlers/budget.h"

#include "core/base/error_detail.h"

namespace axiscal::handlers {

bool Budget::Take(const std::string& who, int64_t count) {
  const base::MutexLock lock(mutex_);
  const auto found = of_one_.find(who);
  const int64_t held = found == of_one_.end() ? 0 : found->second;
  const int64_t left = most_ - taken_;
  if (count > left || held + count > kMostOfOne * (left - count)) return false;
  if (count == 0) return true;
  taken_ += count;
  of_one_[who] = held + count;
  return true;
}

void Budget::Give(const std::string& who, int64_t count) {
  if (count == 0) return;
  const base::MutexLock lock(mutex_);
  taken_ -= count;
  const auto found = of_one_.find(who);
  found->second -= count;
  if (found->second == 0) of_one_.erase(found);
}

absl::Status Share::Take(int64_t count) {
  if (!budget_.Take(who_, count)) {
    return base::Error(absl::StatusCode::kResourceExhausted, "too much is under way, of all callers or of this one",
                       {"QUEUE_FULL", {}});
  }
  count_ += count;
  return absl::OkStatus();
}

}  // namespace axiscal::handlers
