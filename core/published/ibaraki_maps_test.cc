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

// All faces are touched at the reference pose; elsewhere the tops, and of the sides those of "+" down to A = -30, those
// of "-" beyond.
session::Session FewerElsewhere() {
  session::Session session = Columns();
  const std::vector<double> a_deg = session::FindColumn(session, "A_deg")->values,
                            c_deg = session::FindColumn(session, "C_deg")->values;
  const std::vector<std::string> faces = session::FindColumn(session, "feature")->texts;
  for (session::Column& column : session.columns) {
    size_t kept = 0;
    for (size_t k = 0; k < faces.size(); ++k) {
      const bool is_side_of_here = (faces[k].find('+') != std::string::npos) == (a_deg[k] > -45.0);
      if (!(a_deg[k] == 0 && c_deg[k] == 0) && !faces[k].ends_with("top") && !is_side_of_here) continue;
      if (!column.values.empty()) column.values[kept] = column.values[k];
      if (!column.texts.empty()) column.texts[kept] = column.texts[k];
      ++kept;
    }
    column.values.resize(column.values.empty() ? 0 : kept);
    column.texts.resize(column.texts.empty() ? 0 : kept);
  }
  // A place that is known, so that what the simulator draws of it is small.
  for (const char* axis : {"x", "y", "z"})
    session.header.push_back({absl::StrCat("artefact_", axis, "_sigma_um"), "20"});
  for (const char* axis : {"a", "b", "c"})
    session.header.push_back({absl::StrCat("artefact_", axis, "_sigma_urad"), "50"});
  return session;
}

// Sixty columns whose faces stand out by a micrometre each, six times a touch's own scatter. The numbers scatter by
// what is stated of them: the published ones by the touches alone, the exact ones by the faces too; not told of the
// faces, the declared errors explain nothing.
TEST(IbarakiMaps, ErrorsOfTheArtefactAreInTheUncertainties) {
  const machine::Machine machine = TiltingTable();
  session::Session known = FewerElsewhere(), planned = known;
  planned.header.push_back({"feature_sigma_um", "1"});
  constexpr int kRuns = 60;
  double published = 0.0, exact = 0.0;
  int published_count = 0, exact_count = 0, explained = 0;
  for (int seed = 1; seed <= kRuns; ++seed) {
    synthetic::NoiseOptions noise;
    noise.seed = seed;
    session::Session session = synthetic::Simulate(machine, {}, planned, noise).value();
    const auto comparison = FindSource("ibaraki-maps").value()->compare(machine, {session});
    ASSERT_TRUE(comparison.ok()) << comparison.status();
    EXPECT_THAT(comparison->notes.back(), HasSubstr("each feature stands out by an unknown 1 um"));
    session.header = known.header;
    const auto untold = FindSource("ibaraki-maps").value()->compare(machine, {session});
    if (untold.ok() && std::isfinite(untold->rows[0].exact)) ++explained;
    for (const Row& row : comparison->rows) {
      if (row.formula != "eqs 6, 9" || row.quantity.ends_with(" at A 0 C 0")) continue;
      published += std::pow(row.published / row.published_sigma, 2);
      ++published_count;
      exact += std::pow(row.exact / row.sigma, 2);
      ++exact_count;
    }
  }
  EXPECT_NEAR(published / published_count, 1.0, 0.2);
  EXPECT_NEAR(exact / exact_count, 1.0, 0.25);  // some eight independent numbers per run: 6 %
  EXPECT_EQ(explained, 0);
}

// Columns that grow with the table's warmth: their expansion is taken off, and what its coefficient leaves open is in
// the published numbers too, as in sixty columns of other coefficients.
TEST(IbarakiMaps, ExpansionOfTheArtefactIsInTheUncertainties) {
  const machine::Machine machine = TiltingTable();
  session::Session planned = Columns();
  std::vector<double> celsius;
  const size_t readings = planned.reading_count();
  for (size_t k = 0; k < readings; ++k)
    celsius.push_back(20.0 + 6.0 * static_cast<double>(k) / static_cast<double>(readings));
  planned.columns.push_back({"temp_C", celsius, {}});
  const auto sigma_of = [&](const session::Session& session) {
    const Comparison comparison = FindSource("ibaraki-maps").value()->compare(machine, {session}).value();
    double sigma = NAN;
    for (const Row& row : comparison.rows)
      if (row.quantity == "dy at A -90 C 300") sigma = row.published_sigma;
    return sigma;
  };
  const double without = sigma_of(planned);
  planned.header.push_back({"expansion artefact", "11.5 3"});
  EXPECT_GT(sigma_of(planned), 1.3 * without);
  constexpr int kRuns = 60;
  double squares = 0.0;
  int count = 0;
  for (int seed = 1; seed <= kRuns; ++seed) {
    synthetic::NoiseOptions noise;
    noise.seed = seed;
    noise.draw_setup = false;
    noise.stated_seed = seed;
    const auto session = synthetic::Simulate(machine, {}, planned, noise);
    ASSERT_TRUE(session.ok()) << session.status();
    const auto comparison = FindSource("ibaraki-maps").value()->compare(machine, {*session});
    ASSERT_TRUE(comparison.ok()) << comparison.status();
    for (const Row& row : comparison->rows) {
      if (row.quantity != "dy at A -90 C 300") continue;
      squares += std::pow(row.published / row.published_sigma, 2);
      ++count;
    }
  }
  EXPECT_NEAR(squares / count, 1.0, 4.0 * std::sqrt(2.0 / kRuns));
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
