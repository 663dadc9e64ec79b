#include "server/jobs/job_outcome.h"

#include <algorithm>

#include "core/base/error_detail.h"

namespace axiscal::jobs {

using storage::JobEnd;

namespace {

bool IsOfStore(const absl::Status& status) {
  const std::string reason = base::ErrorReason(status);
  return absl::IsUnavailable(status) && (reason == "STORE_DOWN" || reason == "STORE_BUSY");
}

}  // namespace

bool IsWorthRetrying(absl::StatusCode code) {
  return code == absl::StatusCode::kUnavailable || code == absl::StatusCode::kAborted ||
         code == absl::StatusCode::kResourceExhausted;
}

bool IsNotCounted(const records::JobError& error) {
  return error.reason == "DRAINING" || error.reason == "STORE_AWAY" || error.reason == "MACHINE_RESTARTED";
}

JobOutcome DecideOutcome(const absl::Status& status, StopReason reason, int attempt,
                         std::chrono::milliseconds first_backoff, StorePlace store) {
  if (reason == StopReason::kCancelled) {
    return {JobEnd::kCancelled, {absl::StatusCode::kCancelled, "CANCELLED", "cancelled as asked"}, {}};
  }
  if (reason == StopReason::kDraining) {
    return {JobEnd::kParked, {absl::StatusCode::kUnavailable, "DRAINING", "put back: the server is shutting down"}, {}};
  }
  if (reason == StopReason::kDeadline) {
    return {
        JobEnd::kFailed, {absl::StatusCode::kDeadlineExceeded, "DEADLINE", "ran longer than jobs of its kind may"}, {}};
  }
  if (reason == StopReason::kTooLate) {
    return {JobEnd::kFailed,
            {absl::StatusCode::kDeadlineExceeded, "JOB_TOO_LATE", "had not ended by its deadline, and was stopped"},
            {}};
  }
  if (store == StorePlace::kElsewhere && IsOfStore(status)) {
    return {JobEnd::kParked,
            {absl::StatusCode::kUnavailable, "STORE_AWAY", absl::StrCat("put back: ", status.message())},
            first_backoff};
  }
  const records::JobError error = {status.code(), base::ErrorReason(status), std::string(status.message())};
  if (!IsWorthRetrying(status.code())) return {JobEnd::kFailed, error, {}};
  constexpr std::chrono::milliseconds kMostBackoff = std::chrono::minutes(10);
  std::chrono::milliseconds wait = first_backoff;
  for (int i = 1; i < attempt && wait < kMostBackoff; ++i) wait *= 4;
  return {JobEnd::kRetry, error, std::min(wait, kMostBackoff)};
}

}  // namespace axiscal::jobs
