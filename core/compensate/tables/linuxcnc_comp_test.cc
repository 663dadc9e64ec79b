#include <gmock/gmock.h>

#include "core/compensate/tables/testing/made.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using testing::CorrectionOf;
using ::testing::HasSubstr;
using testing::kScale;
using testing::Made;
using testing::Make;
using testing::NotCarried;
using testing::Request;
using ::testing::StartsWith;
using testing::WithTravel;

// LinuxCNC adds trims to the command (control.c): an axis that goes 3 um too far at 300 mm gets -3 um there.
TEST(LinuxcncComp, AScaleErrorIsTwoPointsOfTheOtherSign) {
  const Made made = Make(kScale, Request("linuxcnc-comp"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, StartsWith("-300.0000 0.00300 0.00300\n300.0000 -0.00300 -0.00300\n# axis: X\n"));
  EXPECT_THAT(made.text, HasSubstr("COMP_FILE_TYPE = 1"));
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 100}}), -0.001, 1e-9);
}

// EYY > 0 is a displacement to +Y of the machine, also of a table whose Y+ moves it to -Y: its command must rise.
TEST(LinuxcncComp, BacklashIsForwardAndReverse) {
  const Made made =
      Make(R"({"terms": [{"symbol": "EYY", "shape": "backlash", "amplitude": 8}]})", Request("linuxcnc-comp"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, StartsWith("-300.0000 0.00400 -0.00400\n300.0000 0.00400 -0.00400\n# axis: Y\n"));
  EXPECT_LT(made.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.01);
}

// Worn at the ends, the other way round at one of them: 4 um / sqrt(3) times sqrt(3) x, x from -1 to 1.
TEST(LinuxcncComp, LostMotionThatIsMoreHereThanThereIsForwardAndReverse) {
  const Made made = Make(R"({"terms": [{"symbol": "EYY", "shape": "backlash-curve", "from_mm": -300, "to_mm": 300,
                              "amplitudes": [2.3094010767585034]}]})",
                         Request("linuxcnc-comp"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, StartsWith("-300.0000 -0.00400 0.00400\n300.0000 0.00400 -0.00400\n# axis: Y\n"));
  EXPECT_LT(made.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.01);
}

TEST(LinuxcncComp, ARotaryAxisIsInDegrees) {
  const Made made =
      Make(R"({"terms": [{"symbol": "ECC", "shape": "linear", "amplitude": 10}]})", Request("linuxcnc-comp", {"C"}));
  ASSERT_TRUE(made.status.ok()) << made.status;
  // 10 urad per rad over 2 pi rad: 62.83 urad = 0.0036 deg, of the other sign.
  EXPECT_THAT(made.text, StartsWith("0.0000 0.000000 0.000000\n360.0000 -0.003600 -0.003600\n# axis: C\n"));
}

TEST(LinuxcncComp, ZeroIsAtTheReference) {
  TableRequest request = Request("linuxcnc-comp");
  request.reference = {{"X", -200}};
  const Made made = Make(kScale, request);
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", -200}}), 0.0, 1e-9);
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 300}}), -0.005, 1e-9);
  EXPECT_THAT(NotCarried(made), HasSubstr("X is off by -2.00 um at the reference"));
}

// 60 periods of a 10 mm pitch: 256 points are 4.2 per period, and what they leave is said.
TEST(LinuxcncComp, PointsAreAsFewAsTheToleranceAllowsAndNeverMoreThan256) {
  const auto pitch = [](const std::string& period) {
    return R"({"terms": [{"symbol": "EXX", "shape": "harmonic", "variable": "X", "period_mm": )" + period +
           R"(, "amplitude": 5, "phase_deg": 20}]})";
  };
  const Made coarse = Make(pitch("300"), Request("linuxcnc-comp"));
  ASSERT_TRUE(coarse.status.ok()) << coarse.status;
  EXPECT_LT(coarse.report["tables"][0]["points"][0].get<int>(), 60);
  EXPECT_LT(coarse.report["tables"][0]["left_max"].get<double>(), 0.12);
  const Made fine = Make(pitch("10"), Request("linuxcnc-comp"));
  ASSERT_TRUE(fine.status.ok()) << fine.status;
  EXPECT_LE(fine.report["tables"][0]["points"][0].get<int>(), 256);
  EXPECT_GT(fine.report["tables"][0]["left_max"].get<double>(), 0.3);
  EXPECT_LT(fine.report["tables"][0]["left_max"].get<double>(), 1.7);
  EXPECT_THAT(NotCarried(fine), HasSubstr("256 points cannot follow it closer"));
  // 200 periods: fewer than two points each would be an error of their own.
  const Made lost = Make(pitch("3"), Request("linuxcnc-comp", {"X"}));
  ASSERT_TRUE(lost.status.ok()) << lost.status;
  EXPECT_THAT(NotCarried(lost), HasSubstr("256 points over the range of X are 1.3 per period, 4 are needed"));
  EXPECT_EQ(lost.report["tables"][0]["largest"], lost.report["tables"][0]["left_max"]);
}

TEST(LinuxcncComp, BadTablesAreNamedByLine) {
  const auto refused = [](const std::string& text, const std::string& message) {
    const auto table = LinuxcncCompFormat().read(WithTravel(), text);
    EXPECT_EQ(table.status().code(), absl::StatusCode::kInvalidArgument) << text;
    EXPECT_THAT(std::string(table.status().message()), HasSubstr(message)) << text;
  };
  std::string full;
  for (int i = 0; i < 256; ++i) full += absl::StrCat(i, " 0 0\n");
  EXPECT_TRUE(LinuxcncCompFormat().read(WithTravel(), full + "# axis: X\n").ok());
  refused(full + "256 0 0\n# axis: X\n", "line 257: '256 0 0', expected at most 256 points");
  refused("0 0 0\n1 0\n# axis: X\n", "line 2: '1 0', expected three decimal numbers");
  refused("0 0 0\n0 0 0\n# axis: X\n", "line 2: positions must increase");
  refused("0 0 0\n1 0 1e-3\n# axis: X\n", "line 2");
  refused("0 0 0\n# axis: X\n1 0 0\n", "line 3: '1 0 0', expected a note");
  refused("0 0 0\n1 0 0\n", "no line '# axis: NAME'");
  refused("0 0 0\n1 0 0\n# axis: V\n", "expected an axis of machine 'tt'");
  refused("# axis: X\n", "line 1");
  refused("", "no line");
}

}  // namespace
}  // namespace axiscal::tables
