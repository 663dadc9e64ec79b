#include "core/nc/corrected_word.h"

#include <gtest/gtest.h>

#include "core/nc/move_corrector.h"
#include "core/nc/testing/yao.h"

namespace axiscal::nc {
namespace {

constexpr Ticks kGrain = 1'000'000;  // of four decimals in mm or deg
const WordRule kRule = {4, 5, false}, kIncrements = {3, 4, true};

Word Written(int64_t mantissa, int decimals, bool has_point = true) {
  Word word;
  word.number.mantissa = mantissa;
  word.number.decimals = static_cast<int8_t>(decimals);
  word.number.has_point = has_point;
  return word;
}

std::string Text(const CorrectedWord& word) {
  std::string text;
  AppendNumber(word, false, &text);
  return text;
}

TEST(CorrectedWord, HasItsOwnDecimalsOrTheResolution) {
  EXPECT_EQ(kRule.Of(Written(15, 1), kTicksPerMm).decimals, 4);
  EXPECT_EQ(kRule.Of(Written(1234567, 6), kTicksPerMm).decimals, 6);
  EXPECT_EQ(kRule.Of(Written(15, 1), kTicksPerInch).decimals, 5);
  EXPECT_EQ(kRule.Of(Written(15, 1), kTicksPerMm).decimals, 4);  // a rotary axis of a program in inch
  EXPECT_EQ(kRule.Of(Written(15, 0, false), kTicksPerMm).decimals, 4);
  EXPECT_EQ(kRule.Inserted(kTicksPerMm).grain, kGrain);
  EXPECT_EQ(kRule.Inserted(kTicksPerInch).grain, 2'540'000);
}

TEST(CorrectedWord, CountsIncrementsWithoutAPoint) {
  const WordForm form = kIncrements.Of(Written(15, 0, false), kTicksPerMm);
  EXPECT_TRUE(form.is_increments);
  EXPECT_EQ(form.grain, 10 * kGrain);
  EXPECT_EQ(Text(WordFor(1'540'000'000, 0, form)), "154");
  EXPECT_TRUE(IsSaid(WordFor(150'000'000, 0, form), Written(15, 0, false)));
  EXPECT_FALSE(kIncrements.Of(Written(15, 1), kTicksPerMm).is_increments);  // it has a point
  // Of a rotary axis of a program in inch too: angles have no inch.
  EXPECT_EQ(kIncrements.Of(Written(15, 0, false), kTicksPerMm).decimals, 3);
}

TEST(CorrectedWord, IsRoundedToTheNearestHalvesAwayFromZero) {
  const WordForm form = kRule.Inserted(kTicksPerMm);
  EXPECT_EQ(Text(WordFor(kGrain / 2 - 1, 0, form)), "0.0000");
  EXPECT_EQ(Text(WordFor(kGrain / 2, 0, form)), "0.0001");
  EXPECT_EQ(Text(WordFor(-kGrain / 2, 0, form)), "-0.0001");
  EXPECT_EQ(Text(WordFor(-kGrain / 2 + 1, 0, form)), "0.0000");
}

// Where 0 of the word lies between two grains of the machine, the word still says whole grains from there, and the
// control stands where the word says.
TEST(CorrectedWord, CountsFromWhatItsZeroMeans) {
  const Ticks base = 300'000, target = 5 * kGrain;
  const CorrectedWord word = WordFor(target, base, kRule.Inserted(kTicksPerMm));
  EXPECT_EQ(Text(word), "0.0005");
  EXPECT_EQ(word.Position(base), 5'300'000);
  EXPECT_EQ(NearestHeld(target, base, kGrain), word.Position(base));
  EXPECT_EQ(NearestHeld(word.Position(base), base, kGrain), word.Position(base));
  EXPECT_EQ(NearestHeld(target, base, 0), target);
  EXPECT_EQ(NearestHeld(target, 0, kGrain), target);
}

TEST(CorrectedWord, KeepsItsBytesWhereItsNumberIsTheSame) {
  const Word word = Written(125, 1);  // 12.5
  const WordForm form = kRule.Of(word, kTicksPerMm);
  const Ticks said = 125'000'000'000;
  EXPECT_TRUE(IsSaid(WordFor(said + kGrain / 2 - 1, 0, form), word));
  EXPECT_FALSE(IsSaid(WordFor(said + kGrain / 2, 0, form), word));
}

TEST(CorrectedWord, NoWordIsNeededWithinHalfAGrain) {
  EXPECT_TRUE(IsHeld(kGrain / 2, 0, kGrain));
  EXPECT_TRUE(IsHeld(-kGrain / 2, 0, kGrain));
  EXPECT_FALSE(IsHeld(kGrain / 2 + 1, 0, kGrain));
  EXPECT_FALSE(IsHeld(-kGrain / 2 - 1, 0, kGrain));
}

// Where a move is split its rotary axes stand where their words can say: counted from what a word of 0 means, as all
// words are. With an offset of a third of the last decimal a piece was 0.00003 deg off otherwise, 0.3 um at 500 mm.
TEST(CorrectedWord, PositionsBetweenPiecesAreCountedFromTheBaseToo) {
  const compensate::Compensator compensator = testing::LeaningHead();
  const machine::Machine& machine = compensator.machine();
  RewriteOptions options;
  options.tolerance_mm = 0.002;
  const MoveCorrector corrector(compensator, options, 0.0);
  const int x = machine::FindAxis(machine, "X"), y = machine::FindAxis(machine, "Y");
  const int b = machine::FindAxis(machine, "B");
  constexpr Ticks kBase = kGrain / 3;
  WordGrain grain;
  grain.of_axis.fill(kGrain);
  grain.base.fill(kBase);
  Step step;
  step.kind = StepKind::kMove;
  step.start.known = step.end.known = 31;
  step.start.ticks[b] = step.start.ticks[x] = kBase;
  step.end.ticks[b] = 90 * kTicksPerMm + kBase;
  step.end.ticks[x] = 100 * kTicksPerMm + kBase;
  const auto expect_held = [&](const std::vector<Piece>& pieces, int axis) {
    ASSERT_GT(pieces.size(), 2u);
    for (size_t k = 0; k + 1 < pieces.size(); ++k) EXPECT_EQ((pieces[k].nominal[axis] - kBase) % kGrain, 0) << k;
  };
  const auto pieces = corrector.Split(step, grain);
  ASSERT_TRUE(pieces.ok()) << pieces.status();
  expect_held(*pieces, b);
  expect_held(*pieces, x);
  // An arc on which B turns along.
  step.is_arc = true;
  const auto arc = ArcAboutCentre({0, 0}, {100, 0}, {50, 0}, false);
  ASSERT_TRUE(arc.ok());
  step.arc = *arc;
  step.arc.first = x;
  step.arc.second = y;
  const auto arcs = corrector.SplitArc(step, step.start.ticks, grain);
  ASSERT_TRUE(arcs.ok()) << arcs.status();
  expect_held(*arcs, b);
}

}  // namespace
}  // namespace axiscal::nc
