#include "server/jobs/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "core/base/error_detail.h"

namespace axiscal::jobs {
namespace {

TEST(WorkerPool, RunsEverythingItAccepted) {
  std::atomic<int> count = 0;
  {
    WorkerPool pool(3, 1000);
    for (int i = 0; i < 500; ++i) ASSERT_TRUE(pool.Submit([&] { ++count; }).ok());
  }
  EXPECT_EQ(count, 500);
}

TEST(WorkerPool, RefusesWhatDoesNotFit) {
  std::promise<void> release, began;
  std::shared_future<void> released = release.get_future().share();
  WorkerPool pool(1, 2);
  ASSERT_TRUE(pool.Submit([&] {
                    began.set_value();
                    released.wait();
                  })
                  .ok());
  began.get_future().wait();
  EXPECT_TRUE(pool.Submit([] {}).ok());
  EXPECT_TRUE(pool.Submit([] {}).ok());
  const absl::Status full = pool.Submit([] {});
  EXPECT_TRUE(absl::IsResourceExhausted(full)) << full;
  EXPECT_EQ(base::ErrorReason(full), "QUEUE_FULL");
  release.set_value();
  pool.Drain();
  EXPECT_EQ(base::ErrorReason(pool.Submit([] {})), "DRAINING");
}

}  // namespace
}  // namespace axiscal::jobs
