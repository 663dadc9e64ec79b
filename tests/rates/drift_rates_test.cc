// A fleet's rates stay what docs/drift.md says, within what the chance of so few machines allows.
#include <gtest/gtest.h>

#include "tests/rates/drift_score.h"

namespace axiscal::rates {
namespace {

TEST(DriftRates, OfAFleetOverTenYears) {
  synthetic::YearsToDraw asked;
  asked.seed = 2026;
  DriftScore score;
  Group group;
  constexpr int kMachines = 60;
  for (int number = 0; number < kMachines; ++number)
    Judge(synthetic::DrawMachineYears(asked, number), true, &group, &score);
  const std::string text = ToText(score);
  EXPECT_EQ(score.machines, kMachines);
  // 0.57 in 10 machine-years are 32 of 565; two of their roots more.
  EXPECT_LE(score.after.at("all").alarms, 43) << text;
  EXPECT_GT(score.after.at("all").years, 540.0) << text;
  const Recall& large = score.recall.at("d >= 6");
  EXPECT_GE(large.all, 40) << text;
  EXPECT_GE(large.found[1], 0.92 * large.all) << text;  // within three; 0.99 less three of its sigmas
  EXPECT_GE(score.suspected.all, 150) << text;
  EXPECT_GE(score.suspected.share(), 0.97) << text;
  EXPECT_GE(score.dated.share(), 0.90) << text;
  EXPECT_GE(score.named.share(), 0.93) << text;
  // Nine tenths of 800 forecasts; those of one machine are alike, so twice the binomial three sigmas.
  const Share& measured = score.forecasts.at("measured,  90 days");
  EXPECT_GE(measured.all, 600) << text;
  EXPECT_NEAR(measured.share(), 0.91, 0.06) << text;
}

// A clean machine is the one that must not be disturbed: 0.23 false alarms in 10 machine-years (133 in 5,691 of the
// seeds 2026112701 to 2026112703).
TEST(DriftRates, CleanMachinesAreLeftAlone) {
  synthetic::YearsToDraw asked;
  asked.seed = 2027;
  asked.disturbances = {false, false, false, false, false, false, 0.0};
  DriftScore score;
  Group group;
  for (int number = 0; number < 40; ++number) Judge(synthetic::DrawMachineYears(asked, number), false, &group, &score);
  EXPECT_LE(score.after.at("all").alarms, 6 + 7) << ToText(score);  // 6 of 380 machine-years, and three of its roots
  EXPECT_EQ(score.unstable, 0) << ToText(score);
  // Some of them are seen through by the calibrations behind them and taken back: 16 in the same 5,691 machine-years,
  // so 1.1 in these 380, and more than two in 9 of 100 such fleets. No threshold of the score keeps that at none: where
  // a step needed -1 there were 11 (none in 48 of 100 such fleets), and steps of five sigma were found too late
  // (docs/drift.md); to wait for those calibrations would be as late.
  EXPECT_LE(score.retractions, 2) << ToText(score);
  EXPECT_EQ(score.retracted_right, 0) << ToText(score);
  EXPECT_TRUE(score.recall.empty());
}

}  // namespace
}  // namespace axiscal::rates
