#include "client/cli/job_wait.h"

#include "core/base/error_detail.h"

namespace axiscal::cli {

using records::JobRecord;
using records::JobState;

absl::Status OutcomeOf(const JobRecord& record) {
  const std::string job = absl::StrCat("job ", record.id.number(), ": ");
  switch (record.state) {
    case JobState::kSucceeded:
      return absl::OkStatus();
    case JobState::kCancelled:
      return absl::CancelledError(job + "was cancelled");
    case JobState::kFailed:
    case JobState::kDead: {
      if (!record.error) return absl::InternalError(job + "ended without a result");
      const auto code = record.error->code == absl::StatusCode::kOk ? absl::StatusCode::kUnknown : record.error->code;
      return base::Error(code, job + record.error->message, {record.error->reason, {}});
    }
    case JobState::kQueued:
    case JobState::kRunning:
      break;
  }
  return absl::DeadlineExceededError(job + "has not ended yet; follow it with: axiscal jobs watch " +
                                     std::to_string(record.id.number()));
}

absl::StatusOr<JobRecord> FollowJob(const Context& context, client::Client& client, JobId id) {
  ProgressBar bar = context.Bar(absl::StrCat("job ", id.number()));
  ASSIGN_OR_RETURN(JobRecord record, client.WatchJob(id, [&bar](const JobRecord& now) {
    bar.Show(now.progress.fraction, absl::StrCat(now.progress.stage, " ", now.progress.detail));
    return true;
  }));
  RETURN_IF_ERROR(OutcomeOf(record));
  return record;
}

}  // namespace axiscal::cli
