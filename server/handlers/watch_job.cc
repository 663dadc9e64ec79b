#include "server/handlers/watch_job.h"

#include "core/base/error_detail.h"
#include "proto/convert/job.h"

namespace axiscal::handlers {
namespace {

// How often a silent watch asks whether its caller is still there.
constexpr std::chrono::milliseconds kWatchLooksAgainAfter(200);

}  // namespace

absl::Status WatchJob(Core& core, const Call& call, const v1::WatchJobRequest& request,
                      const std::function<bool(const v1::WatchJobResponse&)>& send) {
  ASSIGN_OR_RETURN(const std::shared_ptr<jobs::JobWatch> watch, core.jobs.Watch(JobId(request.job_id())));
  bool has_ended = false;
  while (!call.is_cancelled()) {
    const std::optional<records::JobRecord> record = watch->Next(kWatchLooksAgainAfter);
    if (record) {
      has_ended = records::IsTerminal(record->state);
      v1::WatchJobResponse response;
      *response.mutable_job() = convert::ToProto(*record);
      if (!send(response)) return absl::CancelledError("the caller has left");
    }
    if (has_ended) return absl::OkStatus();
    if (watch->done()) return base::Error(absl::StatusCode::kUnavailable, "the server is stopping", {"DRAINING", {}});
  }
  return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
}

}  // namespace axiscal::handlers
