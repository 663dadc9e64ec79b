#include "core/base/copy_on_write.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace axiscal::base
