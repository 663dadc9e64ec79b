// Identification as the thesis publishes it (Yao 2022, chapter 4, Table 4.5), by its closed formulas from the measured
// eccentricities of Table 4.4: the numbers that the engine is compared with, and what the engine says to the same
// tests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/identify/identify.h"
#include "core/instruments/ballbar/ballbar_plan.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/published.h"
#include "tests/known_answers/yao_machine.h"
#include "tests/known_answers/yao_tables.h"

namespace axiscal::known_answers {
namespace {

using ballbar::Pattern;

// Rows of Table 4.5 to one in a hundred, or to half of the last printed digit.
constexpr double kShare = 0.01, kPrinted = 0.005;
void ExpectTable45(double ours, double published, const std::string& what) {
  ExpectPublished(ours, published, std::max(kShare * std::abs(published), kPrinted), "Yao 2022, Table 4.5: " + what);
}

TEST(YaoTable45, ClosedFormulasGiveThePublishedDeviations) {
  const YaoTables m = ReadYaoTables();
  const auto e = [&](const std::string& name) { return base::kMmPerUm * m.MeanUm(name); };
  const BarSetup bx = m.setups.at("BX"), with_long = m.setups.at("CR-long");
  constexpr double kRcMm = 50.0;
  const double rb = bx.tool_length_mm, zc = bx.zc_mm, zt = bx.zt_mm, zt_long = with_long.zt_mm, xt = bx.xt_mm;
  constexpr double kArcsec = base::kArcsecPerRad;
  ExpectTable45(kArcsec * (-e("CA ey") / kRcMm), 1.10, "aCZ, arcsec");
  ExpectTable45(kArcsec * (e("CA ex") / kRcMm), -25.16, "bCZ, arcsec");
  ExpectTable45(kArcsec * (e("BY ez") / rb), -20.89, "aXB, arcsec");
  ExpectTable45(kArcsec * (e("BX ez") / rb), -24.11, "bXB, arcsec");
  ExpectTable45(kArcsec * (-e("BY ex") / rb), 5.63, "gXB, arcsec");
  const double slope = (e("CR-long ey") - e("CR ey")) / (zt_long - zt);
  ExpectTable45(kArcsec * (slope - e("BY ez") / rb), 9.63, "aBT, arcsec");
  ExpectTable45(base::kUmPerMm * (-e("CR ex") + zc * e("CA ex") / kRcMm - zt * e("BX ez") / rb), 53.13,
                "dxCZ - dxBT, um");
  const double dy_cz =
      zc * e("CA ey") / kRcMm + (zt * e("CR-long ey") - zt_long * e("CR ey")) / (zt_long - zt) + xt * e("BY ex") / rb;
  ExpectTable45(base::kUmPerMm * dy_cz, -45.63, "dyCZ, um");
}

// The fifth test repeats ex of CR with a longer tool. Predicted from the others it misses by ten times its
// repeatability: no deviation of the thesis explains it.
TEST(YaoTable45, TheRedundantEccentricityDoesNotClose) {
  const YaoTables m = ReadYaoTables();
  const auto e = [&](const std::string& name) { return base::kMmPerUm * m.MeanUm(name); };
  const double lever_change = m.setups.at("CR-long").zt_mm - m.setups.at("CR").zt_mm;
  const double predicted_um =
      base::kUmPerMm * (e("CR ex") - lever_change * e("BX ez") / m.setups.at("BX").tool_length_mm);
  ExpectPublished(predicted_um, -53.85, 0.01, "Yao 2022, Table 4.4: ex of CR-long by the others, um");
  EXPECT_NEAR(base::kUmPerMm * e("CR-long ex") - predicted_um, -3.88, 0.01);
}

// What the engine says of the same tests when the deviations are asked for from whole traces, the table ball free in
// every session. A whole trace tells more than its eccentricity: on CR a squareness EC0X draws an oval (second
// harmonic), so one deviation more is seen than by the thesis' numbers, until CX and CY show it to both.
int RankOfWholeTraces(const std::vector<std::pair<Pattern, double>>& patterns, bool with_squareness) {
  const machine::Machine machine = YaoMachine();
  std::vector<session::Session> sessions;
  for (const auto& [pattern, tool_length_mm] : patterns) {
    ballbar::PatternOptions plan;
    plan.tool_length_mm = tool_length_mm;
    plan.step_deg = 3.0;
    const std::string name = "run" + std::to_string(sessions.size());
    synthetic::NoiseOptions noise;
    noise.seed = sessions.size() + 1;
    sessions.push_back(
        synthetic::Simulate(machine, {}, ballbar::PlanPattern(machine, name, pattern, plan).value(), noise).value());
  }
  identify::Options options;
  options.model = ModelOf(machine, {});
  std::erase_if(options.model->terms, [&](const machine::ErrorTerm& term) {
    return !with_squareness && machine::SymbolOf(machine, term) == "EC0X";
  });
  return identify::Identify(machine, sessions, options).value().rank;
}

TEST(YaoIdentify, RanksOfWholeTraces) {
  constexpr double kShortMm = 356.4, kLongMm = 406.4;
  std::vector<std::pair<Pattern, double>> patterns = {
      {Pattern::kBX, kShortMm}, {Pattern::kBY, kShortMm}, {Pattern::kCR, kShortMm}, {Pattern::kCA, kShortMm}};
  EXPECT_EQ(RankOfWholeTraces(patterns, false), 8);
  EXPECT_EQ(RankOfWholeTraces(patterns, true), 9);
  patterns.push_back({Pattern::kCR, kLongMm});
  EXPECT_EQ(RankOfWholeTraces(patterns, false), 10);
  EXPECT_EQ(RankOfWholeTraces(patterns, true), 11);
  patterns.clear();
  for (const double tool_length_mm : {kShortMm, kLongMm}) {
    for (const auto& [name, pattern] : ballbar::Patterns()) patterns.push_back({pattern, tool_length_mm});
  }
  EXPECT_EQ(RankOfWholeTraces(patterns, true), 12);
}

}  // namespace
}  // namespace axiscal::known_answers
