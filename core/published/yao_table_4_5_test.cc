// Yao's Table 4.5 from the measured eccentricities of Table 4.4 (deploy/examples/integrex), and from simulated ones,
// where the printed formulas miss the truth and the corrected ones and the engine do not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/instruments/eccentricity/eccentricity_bind.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/published/comparison.h"
#include "core/session/case.h"
#include "core/synthetic/simulate.h"

namespace axiscal::published {
namespace {

using ::testing::HasSubstr;

const std::string kFolder = base::SourcePath("/deploy/examples/integrex/");

machine::Machine Integrex() { return machine::ReadMachineFile(kFolder + "machine.json").value(); }

std::vector<session::Session> Measured(const std::vector<std::string>& names = {"B", "C", "C-long"}) {
  std::vector<session::Session> sessions;
  for (const std::string& name : names)
    sessions.push_back(session::ReadSessionFileOf(kFolder + "eccentricity-" + name + ".csv", Integrex()).value());
  return sessions;
}

std::map<std::string, Row> Rows(const std::vector<session::Session>& sessions) {
  std::map<std::string, Row> rows;
  const auto comparison = FindSource("yao-table-4.5").value()->compare(Integrex(), sessions);
  EXPECT_TRUE(comparison.ok()) << comparison.status();
  if (!comparison.ok()) return rows;
  for (const Row& row : comparison->rows) rows[row.quantity] = row;
  return rows;
}

TEST(YaoTable45, ThePrintedNumbersAndWhatTheErrataMakeOfThem) {
  auto rows = Rows(Measured());
  ASSERT_EQ(rows.size(), 8u);
  constexpr double kPrinted = 0.005;
  const std::map<std::string, std::pair<double, double>> printed_and_corrected = {
      {"aCZ", {1.10, 1.10}}, {"bCZ", {-25.16, -25.16}}, {"aXB", {-20.89, -20.89}},        {"bXB", {-24.11, 24.11}},
      {"gXB", {5.63, 5.63}}, {"aBT", {9.63, 9.63}},     {"dxCZ - dxBT", {53.13, -81.67}}, {"dyCZ", {-45.63, 6.66}}};
  for (const auto& [quantity, numbers] : printed_and_corrected) {
    EXPECT_NEAR(rows[quantity].published, numbers.first, kPrinted) << quantity;
    EXPECT_NEAR(rows[quantity].corrected, numbers.second, kPrinted) << quantity;
    const bool has_erratum = std::abs(numbers.first - numbers.second) > 0.1 || quantity == "aBT";
    EXPECT_EQ(!rows[quantity].note.empty(), has_erratum) << quantity;
    EXPECT_TRUE(std::isfinite(rows[quantity].exact)) << quantity;
  }
  // Means of three runs of 0.3 um each.
  const double mean_um = 0.3 / std::sqrt(3.0);
  EXPECT_NEAR(rows["bCZ"].published_sigma, mean_um / 50.0 * 1e-3 * base::kArcsecPerRad, 1e-6);
  EXPECT_NEAR(rows["dxCZ - dxBT"].published_sigma, mean_um * std::hypot(1.0, 65.5348 / 50.0, 112.2877 / 356.3945),
              1e-9);
  const Comparison comparison = *FindSource("yao-table-4.5").value()->compare(Integrex(), Measured());
  ASSERT_EQ(comparison.notes.size(), 1u);
  EXPECT_THAT(comparison.notes[0], HasSubstr("-53.85 um predicted"));
  EXPECT_THAT(comparison.notes[0], HasSubstr("closure of -3.88 um"));
}

// The same sessions as a machine with known errors would have given them: which column is right?
TEST(YaoTable45, OnAMachineWithKnownErrorsThePrintedFormulasMiss) {
  const machine::Machine machine = Integrex();
  const auto truth = machine::ReadErrors(
      R"({"EX0C": 40, "EY0C": -30, "EA0C": 25, "EB0C": -35, "EA0B": 45, "EB0B": -55, "EC0B": 20, "EA0T": 60})",
      machine);
  std::vector<session::Session> simulated;
  for (session::Session session : Measured()) {
    std::erase_if(session.columns, [](const session::Column& column) { return column.name.ends_with("_um"); });
    synthetic::NoiseOptions exact;
    exact.sigma_scale = 0.0;
    exact.draw_setup = false;
    simulated.push_back(synthetic::Simulate(machine, *truth, session, exact).value());
  }
  auto rows = Rows(simulated);
  ASSERT_EQ(rows.size(), 8u);
  const std::map<std::string, double> true_um_or_urad = {{"aCZ", 25}, {"bCZ", -35},        {"aXB", 45},   {"bXB", -55},
                                                         {"gXB", 20}, {"dxCZ - dxBT", 40}, {"dyCZ", -30}, {"aBT", 60}};
  constexpr double kArcsecPerUrad = base::kArcsecPerRad * base::kRadPerUrad;
  constexpr double kSecondOrderUm = 0.05, kSecondOrderArcsec = 0.05;
  for (const auto& [quantity, number] : true_um_or_urad) {
    const Row& row = rows[quantity];
    const double expected = row.unit == "um" ? number : number * kArcsecPerUrad;
    const double tolerance = row.unit == "um" ? kSecondOrderUm : kSecondOrderArcsec;
    EXPECT_NEAR(row.corrected, expected, tolerance) << quantity;
    EXPECT_NEAR(row.exact, expected, tolerance) << quantity;
  }
  EXPECT_NEAR(rows["bXB"].published, 55 * kArcsecPerUrad, kSecondOrderArcsec);
  EXPECT_GT(std::abs(rows["dxCZ - dxBT"].published - 40), 10.0);
  EXPECT_GT(std::abs(rows["dyCZ"].published + 30), 10.0);
}

TEST(YaoTable45, WhatIsMissingIsNamedAndNothingIsMadeUp) {
  auto rows = Rows(Measured({"B"}));
  EXPECT_THAT(rows["aCZ"].note, HasSubstr("needs CA"));
  EXPECT_TRUE(std::isnan(rows["aCZ"].published));
  EXPECT_TRUE(std::isnan(rows["aCZ"].exact));
  EXPECT_TRUE(std::isfinite(rows["bXB"].published));
  rows = Rows(Measured({"B", "C"}));
  EXPECT_THAT(rows["aBT"].note, HasSubstr("second tool length"));
  std::vector<session::Session> bare = Measured();
  for (session::Session& session : bare)
    std::erase_if(session.header, [](const session::HeaderEntry& entry) { return entry.key == "zt_mm"; });
  rows = Rows(bare);
  EXPECT_THAT(rows["dyCZ"].note, HasSubstr("headers zt_mm and xt_mm"));
  EXPECT_NEAR(rows["dyCZ"].corrected, 6.66, 0.005);
}

TEST(YaoTable45, RefusesOtherMachinesAndSessions) {
  const auto compare = FindSource("yao-table-4.5").value()->compare;
  const auto grinder =
      machine::ReadMachineFile(base::SourcePath("/deploy/examples/fang-grinder/machine.json")).value();
  EXPECT_THAT(std::string(compare(grinder, Measured()).status().message()), HasSubstr("a machine ZYXB|C"));
  const auto centres = session::ReadSessionFileOf(kFolder + "C-run1.csv", Integrex()).value();
  EXPECT_THAT(std::string(compare(Integrex(), {centres}).status().message()),
              HasSubstr("expected instrument eccentricity"));
  std::vector<session::Session> upside_down = Measured({"B"});
  for (session::HeaderEntry& entry : upside_down[0].header)
    if (entry.key == "tool_tip_mm") entry.value = "0 0 356.3945";
  EXPECT_THAT(std::string(compare(Integrex(), upside_down).status().message()),
              HasSubstr("tool tip 0 0 356.394: stands 356.4 mm behind axis B"));
  std::vector<session::Session> twice = Measured({"B", "B"});
  EXPECT_THAT(std::string(compare(Integrex(), twice).status().message()), HasSubstr("is there twice"));
  EXPECT_THAT(std::string(FindSource("yao").status().message()), HasSubstr("expected one of yao-table-4.5"));
}

}  // namespace
}  // namespace axiscal::published
