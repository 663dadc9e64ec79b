#include "core/base/copy_on_write.h"

#include <gtest/gtest.h>

#include <thread>
#include <utility>
#include <vector>

namespace axiscal::base {
namespace {

TEST(CopyOnWrite, CopiesShareUntilOneIsChanged) {
  CopyOnWrite<std::vector<int>> one(std::vector<int>{1, 2});
  CopyOnWrite<std::vector<int>> other = one;
  EXPECT_EQ(&*one, &*other);
  other.Own().push_back(3);
  EXPECT_EQ(*one, (std::vector<int>{1, 2}));
  EXPECT_EQ(*other, (std::vector<int>{1, 2, 3}));
  const int* const data = one->data();
  one.Own()[0] = 7;
  EXPECT_EQ(one->data(), data) << "copied although nothing shares it";
  EXPECT_EQ(one->front(), 7);
}

TEST(CopyOnWrite, IsEmptyUntilItIsChanged) {
  CopyOnWrite<std::vector<int>> one;
  EXPECT_TRUE(one->empty());
  one.Own().push_back(1);
  EXPECT_TRUE(CopyOnWrite<std::vector<int>>()->empty());
  EXPECT_EQ(one->size(), 1u);
}

TEST(CopyOnWrite, IsMovedAndAssignedAsAPlainValue) {
  CopyOnWrite<std::vector<int>> one(std::vector<int>{1, 2});
  CopyOnWrite<std::vector<int>> other = std::move(one);
  one = other;
  one = *&one;
  EXPECT_EQ(&*one, &*other);
  other = {};
  EXPECT_TRUE(other->empty());
  EXPECT_EQ(*one, (std::vector<int>{1, 2}));
}

// For ThreadSanitizer too: who changes the value after the last other gave it up does so after that one's reads.
TEST(CopyOnWrite, ThreadsHaveCopiesOfTheirOwn) {
  for (int round = 0; round < 200; ++round) {
    CopyOnWrite<std::vector<int>> one(std::vector<int>(100, 1));
    int sum = 0;
    std::thread reader([&sum, copy = one]() mutable {
      for (const int value : *copy) sum += value;
      copy = {};
    });
    one.Own()[0] = round;
    reader.join();
    EXPECT_EQ(sum, 100);
    EXPECT_EQ(one->front(), round);
  }
}

}  // namespace
}  // namespace axiscal::base
