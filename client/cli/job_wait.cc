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

namespace {

// A job does not need the command that created it.
absl::Status Unwatched(const absl::Status& status, JobId id) {
  const std::string number = std::to_string(id.number());
  return base::Error(status.code(),
                     absl::StrCat(status.message(), "\njob ", number,
                                  " is stored and runs without this command, also after a restart of the server. See "
                                  "what becomes of it with: axiscal jobs watch ",
                                  number, " (--server HOST:PORT of a replica that is up)"),
                     base::GetErrorDetail(status).value_or(base::ErrorDetail{}));
}

}  // namespace

absl::StatusOr<JobRecord> FollowJob(const Context& context, client::Client& client, JobId id) {
  ProgressBar bar = context.Bar(absl::StrCat("job ", id.number()));
  absl::StatusOr<JobRecord> record = client.WatchJob(id, [&bar](const JobRecord& now) {
    bar.Show(now.progress.fraction, absl::StrCat(now.progress.stage, " ", now.progress.detail));
    return true;
  });
  if (absl::IsUnavailable(record.status()) || absl::IsDeadlineExceeded(record.status()))
    return Unwatched(record.status(), id);
  RETURN_IF_ERROR(record.status());
  RETURN_IF_ERROR(OutcomeOf(*record));
  return record;
}

}  // namespace axiscal::cli
