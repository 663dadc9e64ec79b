#include "core/machine/explain.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/machine/testing/machines.h"

namespace axiscal::machine {
namespace {

using ::testing::HasSubstr;
using testing::kOrigin;
using testing::kX;
using testing::kY;
using testing::kZ;
using testing::Linear;
using testing::Make;
using ::testing::Not;
using testing::Rotary;

TEST(Explain, MultiTaskingMachine) {
  const std::string text = Explain(testing::MultiTasking());
  EXPECT_THAT(text, HasSubstr("X+ moves the tool to +X   [carries the tool]\n"));
  EXPECT_THAT(text, HasSubstr("Z+ moves the tool to +Z"));
  // Yao 2022: the tool points to -Z at B = 0 and to -X at B = +90.
  EXPECT_THAT(
      text,
      HasSubstr(
          "B+ turns the tool counter-clockwise, looking from +Y to -Y; its tip swings to -X   [carries the tool]\n"));
  EXPECT_THAT(
      text, HasSubstr("C+ turns the tool clockwise, looking from +Z to -Z   [carries the workpiece, counter-clockwise]"
                      "   ! ISO 841 expects counter-clockwise, looking from +Z to -Z\n"));
  EXPECT_THAT(text, HasSubstr("tool:      bed - Z - Y - X - B - spindle, tool along -Z\n"));
}

TEST(Explain, AxesThatCarryTheWorkpieceMoveTheToolTheOtherWay) {
  const std::string text = Explain(testing::SwivelHead());
  // Directions [-1, 0, 0] and [0, -1, 0]: the primed axes of ISO 841.
  EXPECT_THAT(text, HasSubstr("X+ moves the tool to +X   [carries the workpiece, to -X]\n"));
  EXPECT_THAT(text, HasSubstr("Y+ moves the tool to +Y   [carries the workpiece, to -Y]\n"));
}

TEST(Explain, AWrongSignIsSeen) {
  const Machine machine = Make("m", {Linear("Z", kZ)}, {Linear("X", kX), Rotary("C", -kZ, {10, 20, 0})}, {});
  const std::string text = Explain(machine);
  EXPECT_THAT(
      text,
      HasSubstr("X+ moves the tool to -X   [carries the workpiece, to +X]   ! ISO 841 expects the tool to go to +X\n"));
  EXPECT_THAT(
      text,
      HasSubstr("C+ turns the tool counter-clockwise, looking from +Z to -Z   [carries the workpiece, clockwise]\n"));
  const auto motions = ExplainMotions(machine);
  EXPECT_TRUE(motions[0].follows_iso_841);
  EXPECT_FALSE(motions[1].follows_iso_841);
  EXPECT_TRUE(motions[2].follows_iso_841);
}

TEST(Explain, ObliqueAxesAndTurnsAboutTheToolItself) {
  const Machine machine =
      Make("m", {Linear("Z1", Eigen::Vector3d(0, 0.6, 0.8)), Rotary("J1", kZ, kOrigin), Rotary("J2", kY, {0, 0, 50})},
           {}, {});
  const auto motions = ExplainMotions(machine);
  EXPECT_EQ(ToText(motions[0]), "Z1+ moves the tool to (0, 0.6, 0.8)");
  EXPECT_EQ(ToText(motions[1]), "J1+ turns the tool counter-clockwise, looking from +Z to -Z");
  EXPECT_TRUE(motions[1].tip_motion.isZero());
  EXPECT_EQ(ToText(motions[2]), "J2+ turns the tool counter-clockwise, looking from +Y to -Y; its tip swings to -X");
  EXPECT_THAT(Explain(machine), Not(HasSubstr("ISO 841")));
}

}  // namespace
}  // namespace axiscal::machine
