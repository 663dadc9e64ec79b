// The controllers' formats: signs, limits, senses of motion, and what their readers refuse.
#include <gmock/gmock.h>

#include <cmath>

#include "core/compensate/tables/testing/made.h"
#include "core/compensate/tables/text.h"

namespace axiscal::tables {
namespace {

using testing::CorrectionOf;
using ::testing::HasSubstr;
using testing::kScale;
using testing::Made;
using testing::Make;
using ::testing::Not;
using testing::NotCarried;
using testing::Request;
using testing::WithTravel;

constexpr char kBacklash[] = R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 10},
                                            {"symbol": "EXX", "shape": "backlash", "amplitude": 6}]})";

void Refused(const Format& format, const std::string& text, const std::string& message) {
  const auto table = format.read(WithTravel(), text);
  EXPECT_EQ(table.status().code(), absl::StatusCode::kInvalidArgument) << text;
  EXPECT_THAT(std::string(table.status().message()), HasSubstr(message)) << text;
}

// `text` with the first `from` as `to`.
std::string Changed(std::string text, const std::string& from, const std::string& to) {
  const size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

// Whatever the format and its sign: an axis that goes 1 um too far at 100 mm is sent there 1 um less far.
class EveryFormatOfX : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryFormatOfX, AScaleErrorIsTakenAway) {
  TableRequest request = Request(GetParam());
  const Made made = Make(kScale, request);
  ASSERT_TRUE(made.status.ok()) << made.status;
  const double step_mm = (*FindFormat(GetParam()))->limits.value_step_mm;
  for (const double at : {-250.0, -33.0, 100.0, 271.0})
    EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", at}}), -1e-5 * at, 0.51 * step_mm + 1e-6) << at;
  const auto& error = made.report["tool_point_error"];
  EXPECT_NEAR(error["along_axes"]["before"]["max_um"].get<double>(), 3.0, 0.01);
  EXPECT_LT(error["along_axes"]["after"]["max_um"].get<double>(), step_mm * 1e3 + 0.02);
  EXPECT_LE(made.report["tables"][0]["left_max"].get<double>(), 0.51 * step_mm * 1e3 + 0.02);
}

TEST_P(EveryFormatOfX, NumbersHaveNoExponentAndNoNegativeZero) {
  const Made made = Make(
      R"({"terms": [{"symbol": "EXX", "shape": "harmonic", "variable": "X", "period_mm": 250,
                     "amplitude": 4, "phase_deg": 10}]})",
      Request(GetParam()));
  ASSERT_TRUE(made.status.ok()) << made.status;
  for (size_t at = made.text.find("-0"); at != std::string::npos; at = made.text.find("-0", at + 1)) {
    const size_t end = made.text.find_first_not_of("-0.", at);
    EXPECT_TRUE(std::isdigit(made.text[end])) << made.text.substr(at, 20);
  }
  for (size_t at = made.text.find('e'); at != std::string::npos; at = made.text.find('e', at + 1))
    EXPECT_FALSE(at > 0 && std::isdigit(made.text[at - 1])) << made.text.substr(at - 5, 20);
}

// 150 periods: more than the points of most controllers can follow.
TEST_P(EveryFormatOfX, AFinePitchIsFollowedOrListed) {
  const Made made = Make(R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 10},
      {"symbol": "EXX", "shape": "harmonic", "variable": "X", "period_mm": 4, "amplitude": 2, "phase_deg": 10}]})",
                         Request(GetParam()));
  ASSERT_TRUE(made.status.ok()) << made.status;
  const int most = (*FindFormat(GetParam()))->limits.max_points;
  const std::string points = absl::StrCat(most, " points");
  if (most < 4 * 150)
    EXPECT_THAT(NotCarried(made), HasSubstr("EXX:harmonic(4mm): " + points));
  else
    EXPECT_LT(made.report["tables"][0]["left_max"].get<double>(), 1.0);
}

INSTANTIATE_TEST_SUITE_P(Formats, EveryFormatOfX,
                         ::testing::Values("linuxcnc-comp", "siemens-eec", "siemens-cec", "fanuc-pitch"),
                         [](const auto& format) {
                           std::string name = format.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(SiemensEec, ValuesAreErrorsAndPointsAreCounted) {
  const Made made = Make(kBacklash, Request("siemens-eec"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, HasSubstr("$AA_ENC_COMP[0,0,X]=-0.0030\n$AA_ENC_COMP[0,1,X]=0.0030\n"
                                   "$AA_ENC_COMP_STEP[0,X]=600.0000\n$AA_ENC_COMP_MIN[0,X]=-300.0000\n"
                                   "$AA_ENC_COMP_MAX[0,X]=300.0000\n$AA_ENC_COMP_IS_MODULO[0,X]=0\n"));
  EXPECT_THAT(made.text, HasSubstr("MD38000 $MA_MM_ENC_COMP_MAX_POINTS[0,X] = 2 or more"));
  EXPECT_THAT(NotCarried(made), HasSubstr("EXX:backlash: siemens-eec knows no sense of motion"));
}

// A worm gear of 180 teeth: enough points, and what they leave is judged between them.
TEST(SiemensEec, AWormGearIsFollowed) {
  const Made made =
      Make(R"({"terms": [{"symbol": "ECC", "shape": "harmonic", "order": 180, "amplitude": 20, "phase_deg": 10}]})",
           Request("siemens-eec", {"C"}));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_GT(made.report["tables"][0]["points"][0].get<int>(), 180 * 10);
  // The tolerance of 0.1 urad and half a step of 0.00001 deg.
  EXPECT_LT(made.report["tables"][0]["left_max"].get<double>(), 0.25);
}

TEST(SiemensEec, BadFilesAreNamedByLine) {
  const Format format = SiemensEecFormat();
  const std::string good = Make(kScale, Request("siemens-eec")).text;
  Refused(format, Changed(good, "=0.0030", "=3e-3"), "'3e-3', expected a decimal number");
  Refused(format, Changed(good, "[0,1,X]", "[0,0,X]"), "expected every value once");
  Refused(format, Changed(good, "[0,1,X]", "[0,2,X]"), "has 3 values, (MAX - MIN) / STEP + 1 = 2");
  Refused(format, Changed(good, "[0,1,X]", "[0,9999,X]"), "expected a number below 5000");
  Refused(format, Changed(good, "[0,1,X]", "[0,1,V]"), "expected an axis of machine 'tt'");
  Refused(format, Changed(good, "STEP[0,X]=600.0000", "STEP[0,X]=0"), "_STEP above zero");
  Refused(format, Changed(good, "MODULO[0,X]=0", "MODULO[0,X]=1"), "_IS_MODULO = 0");
  Refused(format, Changed(good, "CHANDATA(1)", "CHAN"), "line 2");
  Refused(format, "M17\n", "no $AA_ENC_COMP");
}

TEST(SiemensCec, SensesArePairsOfTables) {
  const Made made = Make(kBacklash, Request("siemens-cec"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, HasSubstr("$AN_CEC[0,0]=0.0000\n$AN_CEC[0,1]=0.0060\n$AN_CEC_INPUT_AXIS[0]=(X)\n"
                                   "$AN_CEC_OUTPUT_AXIS[0]=(X)\n"));
  EXPECT_THAT(made.text, HasSubstr("$AN_CEC_DIRECTION[0]=1\n"));
  EXPECT_THAT(made.text, HasSubstr("$AN_CEC[1,0]=-0.0060\n$AN_CEC[1,1]=0.0000\n"));
  EXPECT_THAT(made.text, HasSubstr("$AN_CEC_DIRECTION[1]=-1\n"));
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 100}}, 1.0), -0.004, 1e-7);
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 100}}, -1.0), 0.002, 1e-7);
}

// Straightness is a correction of one axis over another.
TEST(SiemensCec, OneAxisOverAnother) {
  const char* const sag = R"({"terms": [{"symbol": "EZX", "shape": "quadratic", "amplitude": -40}]})";
  const Made made = Make(sag, Request("siemens-cec"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  ASSERT_EQ(made.report["tables"].size(), 1u);
  EXPECT_EQ(made.report["tables"][0]["of"], "Z");
  EXPECT_EQ(made.report["tables"][0]["over"][0], "X");
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "Z", {{"X", 250}}), 0.040, 2e-4);
  EXPECT_LT(made.report["tool_point_error"]["within_ranges"]["after"]["max_um"].get<double>(), 0.25);
  EXPECT_TRUE(Make(sag, Request("siemens-cec", {"Z(X)"})).status.ok());
  EXPECT_FALSE(Make(sag, Request("siemens-cec", {"Z("})).status.ok());
}

TEST(SiemensCec, BadFilesAreNamedByLine) {
  const Format format = SiemensCecFormat();
  const std::string good = Make(kBacklash, Request("siemens-cec")).text;
  Refused(format, Changed(good, "DIRECTION[1]=-1", "DIRECTION[1]=1"), "stands alone");
  Refused(format, Changed(good, "DIRECTION[0]=1", "DIRECTION[0]=0"), "of direction -1 stands alone");
  Refused(format, Changed(good, "OUTPUT_AXIS[1]=(X)", "OUTPUT_AXIS[1]=(Y)"), "of direction -1 stands alone");
  Refused(format, Changed(good, "INPUT_AXIS[0]=(X)", "INPUT_AXIS[0]=X"), "an axis in parentheses");
  Refused(format, Changed(good, "$AN_CEC[1,0]", "$AN_CEC[7,0]"), "expected tables in order from 0");
  Refused(format, Changed(good, "MULT_BY_TABLE[0]=0", "MULT_BY_TABLE[0]=1"), "_MULT_BY_TABLE");
  Refused(format, "", "no whole $AN_CEC table");
}

TEST(FanucPitch, IncrementsAddUpFromTheReference) {
  TableRequest request = Request("fanuc-pitch");
  request.reference = {{"X", -100}};
  request.max_points = 7;
  request.tolerance_mm = 1e-6;  // all seven
  const Made made = Make(R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 60}]})", request);
  ASSERT_TRUE(made.status.ok()) << made.status;
  // The error rises by 6 um per 100 mm, so each increment of the correction is -6 units of 1 um.
  EXPECT_THAT(made.text, HasSubstr("N10000P0\nN10001P-6\nN10002P-6\nN10003P-6\nN10004P-6\nN10005P-6\nN10006P-6\n%\n"));
  EXPECT_THAT(made.text, HasSubstr("(X 3620=2 3621=0 3622=6 3623=1 3624=100.0000 "));
  EXPECT_THAT(made.text, HasSubstr("REFERENCE=-100.0000 UNIT=0.001)"));
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", -100}}), 0.0, 1e-9);
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 200}}), -0.018, 6e-4);
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", -300}}), 0.012, 6e-4);
}

TEST(FanucPitch, TheOtherSenseIsASecondRow) {
  const Made made = Make(kBacklash, Request("fanuc-pitch"));
  ASSERT_TRUE(made.status.ok()) << made.status;
  EXPECT_THAT(made.text, HasSubstr(" 3605#0=1 3626=3 3627=6 "));
  // Zero at the reference while it rises; six um more while it falls.
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 0}}, 1.0), 0.0, 1e-9);
  EXPECT_NEAR(CorrectionOf(WithTravel(), made.table, "X", {{"X", 0}}, -1.0), 0.006, 1e-9);
  EXPECT_LT(made.report["tool_point_error"]["along_axes"]["after"]["max_um"].get<double>(), 1.01);
}

// 7 x magnification: steep errors take coarser steps, and say so in what is left.
TEST(FanucPitch, TheMagnificationIsTheSmallestThatHolds) {
  TableRequest request = Request("fanuc-pitch");
  const char* const slope = R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 180}]})";
  const Made steep = Make(slope, request);
  ASSERT_TRUE(steep.status.ok()) << steep.status;
  EXPECT_THAT(steep.text, HasSubstr(" 3623=1 "));  // as many points as that takes
  EXPECT_LE(steep.report["tables"][0]["left_max"].get<double>(), 0.6);
  request.max_points = 3;
  const Made coarse = Make(slope, request);
  ASSERT_TRUE(coarse.status.ok()) << coarse.status;
  EXPECT_THAT(coarse.text, HasSubstr(" 3623=8 "));  // 54 um over 300 mm: 7 x 8 = 56
  EXPECT_LE(coarse.report["tables"][0]["left_max"].get<double>(), 4.1);
  EXPECT_GT(coarse.report["tables"][0]["left_max"].get<double>(), 1.0);
  request.resolution = 1e-4;
  const Made fine = Make(kScale, request);
  ASSERT_TRUE(fine.status.ok()) << fine.status;
  EXPECT_THAT(fine.text, HasSubstr("UNIT=0.0001)"));
  const Made beyond = Make(R"({"terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 5000}]})", request);
  EXPECT_EQ(beyond.status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(beyond.status.message()), HasSubstr("changes by more than 7 x 100 detection units"));
}

TEST(FanucPitch, BadFilesAreNamedByLine) {
  const Format format = FanucPitchFormat();
  const std::string good = Make(kBacklash, Request("fanuc-pitch")).text;
  Refused(format, Changed(good, "N10001P", "N10002P"), "expected N10001");
  Refused(format, Changed(good, "N10001P-3", "N10001P-8"), "P from -7 to 7");
  Refused(format, Changed(good, "N10001P-3", "N10001P"), "expected NP with whole numbers");
  Refused(format, Changed(good, "N10000P0\n", "N10000P0 X1\n"), "and nothing else");
  Refused(format, Changed(good, "(X 3620", "(V 3620"), "expected an axis of machine 'tt'");
  Refused(format, Changed(good, "3622=2", "3622=200"), "2 to 128 points");
  Refused(format, Changed(good, "3624=", "3629="), "3624=NUMBER");
  Refused(format, Changed(good, "%\n", ""), "expected '%'");
  Refused(format, "%\n%\n", "no note of an axis");
}

}  // namespace
}  // namespace axiscal::tables
