#include "server/handlers/call_rates.h"

#include <algorithm>

#include "core/base/error_detail.h"

namespace axiscal::handlers {
namespace {

// Full again after so long without a call.
constexpr double kFullSeconds = 2;

}  // namespace

double CallRates::LeftNow(const Left& left, base::SteadyTime now) const {
  const double seconds = std::chrono::duration<double>(now - left.at).count();
  return std::min(left.calls + seconds * per_second_, kFullSeconds * per_second_);
}

void CallRates::ForgetQuiet(base::SteadyTime now) {
  if (now - forgot_at_ < std::chrono::seconds(1)) return;
  forgot_at_ = now;
  std::erase_if(left_, [&](const auto& entry) { return LeftNow(entry.second, now) >= kFullSeconds * per_second_; });
}

absl::Status CallRates::Take(const std::string& who) {
  const base::MutexLock lock(mutex_);
  const base::SteadyTime now = clock_.SteadyNow();
  ForgetQuiet(now);
  Left& left = left_.try_emplace(who, Left{kFullSeconds * per_second_, now}).first->second;
  left = {LeftNow(left, now), now};
  if (left.calls < 1) {
    return base::Error(absl::StatusCode::kResourceExhausted,
                       absl::StrCat(who, " calls more often than ", per_second_, " times a second"),
                       {"RATE_EXCEEDED", {{"calls_per_second", std::to_string(per_second_)}}});
  }
  --left.calls;
  return absl::OkStatus();
}

size_t CallRates::remembered() const {
  const base::MutexLock lock(mutex_);
  return left_.size();
}

}  // namespace axiscal::handlers
