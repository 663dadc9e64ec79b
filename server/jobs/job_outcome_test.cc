#include "server/jobs/job_outcome.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"

namespace axiscal::jobs {
namespace {

using std::chrono::seconds;
using storage::JobEnd;

TEST(JobOutcome, WaitsLongerBeforeEachRetry) {
  const absl::Status status = absl::UnavailableError("disk busy");
  EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 1, seconds(5), StorePlace::kHere).end, JobEnd::kRetry);
  EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 1, seconds(5), StorePlace::kHere).retry_after, seconds(5));
  EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 3, seconds(5), StorePlace::kHere).retry_after, seconds(80));
  EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 1000, seconds(5), StorePlace::kHere).retry_after, seconds(600));
}

TEST(JobOutcome, DoesNotRepeatWhatWouldFailAgain) {
  const absl::Status status = base::Error(absl::StatusCode::kFailedPrecondition, "EX0B - EX0C", {"RANK_DEFICIENT", {}});
  const JobOutcome outcome = DecideOutcome(status, StopReason::kNone, 1, seconds(5), StorePlace::kHere);
  EXPECT_EQ(outcome.end, JobEnd::kFailed);
  EXPECT_EQ(outcome.error.reason, "RANK_DEFICIENT");
  EXPECT_EQ(outcome.error.message, "EX0B - EX0C");
}

// A server of a database that goes away says nothing against the job; a file's trouble may be the job's doing.
TEST(JobOutcome, AStoreThatWentAwayDoesNotCount) {
  for (const std::string reason : {"STORE_DOWN", "STORE_BUSY"}) {
    const absl::Status status = base::Error(absl::StatusCode::kUnavailable, "no connection", {reason, {}});
    const JobOutcome outcome = DecideOutcome(status, StopReason::kNone, 3, seconds(5), StorePlace::kElsewhere);
    EXPECT_EQ(outcome.end, JobEnd::kParked);
    EXPECT_EQ(outcome.retry_after, seconds(5));
    EXPECT_EQ(outcome.error.reason, "STORE_AWAY");
    EXPECT_EQ(outcome.error.message, "put back: no connection");
    EXPECT_TRUE(IsNotCounted(outcome.error));
    EXPECT_EQ(DecideOutcome(status, StopReason::kNone, 3, seconds(5), StorePlace::kHere).end, JobEnd::kRetry);
  }
  const absl::Status other = absl::UnavailableError("no answer");
  EXPECT_EQ(DecideOutcome(other, StopReason::kNone, 1, seconds(5), StorePlace::kElsewhere).end, JobEnd::kRetry);
}

TEST(JobOutcome, TheReasonToStopCountsMoreThanTheErrorItCaused) {
  const absl::Status status = absl::InternalError("solver was interrupted");
  EXPECT_EQ(DecideOutcome(status, StopReason::kCancelled, 1, seconds(5), StorePlace::kHere).end, JobEnd::kCancelled);
  EXPECT_EQ(DecideOutcome(status, StopReason::kDraining, 1, seconds(5), StorePlace::kHere).end, JobEnd::kParked);
  const JobOutcome late = DecideOutcome(status, StopReason::kDeadline, 1, seconds(5), StorePlace::kHere);
  EXPECT_EQ(late.end, JobEnd::kFailed);
  EXPECT_EQ(late.error.code, absl::StatusCode::kDeadlineExceeded);
}

}  // namespace
}  // namespace axiscal::jobs
