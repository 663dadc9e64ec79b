#include "server/jobs/job_outcome.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"

namespace axiscal::jobs {
namespace {

using std::chrono::seconds;
using storage::JobEnd;

TEST(JobOutcome, WaitsLongerBeforeEachRetry) {
  const absl::Status status = absl::UnavailableError("disk busy");
  EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 1, seconds(5)).end, JobEnd::kRetry);
  EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 1, seconds(5)).retry_after, seconds(5));
  EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 3, seconds(5)).retry_after, seconds(80));
}

TEST(JobOutcome, DoesNotRepeatWhatWouldFailAgain) {
  const absl::Status status = base::Error(absl::StatusCode::kFailedPrecondition, "EX0B - EX0C", {"RANK_DEFICIENT", {}});
  const JobOutcome outcome = DecideOutcome(status, StopReason::kNone, 1, seconds(5));
  EXPECT_EQ(outcome.end, JobEnd::kFailed);
  EXPECT_EQ(outcome.error.reason, "RANK_DEFICIENT");
  EXPECT_EQ(outcome.error.message, "EX0B - EX0C");
}

TEST(JobOutcome, TheReasonToStopCountsMoreThanTheErrorItCaused) {
  const absl::Status status = absl::InternalError("solver was interrupted");
  EXPECT_EQ(DecideOutcome(status, StopReason::kCancelled, 1, seconds(5)).end, JobEnd::kCancelled);
  EXPECT_EQ(DecideOutcome(status, StopReason::kDraining, 1, seconds(5)).end, JobEnd::kParked);
  const JobOutcome late = DecideOutcome(status, StopReason::kDeadline, 1, seconds(5));
  EXPECT_EQ(late.end, JobEnd::kFailed);
  EXPECT_EQ(late.error.code, absl::StatusCode::kDeadlineExceeded);
}

}  // namespace
}  // namespace axiscal::jobs
