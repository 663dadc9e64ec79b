#include "core/base/status.h"

#include <gtest/gtest.h>

namespace axiscal::base {
namespace {

absl::StatusOr<int> Half(int number) {
  if (number % 2 != 0) return absl::InvalidArgumentError(absl::StrCat(number, " is odd"));
  return number / 2;
}

absl::StatusOr<int> Quarter(int number) {
  ASSIGN_OR_RETURN(const int half, Half(number));
  RETURN_IF_ERROR(Half(half).status());
  return half / 2;
}

TEST(Status, MacrosPassValuesAndReturnTheFirstError) {
  ASSERT_TRUE(Quarter(12).ok());
  EXPECT_EQ(*Quarter(12), 3);
  EXPECT_EQ(Quarter(7).status().message(), "7 is odd");
  EXPECT_EQ(Quarter(6).status().message(), "3 is odd");
}

TEST(Status, WithinPutsThePlaceInFrontAndKeepsTheCode) {
  const absl::Status status = Within("line 3", absl::OutOfRangeError("column 2"));
  EXPECT_EQ(status.code(), absl::StatusCode::kOutOfRange);
  EXPECT_EQ(status.message(), "line 3: column 2");
  EXPECT_TRUE(Within("line 3", absl::OkStatus()).ok());
}

}  // namespace
}  // namespace axiscal::base
