// Rotary axes that count from 0 to 360 deg: the way of a move is the machine's, also in pieces.
#include <cmath>

#include "core/base/units.h"
#include "core/nc/move_reader.h"
#include "core/nc/testing/rewritten.h"
#include "core/nc/verify.h"

namespace axiscal::nc {
namespace {

using machine::RollOver;
using ::testing::HasSubstr;

machine::Machine WithC(RollOver roll_over) {
  machine::Machine machine = machine::testing::MultiTasking();
  machine.axes[static_cast<size_t>(machine::FindAxis(machine, "C"))].roll_over = roll_over;
  return machine;
}

RewriteOptions Fine(const std::string& dialect = "fanuc") {
  RewriteOptions options = testing::kAtZero;
  options.dialect = dialect;
  options.tolerance_mm = 0.001;
  return options;
}

struct Result {
  absl::Status status;
  std::string text;
  int pieces = 0;
  double turned_deg = 0;  // by C, all moves together
  VerifyReport verified;
};

// The table's axis runs out six times a turn, so that its moves are split.
Result Split(RollOver roll_over, const std::string& program, const RewriteOptions& options = Fine()) {
  const machine::Machine machine = WithC(roll_over);
  machine::ErrorModel errors = testing::ConstantErrors(machine, {{"EX0C", 0.02}, {"EA0C", 2e-4}});
  errors.terms[0].shape = shapes::Harmonic{machine::FindAxis(machine, "C"), 6.0};
  const auto compensator = testing::MustCreate(machine, errors, {0, 0, -testing::kToolMm});
  Result result;
  RewriteReport report;
  const auto text = RewriteText(program, compensator, options, &report);
  result.status = text.status();
  if (!text.ok()) return result;
  result.text = *text;
  auto interpreter = Interpreter::Create(machine, options);
  EXPECT_TRUE(interpreter.ok());
  const ByteReader reader = TextReader(result.text);
  MoveReader moves(reader, *std::move(interpreter));
  const auto c = static_cast<size_t>(machine::FindAxis(machine, "C"));
  for (Event event; *moves.Next(&event); ++result.pieces) {
    EXPECT_EQ(event.step.kind, StepKind::kMove) << event.step.reason;
    const double travel = static_cast<double>(event.step.end.ticks[c] - event.step.start.ticks[c]) / kTicksPerUnit;
    EXPECT_LT(std::abs(travel), 180.0) << result.text;
    result.turned_deg += travel;
  }
  VerifyOptions verify;
  verify.tool_tip_mm = {0, 0, -testing::kToolMm};
  verify.reading = options;
  const auto verified = VerifyText(program, result.text, machine, errors, verify);
  EXPECT_TRUE(verified.ok()) << verified.status() << result.text;
  if (verified.ok()) result.verified = *verified;
  return result;
}

void ExpectTurns(RollOver roll_over, const std::string& program, double turned_deg,
                 const RewriteOptions& options = Fine()) {
  const Result result = Split(roll_over, program, options);
  ASSERT_TRUE(result.status.ok()) << result.status << program;
  EXPECT_NEAR(result.turned_deg, turned_deg, 1e-9) << result.text;
  EXPECT_GT(result.pieces, 3) << result.text;
  EXPECT_LT(result.verified.path_after.max_mm, 0.0013) << result.text;
  EXPECT_LT(result.verified.end_after.max_mm, 0.0002) << result.text;
}

constexpr char kHead[] = "G90 G0 X300. Y0. Z0. B0. C350.\n";

TEST(RollOver, PiecesGoTheWayOfTheMachine) {
  const std::string over = std::string(kHead) + "G1 C10. F500\n";  // starts at 0: rapid by -10
  ExpectTurns(RollOver::kShortest, over, -10 + 20);
  ExpectTurns(RollOver::kShortest, over + "C350.\nC-20.\nC100.\n", -10 + 20 - 20 - 10 + 120);
  ExpectTurns(RollOver::kShortest, over + "G91 C-30.\nG90 C10.\n", -10 + 20 - 30 + 30);
  const std::string signs = "G90 G0 X300. Y0. Z0. B0. C100.\nG1 C-10. F500\nC170.\nC-80.\n";
  ExpectTurns(RollOver::kBySign, signs, 100 - 90 + 160 - 90);
  ExpectTurns(RollOver::kNone, "G90 G0 X300. Y0. Z0. B0. C50.\nG1 C190. F500\nC70.\n", 70);
}

TEST(RollOver, PiecesBySignStateTheSense) {
  const Result result = Split(RollOver::kBySign, "G90 G0 X300. Y0. Z0. B0. C20.\nG1 C-340. F500\n");
  ASSERT_TRUE(result.status.ok()) << result.status;
  EXPECT_NEAR(result.turned_deg, 20 - 40, 1e-9) << result.text;
  EXPECT_EQ(result.text.find(" C3"), std::string::npos) << result.text;  // every word has its sign
}

TEST(RollOver, ByDifferenceNeverCrossesZero) {
  const Result result = Split(RollOver::kByDifference, "G90 G0 X300. Y0. Z0. B0. C100.\nG1 C10. F500\n");
  ASSERT_TRUE(result.status.ok()) << result.status;
  EXPECT_NEAR(result.turned_deg, 10, 1e-9);
  EXPECT_THAT(std::string(Split(RollOver::kByDifference, "G1 X0. C-10.\n").status.message()), HasSubstr("0 to 360"));
  EXPECT_THAT(std::string(Split(RollOver::kByDifference, "G1 X0. C360.\n").status.message()), HasSubstr("0 to 360"));
}

TEST(RollOver, AnAxisThatSaysNothingIsAskedForWhereItMatters) {
  const std::string over = std::string(kHead) + "G1 C10. F500\n";
  EXPECT_THAT(
      std::string(Split(RollOver::kUnstated, over).status.message()),
      HasSubstr("line 2: 'G1 C10. F500': word C10.: it turns C by half a turn or more, and which way is not known: "
                "state in machine.json how the axis counts (roll_over)"));
  ExpectTurns(RollOver::kUnstated, "G90 G0 X300. Y0. Z0. B0. C50.\nG1 C190. F500\nC70.\n", 70);
  // With travel limits it counts on.
  machine::Machine limited = WithC(RollOver::kUnstated);
  limited.axes[static_cast<size_t>(machine::FindAxis(limited, "C"))].min_position = -100.0;
  limited.axes[static_cast<size_t>(machine::FindAxis(limited, "C"))].max_position = 100.0;
  const auto compensator =
      testing::MustCreate(limited, testing::ConstantErrors(limited, {{"EX0C", 0.01}}), {0, 0, -300});
  EXPECT_TRUE(testing::Rewritten(over, Fine(), compensator).status.ok());
}

TEST(RollOver, HalfATurnHasNoShorterWay) {
  EXPECT_THAT(std::string(Split(RollOver::kShortest, "G90 G1 X300. C180. F500\n").status.message()),
              HasSubstr("half a turn"));
  RewriteOptions turning = Fine();
  turning.orientation = true;
  EXPECT_THAT(std::string(Split(RollOver::kShortest, "G90 G1 X300. C179.95 F500\n", turning).status.message()),
              HasSubstr("half a turn"));
  EXPECT_THAT(std::string(Split(RollOver::kBySign, "G90 G1 X300. C17. F500\n", turning).status.message()),
              HasSubstr("sense of rotation by the sign"));
  EXPECT_THAT(std::string(Split(RollOver::kBySign, "G90 G1 X300. C-0. F500\n").status.message()),
              HasSubstr("that of zero"));
  EXPECT_THAT(std::string(Split(RollOver::kBySign, "G90 G1 X300. C400. F500\n").status.message()), HasSubstr("360"));
}

TEST(RollOver, KlartextSaysItByM126) {
  const std::string head = "L X+300 Y+0 Z+0 B+0 C+350 R0 FMAX\n", move = "L X+200 C+10 R0 F500\n";
  RewriteOptions options = Fine("heidenhain");
  const Result shorter = Split(RollOver::kByDifference, "L M126\n" + head + move, options);
  ASSERT_TRUE(shorter.status.ok()) << shorter.status;
  EXPECT_NEAR(shorter.turned_deg, 10, 1e-9) << shorter.text;
  EXPECT_GT(shorter.pieces, 3) << shorter.text;
  // Unstated the way is not known, with M126 or without.
  EXPECT_FALSE(Split(RollOver::kUnstated, "L M126\n" + head + move, options).status.ok());
  EXPECT_FALSE(Split(RollOver::kUnstated, head + move, options).status.ok());
  // With travel limits it counts on, until the program speaks of a shorter way.
  machine::Machine limited = WithC(RollOver::kUnstated);
  machine::Axis& c = limited.axes[static_cast<size_t>(machine::FindAxis(limited, "C"))];
  c.min_position = -10.0;
  c.max_position = 10.0;
  const auto compensator =
      testing::MustCreate(limited, testing::ConstantErrors(limited, {{"EX0C", 0.02}}), {0, 0, -testing::kToolMm});
  RewriteReport report;
  EXPECT_TRUE(RewriteText(head + move, compensator, options, &report).ok());
  EXPECT_THAT(std::string(RewriteText("L M126\n" + head + move, compensator, options, &report).status().message()),
              HasSubstr("roll_over"));
  EXPECT_TRUE(RewriteText("L M126\nL M127\n" + head + move, compensator, options, &report).ok());
  // M127 of a builder whose axes go the shorter way always.
  EXPECT_NEAR(Split(RollOver::kShortest, "L M127\n" + head + move, options).turned_deg, 10, 1e-9);
}

TEST(RollOver, SinumerikWordsKeepTheirForm) {
  RewriteOptions options = Fine("sinumerik");
  const Result result =
      Split(RollOver::kShortest, "G90 G0 X300 Y0 Z0 B0 C350\nG1 X200 C=DC(10) F500\nG91 X1 C=DC(100)\n", options);
  ASSERT_TRUE(result.status.ok()) << result.status;
  EXPECT_NEAR(result.turned_deg, 100, 1e-9) << result.text;
  EXPECT_LT(result.verified.path_after.max_mm, 0.0013) << result.text;
}

// Piece by piece in absolute words the axis would go another way: C-62.876 by the sign, or 180 deg and more at once.
TEST(RollOver, AnIncrementalWordIsNotSplitIntoAbsoluteOnes) {
  const std::string program = "G90 G0 X300 Y0 Z0 B0 C240\nG1 X200 C=IC(-302.876) F500\n";
  for (const RollOver roll_over : {RollOver::kBySign, RollOver::kByDifference, RollOver::kShortest}) {
    const Result result = Split(roll_over, program, Fine("sinumerik"));
    EXPECT_THAT(result.status.message(), HasSubstr("its word of C is incremental")) << result.text;
  }
  // Where the mode is incremental, so are the pieces.
  EXPECT_TRUE(Split(RollOver::kBySign, "G90 G0 X300 Y0 Z0 B0 C100\nG91 G1 X-100 C-302.876 F500\n", Fine("sinumerik"))
                  .status.ok());
}

// An absolute angle in G91 would be travelled as a way: C28.9761 in place of C0.0029.
TEST(RollOver, AWayBackInG91IsADifference) {
  const machine::Machine machine = WithC(RollOver::kShortest);
  const auto compensator =
      testing::MustCreate(machine, testing::ConstantErrors(machine, {{"EX0C", 0.02}, {"EA0C", 2e-4}, {"EB0C", 2e-4}}),
                          {0, 0, -testing::kToolMm});
  for (const char* const dialect : {"fanuc", "haas", "mazak"}) {
    RewriteOptions options = Fine(dialect);
    options.orientation = true;
    options.on_unsupported = OnUnsupported::kPass;
    RewriteReport report;
    const auto text =
        RewriteText("G90 G1 X300. Y0. Z0. B20. C350. F500\nC28.976\nG91 G28 Z0.\nZ1.\n", compensator, options, &report);
    ASSERT_TRUE(text.ok()) << text.status();
    const size_t at = text->find("C", text->find("G91"));
    ASSERT_NE(at, std::string::npos) << *text;
    EXPECT_LT(std::abs(std::atof(text->c_str() + at + 1)), 0.1) << *text;
  }
}

}  // namespace
}  // namespace axiscal::nc
