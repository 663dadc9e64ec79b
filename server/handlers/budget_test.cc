#include "server/handlers/budget.h"

#include <gtest/gtest.h>

#include "core/base/error_detail.h"

namespace axiscal::handlers {
namespace {

// Takes one by one until there is no more for `who`.
int TakeAll(Budget& budget, const std::string& who) {
  int count = 0;
  while (budget.Take(who, 1)) ++count;
  return count;
}

TEST(BudgetTest, WhoIsAloneLeavesOnePartInEight) {
  Budget budget(800);
  EXPECT_FALSE(budget.Take("ann", 701));
  EXPECT_TRUE(budget.Take("ann", 700));
  EXPECT_FALSE(budget.Take("ann", 1));
  budget.Give("ann", 300);
  EXPECT_EQ(TakeAll(budget, "ann"), 300);
}

TEST(BudgetTest, WhoComesNextFindsRoomHoweverMuchOthersHold) {
  Budget budget(10'000);
  int taken = 0;
  for (const char* const name : {"ann", "bob", "eve", "tom", "petra"}) {
    const int count = TakeAll(budget, name);
    EXPECT_GT(count, 0) << name;
    taken += count;
  }
  EXPECT_LE(taken, 10'000);
  // What one gives back is there for the others, first for who holds less.
  budget.Give("ann", 8'750);
  EXPECT_GT(TakeAll(budget, "petra"), 3'000);
}

TEST(BudgetTest, AShareGivesBackWhatItHolds) {
  Budget budget(800);
  {
    Share share(budget, "ann");
    EXPECT_TRUE(share.Take(0).ok());
    EXPECT_TRUE(share.GrowTo(500).ok());
    EXPECT_TRUE(share.GrowTo(400).ok());
    EXPECT_TRUE(share.Take(200).ok());
    const absl::Status more = share.Take(1);
    EXPECT_TRUE(absl::IsResourceExhausted(more)) << more;
    EXPECT_EQ(base::ErrorReason(more), "QUEUE_FULL");
    Share of_bob(budget, "bob");
    EXPECT_TRUE(of_bob.Take(80).ok());
  }
  EXPECT_TRUE(budget.Take("bob", 700));
}

TEST(BudgetTest, CountsThatHaveNoEndAreRefused) {
  Budget budget(800);
  EXPECT_FALSE(budget.Take("ann", INT64_MAX));
  EXPECT_TRUE(budget.Take("ann", 700));
}

}  // namespace
}  // namespace axiscal::handlers
