#include "core/nc/poses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/machine/testing/machines.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;

absl::StatusOr<std::vector<ProgramPose>> Read(const std::string& text, size_t most = 10) {
  const machine::Machine machine = machine::testing::MultiTasking();
  RewriteOptions options;
  options.unit = ProgramUnit::kMillimetre;
  return ReadPoses(TextReader(text), machine, options, most);
}

TEST(ReadPoses, EndsOfMovesInMmAndRad) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const auto poses = Read("G01 X1. Y2. Z3. B90. C0. F100\n(nothing)\nX-4.\n");
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[1].line, 3);
  const auto at = [&](size_t k, const char* axis) {
    return (*poses)[k].pose.position[machine::FindAxis(machine, axis)];
  };
  EXPECT_DOUBLE_EQ(at(0, "B"), 90.0 * base::kRadPerDeg);
  EXPECT_DOUBLE_EQ(at(1, "X"), -4.0);
  EXPECT_DOUBLE_EQ(at(1, "Z"), 3.0);
  EXPECT_EQ((*poses)[1].pose.sense[machine::FindAxis(machine, "X")], -1.0);
}

TEST(ReadPoses, RefusesWhatIsNoPose) {
  const auto message = [](const absl::StatusOr<std::vector<ProgramPose>>& poses) {
    EXPECT_EQ(poses.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(poses.status().message());
  };
  EXPECT_THAT(message(Read("")), HasSubstr("moves nothing"));
  EXPECT_THAT(message(Read("G01 X1. Y2. Z3. B0. F100\n")), HasSubstr("line 1: the position of C is not known yet"));
  EXPECT_THAT(message(Read("G01 X0. Y0. Z0. B0. C0. F100\nG02 X1. Z1. I1. K0.\n")),
              HasSubstr("line 2: expected linear"));
  EXPECT_THAT(message(Read("G01 X0. Y0. Z0. B0. C0. F100\nX#1\n")), HasSubstr("line 2: expected linear"));
  EXPECT_THAT(message(Read("G01 X0. Y0. Z0. B0. C0. F100\nX1.\nX2.\n", 2)), HasSubstr("line 3: expected at most 2"));
}

}  // namespace
}  // namespace axiscal::nc
