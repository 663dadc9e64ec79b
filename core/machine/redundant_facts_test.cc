#include "core/machine/redundant_facts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/machine/machine_json.h"

namespace axiscal::machine {
namespace {

using ::testing::HasSubstr;

std::string MachineText(const std::string& structure, const std::string& tool_direction, const std::string& b_axis) {
  return R"({"id": "mt", "structure": ")" + structure + R"(", "axes": {
    "X": {"kind": "linear", "direction": [1, 0, 0]}, "Y": {"kind": "linear", "direction": [0, 1, 0]},
    "Z": {"kind": "linear", "direction": [0, 0, 1]}, "B": )" + b_axis + R"(,
    "C": {"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}},
    "tool_branch": ["Z", "Y", "X", "B"], "work_branch": ["C"], "tool_direction": )" + tool_direction + "}";
}
Machine Make(const std::string& b_axis = R"({"kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 100]})",
             const std::string& direction = "[0, 0, -1]") {
  return MachineFromJson(MachineText("w-C'bZYXB(C1)-t", direction, b_axis)).value();
}

TEST(ToolTip, OnTheWrongSideOfTheSwivelAxisIsRefused) {
  const Machine machine = Make();
  EXPECT_TRUE(CheckToolTip(machine, {0, 0, -250}).ok());
  EXPECT_TRUE(CheckToolTip(machine, {0, 0, 100}).ok());     // on the axis
  EXPECT_TRUE(CheckToolTip(machine, {300, 0, 150}).ok());   // an angle head
  EXPECT_TRUE(CheckToolTip(machine, {0, 250, 200}).ok());   // a ball on an arm along the axis
  const absl::Status refused = CheckToolTip(machine, {5, 0, 450});
  EXPECT_EQ(refused.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(refused.message()),
              HasSubstr("tool tip 5 0 450: stands 350 mm behind axis B, on the other side than tool_direction 0 0 -1"));
  const Machine up = Make(R"({"kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 0]})", "[0, 0, 1]");
  EXPECT_TRUE(CheckToolTip(up, {0, 0, 350}).ok());
  EXPECT_FALSE(CheckToolTip(up, {0, 0, -350}).ok());
}

// The axis of a nutating head stands at 45 deg.
TEST(ToolTip, ANutatingHeadHasSidesToo) {
  const Machine machine =
      Make(R"({"kind": "rotary", "direction": [0, 0.7071067811865476, 0.7071067811865476], "point_mm": [0, 0, 0]})");
  EXPECT_TRUE(CheckToolTip(machine, {0, 0, -300}).ok());
  EXPECT_FALSE(CheckToolTip(machine, {0, 0, 300}).ok());
}

// No field says where the spindle's nose stands at home where nothing swivels the tool.
TEST(ToolTip, NothingIsKnownWithoutASwivelAxis) {
  const Machine machine = Make(R"({"kind": "rotary", "direction": [0, 0, 1], "point_mm": [0, 0, 0]})");
  EXPECT_TRUE(CheckToolTip(machine, {0, 0, -300}).ok());
  EXPECT_TRUE(CheckToolTip(machine, {0, 0, 300}).ok());
}

TEST(Structure, ContradictingTheBranchesIsRefused) {
  const std::string b = R"({"kind": "rotary", "direction": [0, 1, 0], "point_mm": [0, 0, 0]})";
  for (const char* const right :
       {"w-C'bZYXB(C1)-t", "w-C'bZYXB-t", "w - C' b Z Y X B - t", "w-C'bZX(C1)-t", "", "five axes, B head"})
    EXPECT_TRUE(MachineFromJson(MachineText(right, "[0, 0, -1]", b)).ok()) << right;
  for (const char* const wrong : {"w-C'B'bZYX(C1)-t", "w-C'bXYZB(C1)-t", "w-bZYXBC-t"}) {
    const auto machine = MachineFromJson(MachineText(wrong, "[0, 0, -1]", b));
    ASSERT_FALSE(machine.ok()) << wrong;
    EXPECT_THAT(std::string(machine.status().message()), HasSubstr("which read w-CbZYXB-t"));
  }
}

}  // namespace
}  // namespace axiscal::machine
