// Ibaraki's closed form on the columns of deploy/examples/ibaraki-columns as a machine with known constant errors would
// have given them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/testing/source_path.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/published/comparison.h"
#include "core/session/case.h"
#include "core/synthetic/simulate.h"

namespace axiscal::published {
namespace {

using ::testing::HasSubstr;

const std::string kFolder = base::SourcePath("/deploy/examples/ibaraki-columns/");

machine::Machine TiltingTable() { return machine::ReadMachineFile(kFolder + "machine.json").value(); }
session::Session Columns() { return session::ReadSessionFileOf(kFolder + "fit/columns.csv", TiltingTable()).value(); }

std::map<std::string, Row> Rows(const std::string& errors) {
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  const machine::Machine machine = TiltingTable();
  const auto session = synthetic::Simulate(machine, machine::ReadErrors(errors, machine).value(), Columns(), exact);
  EXPECT_TRUE(session.ok()) << session.status();
  const auto comparison = FindSource("ibaraki-maps").value()->compare(machine, {*session});
  EXPECT_TRUE(comparison.ok()) << comparison.status();
  std::map<std::string, Row> rows;
  for (const Row& row : comparison->rows) rows[row.quantity] = row;
  return rows;
}

// Constant d = (0, 10, 15) um on A: what the paper's formulas make of it, and what it is.
TEST(IbarakiMaps, ConstantOffsetsComeBackAsMaps) {
  auto rows = Rows(R"({"EY0A": 10, "EZ0A": 15, "EB0A": 20, "EX0C": 12})");
  constexpr double kUm = 0.05, kUrad = 0.05;
  const double turns[] = {0, 60, 120, 180, 240, 300};
  const double dy_of_c[] = {-10.0, -22.3, -12.3, 10.0, 22.3, 12.3};  // for d = (20, 10, 15)
  EXPECT_NEAR(rows.at("dy of A at 0").published, 10.0, kUm);
  for (const auto& [tilt, dy, dz] :
       {std::tuple(-30, 2.5, 2.0), std::tuple(-60, -3.0, 7.5), std::tuple(-90, -5.0, 15.0)}) {
    EXPECT_NEAR(rows.at(absl::StrCat("dy of A at ", tilt)).published, dy, kUm);
    EXPECT_NEAR(rows.at(absl::StrCat("dz of A at ", tilt)).published, dz, kUm);
    EXPECT_NEAR(rows.at(absl::StrCat("dy of A at ", tilt)).exact, 10.0, kUm);
    EXPECT_NEAR(rows.at(absl::StrCat("dz of A at ", tilt)).exact, 15.0, kUm);
    EXPECT_NEAR(rows.at(absl::StrCat("dy of A at ", tilt)).corrected, 10.0, kUm);
    EXPECT_NEAR(rows.at(absl::StrCat("dz of A at ", tilt)).corrected, 15.0, kUm);
  }
  EXPECT_EQ(rows.at("dy of A at -30").symbol, "EYA");
  // dx: EX0C = 12 stands for 12 of the 20 um of A in `dy_of_c`; dy of C then has 10 cos - 12 sin.
  for (int j = 0; j < 6; ++j) {
    const double q = turns[j] * M_PI / 180.0;
    const Row& row = rows.at(absl::StrCat("dy of C at A 0 C ", turns[j]));
    EXPECT_NEAR(row.published, dy_of_c[j] + 8.0 * std::sin(q), kUm) << turns[j];
    EXPECT_NEAR(row.exact, 0.0, kUm);
    EXPECT_NEAR(row.corrected, 0.0, kUm);
  }
  // The table's displacement at an index: less the reference pose's, turned.
  const Row& turn = rows.at("b at A -60 C 120");
  EXPECT_NEAR(turn.exact, 20.0, kUrad);
  EXPECT_NEAR(turn.corrected, 20.0, kUrad);
  EXPECT_GT(std::abs(turn.published - 20.0), 5.0);
  EXPECT_NEAR(rows.at("dx at A 0 C 0").published, 0.0, 1e-9);
  EXPECT_NEAR(rows.at("dx at A 0 C 0").exact, 12.0, kUm);
}

// Published and exact numbers of sixty measurements scatter as stated, at the index, in A's map and in C's.
TEST(IbarakiMaps, StatedUncertaintiesAreThoseOfRepetition) {
  const machine::Machine machine = TiltingTable();
  const session::Session columns = Columns();
  synthetic::NoiseOptions noise;
  noise.draw_setup = false;
  constexpr int kRuns = 60;
  std::map<std::string, std::pair<double, int>> scatter;  // squares over stated variances, of each kind
  for (int seed = 1; seed <= kRuns; ++seed) {
    noise.seed = seed;
    const auto session = synthetic::Simulate(machine, {}, columns, noise);
    const auto comparison = FindSource("ibaraki-maps").value()->compare(machine, {*session});
    ASSERT_TRUE(comparison.ok()) << comparison.status();
    for (const Row& row : comparison->rows) {
      if (row.quantity.ends_with(" at A 0 C 0") && row.formula == "eqs 6, 9") {
        EXPECT_EQ(row.published_sigma, 0.0);  // nothing has moved there
        continue;
      }
      auto& [published, count] = scatter[row.formula];
      published += std::pow(row.published / row.published_sigma, 2);
      ++count;
      if (!(row.sigma > 1e-6)) continue;  // constant errors draw no map of C
      auto& [exact, exact_count] = scatter["exact"];
      exact += std::pow(row.exact / row.sigma, 2);
      ++exact_count;
    }
  }
  ASSERT_EQ(scatter.size(), 4u);
  // Some 20 independent numbers per run and kind in the published ones, 8 in the exact ones: 5 and 9 % of the variance.
  for (const auto& [kind, sum] : scatter) EXPECT_NEAR(sum.first / sum.second, 1.0, 0.2) << kind;
}

// A table whose errors vary with A and C as the declared ones do not: no number is called exact that its sigma does not
// cover.
TEST(IbarakiMaps, NothingIsExactWhereTheDeclaredErrorsDoNotExplainTheTouches) {
  const machine::Machine machine = TiltingTable();
  const std::string constants = R"("EY0A": 12.4, "EZ0A": -18.3, "EB0A": 21.7, "EX0C": 9.6, "EY0C": -16.1)";
  const auto compare = [&](const std::string& errors) {
    const auto session =
        synthetic::Simulate(machine, machine::ReadErrors(errors, machine).value(), Columns(), {}).value();
    return FindSource("ibaraki-maps").value()->compare(machine, {session}).value();
  };
  const Comparison explained = compare("{" + constants + "}");
  const Comparison varying = compare("{" + constants + R"(, "terms": [
      {"symbol": "EZA", "shape": "quadratic", "variable": "A", "amplitude": -6.5},
      {"symbol": "ECC", "shape": "harmonic", "variable": "C", "order": 2, "amplitude": 14.0, "phase_deg": 40.0}]})");
  ASSERT_EQ(explained.rows.size(), varying.rows.size());
  for (size_t i = 0; i < varying.rows.size(); ++i) {
    EXPECT_TRUE(std::isfinite(explained.rows[i].exact)) << explained.rows[i].quantity;
    EXPECT_TRUE(std::isnan(varying.rows[i].exact)) << varying.rows[i].quantity;
    EXPECT_TRUE(std::isnan(varying.rows[i].corrected) || varying.rows[i].formula.empty()) << varying.rows[i].quantity;
    EXPECT_TRUE(std::isfinite(varying.rows[i].published)) << varying.rows[i].quantity;
  }
  EXPECT_THAT(varying.notes[1], HasSubstr("no exact numbers from the declared errors: the touches scatter about them"));
}

TEST(IbarakiMaps, RefusesWhatItIsNotAbout) {
  const auto compare = FindSource("ibaraki-maps").value()->compare;
  const auto message = [&](const machine::Machine& machine, const std::vector<session::Session>& sessions) {
    const absl::Status status = compare(machine, sessions).status();
    EXPECT_FALSE(status.ok());
    return std::string(status.message());
  };
  EXPECT_THAT(message(TiltingTable(), {}), HasSubstr("expected one session of instrument touch"));
  EXPECT_THAT(message(TiltingTable(), {Columns(), Columns()}), HasSubstr("another mounting"));
  const std::string integrex = base::SourcePath("/deploy/examples/integrex/");
  const auto other = machine::ReadMachineFile(integrex + "machine.json").value();
  const auto centres = session::ReadSessionFileOf(integrex + "C-run1.csv", other).value();
  EXPECT_THAT(message(other, {centres}), HasSubstr("instrument touch"));
  session::Session without = Columns();
  for (double& angle : const_cast<session::Column*>(session::FindColumn(without, "A_deg"))->values)
    angle -= angle == 0 ? 1 : 0;
  EXPECT_FALSE(compare(TiltingTable(), {without}).ok());
  // What the declared errors leave open is said, and the exact columns stay empty.
  machine::Machine open = TiltingTable();
  open.declared.push_back(machine::ParseErrorSymbol("EX0A").value());
  const auto comparison = compare(open, {Columns()});
  ASSERT_TRUE(comparison.ok()) << comparison.status();
  EXPECT_THAT(comparison->notes[1], HasSubstr("EX0"));
  EXPECT_TRUE(std::isnan(comparison->rows[0].exact));
  EXPECT_TRUE(std::isfinite(comparison->rows[0].published));
}

}  // namespace
}  // namespace axiscal::published
