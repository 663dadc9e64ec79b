#include "core/base/error_detail.h"

#include <gtest/gtest.h>

namespace axiscal::base {
namespace {

TEST(ErrorDetail, TravelsWithTheStatusAlsoThroughWithin) {
  const ErrorDetail detail = {"SEQ_GAP", {{"next_seq", "12"}, {"session", ""}}};
  const absl::Status status = Error(absl::StatusCode::kOutOfRange, "seq = 14, expected 12", detail);
  EXPECT_EQ(GetErrorDetail(status), detail);
  EXPECT_EQ(GetErrorDetail(Within("session 3", status)), detail);
  EXPECT_EQ(ErrorReason(status), "SEQ_GAP");
}

TEST(ErrorDetail, AFactsZeroByteBeginsNoOtherFact) {
  const std::string sent("mt\0reason\0x", 11);
  const absl::Status status = Error(absl::StatusCode::kNotFound, "no", {"MACHINE_NOT_FOUND", {{"machine", sent}}});
  EXPECT_EQ(GetErrorDetail(status), (ErrorDetail{"MACHINE_NOT_FOUND", {{"machine", "mt reason x"}}}));
}

TEST(ErrorDetail, IsAbsentFromOtherStatuses) {
  EXPECT_FALSE(GetErrorDetail(absl::InternalError("x")).has_value());
  EXPECT_EQ(ErrorReason(absl::OkStatus()), "");
}

}  // namespace
}  // namespace axiscal::base
