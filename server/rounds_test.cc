#include "server/rounds.h"

#include <gtest/gtest.h>

#include <atomic>

namespace axiscal::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

void WaitFor(const std::atomic<int>& count, int least) {
  while (count < least) std::this_thread::sleep_for(milliseconds(1));
}

TEST(Rounds, GoOnUntilTheyAreStopped) {
  std::atomic<int> count = 0;
  Rounds rounds;
  rounds.Start(Rounds::Begin::kAfterAPause, milliseconds(1), [&] { ++count; });
  WaitFor(count, 3);
  rounds.Stop();
  const int then = count;
  std::this_thread::sleep_for(milliseconds(20));
  EXPECT_EQ(count, then);
  rounds.Stop();
}

TEST(Rounds, TheFirstIsAtOnceOrAfterAPause) {
  std::atomic<int> at_once = 0, later = 0;
  Rounds first, second;
  second.Start(Rounds::Begin::kAfterAPause, hours(1), [&] { ++later; });
  first.Start(Rounds::Begin::kAtOnce, hours(1), [&] { ++at_once; });
  WaitFor(at_once, 1);
  // Neither waits for its hour.
  first.Stop();
  second.Stop();
  EXPECT_EQ(at_once, 1);
  EXPECT_EQ(later, 0);
}

// A store may take minutes to remove old readings; floods are looked for meanwhile.
TEST(Rounds, ALongOneHoldsUpNoOthers) {
  std::atomic<int> others = 0;
  std::atomic<bool> is_let_go = false;
  std::atomic<int> begun = 0;
  Rounds slow, quick;
  slow.Start(Rounds::Begin::kAtOnce, hours(1), [&] {
    ++begun;
    while (!is_let_go) std::this_thread::sleep_for(milliseconds(1));
  });
  WaitFor(begun, 1);
  quick.Start(Rounds::Begin::kAtOnce, milliseconds(1), [&] { ++others; });
  WaitFor(others, 3);
  quick.Stop();
  is_let_go = true;
}

TEST(Rounds, NothingStartedNothingStops) {
  Rounds rounds;
  rounds.Stop();
}

}  // namespace
}  // namespace axiscal::server
