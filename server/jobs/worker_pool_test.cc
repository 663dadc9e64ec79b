#include "server/jobs/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

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

TEST(WorkerPool, IdleThreadsHelpATaskAndEveryIndexRunsOnce) {
  for (const int workers : {1, 4}) {
    WorkerPool pool(workers, 8);
    std::vector<std::atomic<int>> calls(5000);
    std::mutex mutex;
    std::set<std::thread::id> threads;
    ASSERT_TRUE(pool.Submit([&] {
                      pool.ForEach(static_cast<int>(calls.size()), [&](int index) {
                        ++calls[index];
                        const std::lock_guard<std::mutex> lock(mutex);
                        threads.insert(std::this_thread::get_id());
                      });
                      for (const std::atomic<int>& count : calls) EXPECT_EQ(count, 1);  // all have returned
                    })
                    .ok());
    pool.Drain();
    EXPECT_LE(threads.size(), static_cast<size_t>(workers));
  }
}

// A body that waits for a second thread: one comes when it is idle. A pool that drains sends nobody, so it drains
// after.
TEST(WorkerPool, HelpComesFromAnIdleThread) {
  WorkerPool pool(2, 8);
  std::atomic<int> inside = 0;
  std::promise<void> met;
  ASSERT_TRUE(pool.Submit([&] {
                    pool.ForEach(2, [&](int) {
                      ++inside;
                      while (inside < 2) std::this_thread::yield();
                    });
                    met.set_value();
                  })
                  .ok());
  met.get_future().wait();
  pool.Drain();
  EXPECT_EQ(inside, 2);
}

TEST(WorkerPool, ForEachAloneAndOfNothing) {
  WorkerPool pool(1, 1);
  int sum = 0;
  pool.ForEach(0, [&](int) { ++sum; });
  EXPECT_EQ(sum, 0);
  pool.Drain();  // draining threads help nobody: the caller does it all
  pool.ForEach(3, [&](int index) { sum += index; });
  EXPECT_EQ(sum, 3);
}

}  // namespace
}  // namespace axiscal::jobs
