// Modal state: coordinates, lengths, machine positions, calls and jumps.
#include <algorithm>
#include <random>
#include <sstream>

#include "absl/strings/str_split.h"
#include "core/base/units.h"
#include "core/nc/testing/rewritten.h"

namespace axiscal::nc {
namespace {

using ::testing::HasSubstr;
using testing::kAtZero;
using testing::Outcome;
using testing::Rewritten;

RewriteOptions Passing(RewriteOptions options = kAtZero) {
  options.on_unsupported = OnUnsupported::kPass;
  return options;
}

// B = 0 everywhere unless a test turns it: X words rise by 0.0417, words of other axes stay.
TEST(Modal, MovesToMachinePositionsAreNeverTouchedAndForgetTheirAxes) {
  EXPECT_REWRITTEN(kAtZero, "G1 X1.\nG91 G28 Z0.\nG90\nG0 X2. Y2.\nG0 Z5.\nG1 X3.\n",
                   "G1 X1.0417\nG91 G28 Z0.\nG90\nG0 X2. Y2.\nG0 Z5. X2.0417\nG1 X3.0417\n");
  EXPECT_REWRITTEN(kAtZero, "G1 X1.\nG53 G0 X-100.\nG1 X5. Y1.\n", "G1 X1.0417\nG53 G0 X-100.\nG1 X5.0417 Y1.\n");
  for (const std::string block : {"G28 Z0", "G30 P2 Z0.", "G53 G0 Z0.", "G91 G28 Z0."}) {
    EXPECT_REFUSED(kAtZero, block + "\nG90 G1 Y2.\n", "the position of Z is unknown: not programmed since line 1");
    EXPECT_REWRITTEN(kAtZero, block + "\nG90 G0 Z1. X0\n", block + "\nG90 G0 Z1. X0.0417\n");
  }
  // Without an axis word every axis may move.
  EXPECT_REFUSED(kAtZero, "G28\nG1 X1. Y1. Z1.\n", "the position of B is unknown");
  const Outcome outcome = Rewritten("G1 X1.\nG28 Z0\nG0 X2.\n", kAtZero);
  ASSERT_EQ(outcome.report.passed.size(), 1u);  // the rapid follows from it
  EXPECT_EQ(outcome.report.passed[0].line, 2);
  EXPECT_EQ(outcome.report.blocks_passed, 2);
}

TEST(Modal, TextOutputAndHarmlessWordsStay) {
  EXPECT_REWRITTEN(kAtZero, "POPEN\nDPRNT[X#5001[4 4]*Y#5002[4 4]]\nG1 X1.\nPCLOS\n",
                   "POPEN\nDPRNT[X#5001[4 4]*Y#5002[4 4]]\nG1 X1.0417\nPCLOS\n");
}

TEST(Modal, StatedToolLengthsShiftZAndTheToolPoint) {
  RewriteOptions options = kAtZero;
  EXPECT_REFUSED(options, "G43 H3 Z5.\n", "tool length 3: its value is not stated");
  EXPECT_REFUSED(options, "G43 Z5.\n", "tool length offset without a number");
  options.tool_lengths = {{1, 0.0}, {2, 100.0}};
  EXPECT_REWRITTEN(options, "G43 H1 Z5.\nG1 X1.\nG49 Z0.\n", "G43 H1 Z5. X0.0417\nG1 X1.0417\nG49 Z0.\n");
  // 456.3945 mm lean by 53.35 um.
  EXPECT_REWRITTEN(options, "G43 H2 Z5.\nG1 X1.\nG43 H1 X1.\n", "G43 H2 Z5. X0.0533\nG1 X1.0533\nG43 H1 X1.0417\n");
  EXPECT_REFUSED(options, "G43 H2\nG91 Z5.\n", "G91 behind a change of the tool length");
  EXPECT_REFUSED(options, "G18 G43 H2 Z5.\n", "another plane");
  // H0 is no length.
  EXPECT_REWRITTEN(options, "G43 H0 Z5.\nG1 X1.\n", "G43 H0 Z5. X0.0417\nG1 X1.0417\n");
}

TEST(Modal, PresetCoordinatesAreTakenFromWhereTheControllerStands) {
  // The controller stands at 1.0417 when X becomes 0: the correction is in its coordinates already.
  EXPECT_REWRITTEN(kAtZero, "G1 X1.\nG92 X0\nX5.\nG92.1\nX2.\n", "G1 X1.0417\nG92 X0\nX5.\nG92.1\nX2.0417\n");
  // At B = 90 the correction of X is 0 and that of Z -0.0417.
  EXPECT_REWRITTEN(kAtZero, "G1 X1. Z0.\nG92 X0 Z10.\nX0. Z10. B90.\n",
                   "G1 X1.0417 Z0.\nG92 X0 Z10.\nX-0.0417 Z9.9583 B90.\n");
  EXPECT_REFUSED(testing::InMm(), "G92 X0\n", "the position of X is unknown");
  EXPECT_REWRITTEN(kAtZero, "G92 S2000\nG1 X1.\n", "G92 S2000\nG1 X1.0417\n");
}

TEST(Modal, LocalShiftsMovePositions) {
  // B40 in coordinates shifted by 50 stands at 90.
  EXPECT_REWRITTEN(kAtZero, "G1 X0.\nG52 B50.\nX0. Z0. B40.\nG52 B0\nX0. Z0. B90.\n",
                   "G1 X0.0417\nG52 B50.\nX0. Z-0.0417 B40.\nG52 B0\nX0. Z-0.0417 B90.\n");
  EXPECT_REFUSED(kAtZero, "G91 G52 X5.\n", "G52");
  EXPECT_REFUSED(kAtZero, "G92 X7.\nG52 X5.\n", "G92");
}

TEST(Modal, ClearedPresetsAreThoseOfTheAxesNamedAndLocalShiftsEndWithThem) {
  // B90 stands at 0 as long as its preset acts.
  EXPECT_REWRITTEN(kAtZero, "G1 X1. Z0.\nG92 X0 B90.\nG92.1 X0\nX2. B90.\n",
                   "G1 X1.0417 Z0.\nG92 X0 B90.\nG92.1 X0\nX2.0417 B90.\n");
  EXPECT_REWRITTEN(kAtZero, "G52 B50.\nG92.1 B0\nG1 X0. Z0. B90.\n", "G52 B50.\nG92.1 B0\nG1 X0. Z-0.0417 B90.\n");
  RewriteOptions options = kAtZero;
  options.dialect = "linuxcnc";
  EXPECT_REWRITTEN(options, "G52 B50.\nG92.1\nG0 X0. Z0. B90.\n", "G52 B50.\nG92.1\nG0 X0. Z-0.0417 B90.\n");
  EXPECT_REFUSED(options, "G52 X5\nG92.2\nG1 X0\n", "with a local shift (G52) in force");
}

TEST(Modal, LengthOfTheToolInTheSpindleIsNotThatOfTheLastNumber) {
  RewriteOptions options = kAtZero;
  options.tool_lengths = {{1, 0.0}};
  EXPECT_REWRITTEN(options, "G43 H1 Z5.\nG49\nG43 Z5. X1.\n", "G43 H1 Z5. X0.0417\nG49\nG43 Z5. X1.0417\n");
  options.dialect = "linuxcnc";
  EXPECT_REFUSED(options, "G43 H1 Z5.\nT2 M6\nG43 Z5.\n", "tool length 2: its value is not stated");
}

TEST(Modal, WordsWithoutAPointAreNoted) {
  const std::string note =
      "line 2: word X5 has no point: such words count whole units here, on other controls least increments";
  const std::string program = "G1 X0 Y0.\nX5\nX7\n";
  const RewriteReport report = Rewritten(program, kAtZero).report;
  EXPECT_THAT(TextsOf(report.notes), ::testing::ElementsAre(note));
  // Programs read what it is about by its name, and where.
  ASSERT_EQ(report.notes.size(), 1u);
  EXPECT_EQ(report.notes[0].kind, "whole-units");
  EXPECT_EQ(report.notes[0].line, 2);
  RewriteOptions options = kAtZero;
  options.dialect = "linuxcnc";
  EXPECT_THAT(TextsOf(Rewritten(program, options).report.notes), ::testing::IsEmpty());
}

TEST(Modal, TextBehindASubstituteIsNotTakenForTheEnd) {
  for (const std::string program : {"G1 X1.\n\x1A\nG1 X2.\n", "G1 X1.\n\x1AG1 X2.\n", "G1 X1.\x1A\nX2.\n"})
    EXPECT_REFUSED(kAtZero, program, "text behind 0x1A");
  EXPECT_REWRITTEN(kAtZero, "G1 X1.\n%\n\x1A\nX2.\n", "G1 X1.0417\n%\n\x1A\nX2.\n");
  EXPECT_REWRITTEN(kAtZero, "G1 X1.\n\x1A\x1A\n\n\x1A", "G1 X1.0417\n\x1A\x1A\n\n\x1A");
}

TEST(Modal, AxisWordsOfLimitsAndMirrorsAreNoMoves) {
  for (const std::string block : {"G22 X100. Y100. Z50. I-100. J-100. K-50.", "G22 X5.", "G50.1 X0 Y0"})
    EXPECT_REWRITTEN(kAtZero, "G1 X1.\n" + block + "\nX2.\n", "G1 X1.0417\n" + block + "\nX2.0417\n");
  EXPECT_REFUSED(kAtZero, "G1 X1. G22\n", "stored stroke check and a motion code in one block");
  RewriteOptions options = kAtZero;
  options.dialect = "haas";
  EXPECT_REWRITTEN(options, "G100 X0\nG1 X2.\n", "G100 X0\nG1 X2.0417\n");
  options.dialect = "sinumerik";
  EXPECT_REWRITTEN(options, "G25 X-200 Y-200\nG26 X200\nG25 S50\nG1 X2.\n",
                   "G25 X-200 Y-200\nG26 X200\nG25 S50\nG1 X2.0417\n");
}

TEST(Modal, AdditionalWorkOffsetsByNumber) {
  RewriteOptions options = kAtZero;
  options.work_offsets = {{"G54.1 P5", {{"B", 90 * base::kRadPerDeg}}}};
  EXPECT_REWRITTEN(options, "G54.1 P5\nG1 X1. Y0. Z0. B0. C0.\n", "G54.1 P5\nG1 X1. Y0. Z-0.0417 B0. C0.\n");
  EXPECT_REFUSED(options, "G54.1 P6\n", "G54.1 P6 (additional work offset): its values are not stated");
  EXPECT_REFUSED(options, "G54.1\n", "G54.1 without a P word");
  // A probe's macro may have measured it.
  const testing::Outcome probed = testing::Rewritten("G65 P9814 D5.\nG90 G17 G21 G94\nG54.1 P5\nG1 X1.\n", options);
  ASSERT_GE(probed.report.refused.size(), 2u);
  EXPECT_THAT(probed.report.refused[1].reason, ::testing::HasSubstr("line 1 may have measured or set it anew"));
  EXPECT_REFUSED(options, "G54.1 P5\nG10 L2 P1 X0\nG1 X5.\n", "G10 (data input");
}

// "G54 P5" of Fanuc is G54.1 P5; elsewhere no control is known that reads it.
TEST(Modal, WorkOffsetsWithANumber) {
  RewriteOptions options = kAtZero;
  options.work_offsets = {{"G54", {}}, {"G55", {}}, {"G54.1 P5", {{"B", 90 * base::kRadPerDeg}}}};
  const std::string move = "G1 X1. Y0. Z0. B0. C0.\n", turned = "G1 X1. Y0. Z-0.0417 B0. C0.\n",
                    plain = "G1 X1.0417 Y0. Z0. B0. C0.\n";
  for (const char* dialect : {"fanuc", "mazak", "haas", "linuxcnc"}) {
    options.dialect = dialect;
    const bool takes_number = std::string(dialect) == "fanuc" || std::string(dialect) == "mazak";
    for (const std::string block : {"G54 P5\n", "G90 G17 G0 G54 P5 M3 S500 T2\n"}) {
      if (takes_number) EXPECT_REWRITTEN(options, block + move, block + turned);
      if (!takes_number) EXPECT_REFUSED(options, block + move, "with a P word: which offset it selects is not known");
    }
    EXPECT_REFUSED(options, "G55 P5\n" + move, "G55 with a P word");
    // The P word is another code's.
    EXPECT_REWRITTEN(options, "G54 G4 P5\n" + move, "G54 G4 P5\n" + plain);
    EXPECT_REWRITTEN(options, "G54 G64 P0.05\n" + move, "G54 G64 P0.05\n" + plain);
    EXPECT_REWRITTEN(options, "G54\n" + move, "G54\n" + plain);
  }
  // M codes that read a P word, as the manuals say.
  for (const char* code : {"M62", "M63", "M64", "M65", "M66", "M50", "M53", "M19 R90"}) {
    options.dialect = "linuxcnc";
    const std::string block = absl::StrCat("G54 ", code, " P5\n");
    EXPECT_REWRITTEN(options, block + move, block + plain);
  }
  for (const char* code : {"M19", "M59", "M69"}) {
    options.dialect = "haas";
    const std::string block = absl::StrCat("G54 ", code, " P5\n");
    EXPECT_REWRITTEN(options, block + move, block + plain);
  }
  // On Fanuc P may choose the spindle of M3: only right behind G54 it is the offset's for certain.
  for (const char* dialect : {"fanuc", "mazak"}) {
    options.dialect = dialect;
    for (const std::string block : {"G54 S500 M3 P5", "M8 P5 G54", "G54 G90 P5 M3", "M19 P5 G54"})
      EXPECT_REFUSED(options, block + "\n", "G54 with a P word: which offset it selects is not known");
    for (const std::string block : {"M3 S500 G54 P5 M8\n", "G54 G90 P5\n"})
      EXPECT_REWRITTEN(options, block + move, block + turned);
  }
  // Where the number must stand in P, another code's P is none.
  options.dialect = "haas";
  options.work_offsets.push_back({"G154 P5", {{"B", 90 * base::kRadPerDeg}}});
  EXPECT_REWRITTEN(options, "G154 P5 M3 S500\n" + move, "G154 P5 M3 S500\n" + turned);
  EXPECT_REFUSED(options, "M59 P5 G154\n", "G154 without a P word of its own");
  EXPECT_REFUSED(options, "M59 P5 G154 P7\n", "G154 without a P word of its own");
  options.dialect = "fanuc";
  EXPECT_REFUSED(options, "G54 P6\n", "G54.1 P6 (work offset): its values are not stated");
}

TEST(Modal, BehindACallTheModalStateIsUnknown) {
  const Outcome outcome =
      Rewritten("G90 G1 X1.\nM98 P1000\nX5. Y0. Z0. B0. C0.\nG90 G54 G1 X5. Y0. Z0. B0. C0.\n", Passing());
  EXPECT_EQ(outcome.report.blocks_corrected, 1);
  EXPECT_EQ(outcome.report.blocks_passed, 3);
  RewriteOptions options = Passing();
  options.work_offsets = {{"G54", {}}};
  EXPECT_REWRITTEN(options, "G90 G1 X1.\nM98 P1000\nX5. Y0. Z0. B0. C0.\nG90 G21 G54 G49 G94 G1 X5. Y0. Z0. B0. C0.\n",
                   "G90 G1 X1.0417\nG01 X1.0000\nM98 P1000\nX5. Y0. Z0. B0. C0.\n"
                   "G90 G21 G54 G49 G94 G1 X5.0417 Y0. Z0. B0. C0.\n");
}

TEST(Modal, BehindAJumpNothingIsCorrected) {
  EXPECT_REWRITTEN(Passing(), "G90 G1 X1.\nIF [#1 EQ 0] GOTO 10\nG91\nN10 G90 G1 X5. Y0. Z0. B0. C0.\n",
                   "G90 G1 X1.0417\nG01 X1.0000\nIF [#1 EQ 0] GOTO 10\nG91\nN10 G90 G1 X5. Y0. Z0. B0. C0.\n");
}

TEST(Modal, NumbersForVariablesStayAndForgetNothing) {
  EXPECT_REWRITTEN(kAtZero, "O1\n#100=5\nG1 X1.\nN5 #101=-2.5 #102=3 (depth)\nX2.\n",
                   "O1\n#100=5\nG1 X1.0417\nN5 #101=-2.5 #102=3 (depth)\nX2.0417\n");
}

TEST(Modal, ABlockThatIsNotReadToItsEndLeavesTheModalStateUnknown) {
  EXPECT_REWRITTEN(Passing(), "G1 X1.\nY#5 G91\nX5. Y0. Z0. B0. C0.\n",
                   "G1 X1.0417\nG01 X1.0000\nY#5 G91\nX5. Y0. Z0. B0. C0.\n");
  EXPECT_REWRITTEN(Passing(), "G1 X1.\nY#5 F200\nX5. Y0. Z0. B0. C0.\n",
                   "G1 X1.0417\nG01 X1.0000\nY#5 F200\nX5.0417 Y0. Z0. B0. C0.\n");
}

TEST(Modal, StopEndsAtTheFirstBlock) {
  RewriteOptions options = kAtZero;
  options.on_unsupported = OnUnsupported::kStop;
  const Outcome outcome = Rewritten("G1 X1.\nG81 Z-5. R2.\nG80\nG1 X1. Y0. Z0. B0. C0.\nG41 D1\n", options);
  EXPECT_EQ(outcome.status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(outcome.status.message()), HasSubstr("line 2: 'G81 Z-5. R2.'"));
  EXPECT_EQ(outcome.report.blocks_refused, 1);
  EXPECT_EQ(outcome.report.blocks_read, 2);
}

// Rewritten, without the lines that are comments: a mark, if there is one, and others.
Outcome WithoutComments(const std::string& program, const RewriteOptions& options) {
  Outcome outcome;
  const auto text = RewriteText(program, testing::LeaningHead(), options, &outcome.report);
  outcome.status = text.status();
  std::istringstream lines(text.value_or(""));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || (line[0] != '(' && line[0] != ';')) outcome.text += line + "\n";
  }
  return outcome;
}

// Random blocks of `usual` words and now and then an `odd` one, each followed by `comment` or not: a comment makes the
// block behind it take the long way. Returns how many blocks were corrected.
int64_t CompareBothWays(const std::vector<std::string>& usual, const std::vector<std::string>& odd,
                        const std::string& comment, const RewriteOptions& options) {
  std::mt19937 random(11);
  int64_t corrected = 0;
  for (int round = 0; round < 2000; ++round) {
    std::string together, apart;
    for (int line = 0; line < 12; ++line) {
      std::string block = random() % 20 == 0 ? "/" : "";
      for (size_t words = 1 + random() % 4; words > 0; --words)
        block += (random() % 12 == 0 ? odd[random() % odd.size()] : usual[random() % usual.size()]) + " ";
      together += block + "\n";
      apart += block + "\n" + comment + "\n";
    }
    const Outcome short_way = WithoutComments(together, options), long_way = WithoutComments(apart, options);
    EXPECT_EQ(short_way.text, long_way.text) << together;
    EXPECT_EQ(short_way.status.code(), long_way.status.code()) << together;
    EXPECT_EQ(short_way.report.blocks_read, long_way.report.blocks_read) << together;
    EXPECT_EQ(short_way.report.blocks_corrected, long_way.report.blocks_corrected) << together;
    EXPECT_EQ(short_way.report.blocks_split, long_way.report.blocks_split) << together;
    EXPECT_EQ(short_way.report.blocks_passed, long_way.report.blocks_passed) << together;
    EXPECT_EQ(short_way.report.passed.size(), long_way.report.passed.size()) << together;
    for (size_t i = 0; i < std::min(short_way.report.passed.size(), long_way.report.passed.size()); ++i)
      EXPECT_EQ(short_way.report.passed[i].block, long_way.report.passed[i].block) << together;
    if (::testing::Test::HasFailure()) break;
    corrected += short_way.report.blocks_corrected;
  }
  return corrected;
}

// A block behind a plain move is read the short way.
TEST(Modal, PlainMovesMeanWhatTheyMeanAlone) {
  const std::vector<std::string> usual = absl::StrSplit("X12.5|Y-3.25|Z7.|B30.|C-45.5|F500.|N20|S900|T3|G1|G01", '|');
  const std::vector<std::string> odd = absl::StrSplit(
      "G0|G00|G90|G91|G20|G21|G17|G94|G93 F2.|G80|A1.|I1.|X1. X2.|M5|M6|H1|R2.|P1|G4 P1|G28 Z0|G92 X0.|G52 X1.|G41|G40|"
      "G54|M98 P7|G43 H1 Z5.|G5 P2|X12345|X1.0000000001|G2 X1. Y1. R5.|#1=2|(note)|x5.|G1 G1|G1 G0",
      '|');
  RewriteOptions options = Passing();
  options.tool_lengths = {{1, 0.0}};
  options.work_offsets = {{"G54", {{"X", 5.0}}}};
  EXPECT_GT(CompareBothWays(usual, odd, "(apart)", options), 2000);
}

// Rounded corners and words that state their distance change how the blocks behind them are taken.
TEST(Modal, PlainMovesBehindCornersAndStatedDistancesMeanWhatTheyMeanAlone) {
  const std::vector<std::string> usual = absl::StrSplit("X12.5|Y-3.25|Z7.|B30.|C-45.5|F500|N20|S900|G1", '|');
  const std::vector<std::string> odd = absl::StrSplit(
      "RND=2|RNDM=1|RNDM=0|CHF=1|X=IC(5)|X=AC(10)|C=DC(90)|C=ACP(300)|C=ACN(20)|G0|G91|G90|G3 X5 Y5 CR=20|SUPA|R1=5|M5",
      '|');
  RewriteOptions options = Passing();
  options.dialect = "sinumerik";
  options.initial_position = {{"X", 0}, {"Y", 0}, {"Z", 0}, {"B", 0}, {"C", 0}};
  EXPECT_GT(CompareBothWays(usual, odd, ";apart", options), 2000);
}

}  // namespace
}  // namespace axiscal::nc
