#include "server/handlers/wait_job.h"

#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "proto/convert/field.h"
#include "proto/convert/job.h"

namespace axiscal::handlers {
namespace {

// How often a silent watch asks whether its caller is still there.
constexpr std::chrono::milliseconds kWaitLooksAgainAfter(100);
constexpr std::chrono::milliseconds kLongest = std::chrono::hours(24);

}  // namespace

absl::StatusOr<v1::WaitJobResponse> WaitJob(Core& core, const Call& call, const v1::WaitJobRequest& request) {
  RETURN_IF_ERROR(convert::RequireNotNegative("timeout_ms", request.timeout_ms()));
  ASSIGN_OR_RETURN(const std::shared_ptr<jobs::JobWatch> watch, core.jobs.Watch(JobId(request.job_id())));
  const base::SteadyTime start = base::SystemClock().SteadyNow();
  const std::chrono::milliseconds timeout =
      request.timeout_ms() == 0 ? kLongest : std::min(kLongest, std::chrono::milliseconds(request.timeout_ms()));
  std::optional<records::JobRecord> job;
  while (!call.is_cancelled()) {
    std::optional<records::JobRecord> next = watch->Next(kWaitLooksAgainAfter);
    if (next) job = std::move(next);
    const bool is_over = base::SystemClock().SteadyNow() - start >= timeout;
    if (job && (records::IsTerminal(job->state) || is_over)) {
      v1::WaitJobResponse response;
      *response.mutable_job() = convert::ToProto(*job);
      return response;
    }
    if (watch->done()) return base::Error(absl::StatusCode::kUnavailable, "the server is stopping", {"DRAINING", {}});
  }
  return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
}

}  // namespace axiscal::handlers
