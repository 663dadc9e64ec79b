// Jiang, Yao, Liu (running head Chang) 2019: the six errors that the paper reads from a coordinated X-C trace are three
// combinations; two traces at two heights tell all eight.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/instruments/evaluation.h"
#include "core/machine/error_json.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/chang_linked.h"
#include "tests/known_answers/published.h"

namespace axiscal::known_answers::linked {
namespace {

constexpr double kHeightMm = 100;
const char* const kXc[] = {"EX0C", "EY0C", "EA0C", "EB0C", "EB0X", "EC0X"};
const char* const kYc[] = {"EX0C", "EY0C", "EA0C", "EB0C", "EA0Y", "EC0Y"};

instruments::MeasuringRun Bound(char axis, double height_mm) {
  session::Session session = Planned(axis, height_mm, 1e-3);
  session.columns.push_back({"dL_mm", std::vector<double>(session.reading_count(), 0.0), {}});
  return instruments::BindSession(session, Machine()).value();
}

// The run with C and the linear axis exactly at t, not rounded to what a program holds.
instruments::MeasuringRun At(char axis, double t_deg) {
  instruments::MeasuringRun run = Bound(axis, kHeightMm);
  const double t = t_deg * base::kRadPerDeg;
  const double out_mm =
      kRadiusMm * std::cos(t) + std::sqrt(kBarMm * kBarMm - std::pow(kRadiusMm * std::sin(t), 2));  // 21
  std::fill_n(run.positions.begin(), run.axis_count, 0.0);
  run.positions[machine::FindAxis(Machine(), std::string(1, axis))] = out_mm - (kRadiusMm + kBarMm);
  run.positions[machine::FindAxis(Machine(), "C")] = t;
  return run;
}

Eigen::RowVectorXd Row(const instruments::MeasuringRun& run, int reading, const char* const (&symbols)[6]) {
  const double no_setup[6] = {};
  instruments::Evaluation evaluation;
  instruments::Evaluate(Machine(), run, reading, {}, no_setup, &evaluation);
  Eigen::RowVectorXd row(6);
  for (int i = 0; i < 6; ++i) {
    const machine::ErrorSymbol symbol = machine::ParseErrorSymbol(symbols[i]).value();
    row[i] = evaluation.by_error(
        0, machine::kComponents * machine::FindJoint(Machine(), symbol.axis) + static_cast<int>(symbol.component));
  }
  return row;
}

TEST(Chang, FirstOrderRows) {
  const double xc[] = {-0.816496581, -0.577350269, 57.735026917, -81.649658088, 81.649658088, 99.578191578};
  const double yc[] = {0.577350269, -0.816496581, 81.649658088, 57.735026917, -81.649658088, 99.578191578};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(Row(At('X', 60), 0, kXc)[i], xc[i], 1e-8) << kXc[i];
    EXPECT_NEAR(Row(At('Y', 60), 0, kYc)[i], yc[i], 1e-8) << kYc[i];
  }
}

machine::ErrorModel Table2() {
  return machine::ReadErrors(R"({"EX0C": 32.35, "EY0C": 47.69, "EA0C": -5.2, "EB0C": -1.6, "EB0X": 1.6, "EC0X": 21.6})",
                             Machine())
      .value();
}

// Table 2's XC column through the exact chain.
TEST(Chang, ExactLengths) {
  const double expected[][2] = {{0, -32.0239},   {45, -48.9054}, {90, -54.4033},
                                {180, -32.0226}, {270, 6.6665},  {300, -0.4592}};
  for (const auto& [t_deg, length_um] : expected) {
    const instruments::MeasuringRun run = At('X', t_deg);
    const double no_setup[6] = {};
    double dl_mm = NAN;
    instruments::Predict(Machine(), run, 0, machine::ErrorsAt(Machine(), Table2(), run.StateOf(0)), no_setup, &dl_mm);
    ExpectPublished(dl_mm * base::kUmPerMm, length_um, 1e-3,
                    absl::StrFormat("Chang 2019, Table 2, XC: dL at t = %g deg, um", t_deg));
  }
}

std::vector<session::Session> Exact(const std::vector<std::pair<char, double>>& tests, const machine::ErrorModel& truth,
                                    std::optional<double> mounted_sigma_um) {
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  std::vector<session::Session> sessions;
  for (const auto& [axis, height_mm] : tests)
    sessions.push_back(
        synthetic::Simulate(Machine(), truth, Planned(axis, height_mm, mounted_sigma_um), exact).value());
  return sessions;
}

identify::Result Identified(const std::vector<session::Session>& sessions, const std::vector<std::string>& symbols) {
  machine::Machine machine = Machine();
  machine.declared.clear();
  for (const std::string& symbol : symbols) machine.declared.push_back(machine::ParseErrorSymbol(symbol).value());
  return identify::Identify(machine, sessions).value();
}

const std::vector<std::string> kAllEight = {"EX0C", "EY0C", "EA0C", "EB0C", "EB0X", "EC0X", "EA0Y", "EC0Y"};
constexpr double kKnownUm = 1e-3;  // balls and bar as if they were where the header says

// The paper's own columns: six unknowns of each test, none of the other axis' tilt and squareness.
int RankOfPublishedColumns(const std::vector<double>& heights_mm) {
  std::vector<Eigen::RowVectorXd> rows;
  for (const double height_mm : heights_mm) {
    for (const char axis : {'X', 'Y'}) {
      const instruments::MeasuringRun run = Bound(axis, height_mm);
      for (int k = 0; k < run.reading_count(); k += 10) {
        const Eigen::RowVectorXd six = Row(run, k, axis == 'X' ? kXc : kYc);
        Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(8);
        row.head(4) = six.head(4);
        row.segment(axis == 'X' ? 4 : 6, 2) = six.tail(2);
        row.tail(6) /= kHeightMm;
        rows.push_back(row);
      }
    }
  }
  Eigen::MatrixXd all(rows.size(), 8);
  for (size_t k = 0; k < rows.size(); ++k) all.row(static_cast<Eigen::Index>(k)) = rows[k];
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(all);
  svd.setThreshold(1e-6);
  return static_cast<int>(svd.rank());
}

TEST(Chang, RanksOfThePublishedColumns) {
  EXPECT_EQ(RankOfPublishedColumns({100}), 6);
  EXPECT_EQ(RankOfPublishedColumns({100, 250}), 8);
}

TEST(Chang, OneTraceTellsThreeCombinations) {
  const identify::Result xc = Identified(Exact({{'X', 100}}, Table2(), kKnownUm), {std::begin(kXc), std::end(kXc)});
  EXPECT_EQ(xc.rank, 3);
  EXPECT_EQ(Identified(Exact({{'Y', 100}}, Table2(), kKnownUm), {std::begin(kYc), std::end(kYc)}).rank, 3);
  // No number for what it cannot tell, and the names of what it can.
  for (const identify::Estimate& estimate : xc.estimates) EXPECT_EQ(estimate.identifiable, estimate.name == "EC0X");
  EXPECT_EQ(xc.not_separable.size(), 3u);
  EXPECT_EQ(xc.determined.size(), 2u);
}

// On the machine X carries Y, so the tilt of either is in both traces, where only EB0C - EB0X and EA0C - EA0Y count:
// the published columns leave that out. A second height tells C's offsets from its tilts against the tool's side.
TEST(Chang, ASecondHeightTellsTheOffsetsFromTheTilts) {
  const machine::ErrorModel truth = Table2();
  const auto one_height = Exact({{'X', 100}, {'Y', 100}}, truth, kKnownUm);
  const auto two_heights = Exact({{'X', 100}, {'Y', 100}, {'X', 250}, {'Y', 250}}, truth, kKnownUm);
  EXPECT_EQ(Identified(one_height, kAllEight).rank, 4);
  const identify::Result eight = Identified(two_heights, kAllEight);
  EXPECT_EQ(eight.rank, 6);
  EXPECT_THAT(eight.not_separable, ::testing::UnorderedElementsAre("EB0C + EB0X", "EA0C + EA0Y"));
  const std::vector<std::string> six = {"EX0C", "EY0C", "EA0C", "EB0C", "EC0X", "EC0Y"};
  EXPECT_EQ(Identified(one_height, six).rank, 4);
  const identify::Result result = Identified(two_heights, six);
  EXPECT_EQ(result.rank, 6);
  const double expected[] = {32.35, 47.69, -5.2, -1.6 - 1.6, 21.6, 0.0};  // EB0C - EB0X
  for (int i = 0; i < 6; ++i) {
    constexpr double kSecondOrder = 2e-3;  // um, urad
    EXPECT_NEAR(result.estimates[i].value / result.estimates[i].factor, expected[i], kSecondOrder)
        << result.estimates[i].name;
  }
}

// Traces along X at 20 deg C and along Y at 23: the bar and the scale of Y have grown by the time. What the traces
// read is made by a longer bar and by an axis that goes too far.
std::vector<session::Session> Paired(const machine::ErrorModel& truth, double warmer_kelvin, bool is_stated) {
  constexpr double kBarPerKelvin = 11.5e-6, kScalePerKelvin = 10e-6;
  std::vector<session::Session> sessions;
  for (const double height_mm : {100.0, 250.0}) {
    sessions.push_back(Exact({{'X', height_mm}}, truth, kKnownUm)[0]);
    machine::ErrorModel warm = truth;
    const int y = machine::FindAxis(Machine(), "Y");
    warm.terms.push_back({y, machine::Component::kY, shapes::Linear{y}, {kScalePerKelvin * warmer_kelvin * 1e3}});
    sessions.push_back(Exact({{'Y', height_mm}}, warm, kKnownUm)[0]);
    for (session::Column& column : sessions.back().columns) {
      if (column.name != "dL_mm") continue;
      for (double& reading_mm : column.values) reading_mm -= kBarPerKelvin * warmer_kelvin * kBarMm;
    }
  }
  for (size_t i = 0; is_stated && i < sessions.size(); ++i) {
    const double celsius = i % 2 == 0 ? 20.0 : 20.0 + warmer_kelvin;
    sessions[i].columns.push_back({"temp_C", std::vector<double>(sessions[i].reading_count(), celsius), {}});
    const std::vector<session::HeaderEntry> facts = {
        {"expansion bar", "11.5 0.5"}, {"expansion scale X", "10 1"}, {"expansion scale Y", "10 1"}};
    sessions[i].header.insert(sessions[i].header.end(), facts.begin(), facts.end());
  }
  return sessions;
}

TEST(Chang, PairedTestsAtTwoTemperatures) {
  constexpr double kWarmer = 3.0;
  const std::vector<std::string> six = {"EX0C", "EY0C", "EA0C", "EB0C", "EC0X", "EC0Y"};
  const double expected[] = {32.35, 47.69, -5.2, -1.6 - 1.6, 21.6, 0.0};
  const identify::Result stated = Identified(Paired(Table2(), kWarmer, true), six),
                         cold = Identified(Paired(Table2(), 0.0, true), six),
                         unstated = Identified(Paired(Table2(), kWarmer, false), six);
  double worst_unstated = 0.0, more_sigma = 0.0;
  for (int i = 0; i < 6; ++i) {
    constexpr double kSecondOrder = 0.02;  // um, urad: of what has grown
    const identify::Estimate& estimate = stated.estimates[i];
    EXPECT_NEAR(estimate.value / estimate.factor, expected[i], kSecondOrder) << estimate.name;
    worst_unstated =
        std::max(worst_unstated, std::abs(unstated.estimates[i].value / unstated.estimates[i].factor - expected[i]));
    more_sigma = std::max(more_sigma, (estimate.sigma - cold.estimates[i].sigma) / estimate.factor);
  }
  EXPECT_GT(worst_unstated, 1.0);
  // 0.5 um/(m K) of 150 mm and 1 um/(m K) of 250 mm over 3 K: tenths of a micrometre that no repetition takes away.
  EXPECT_GT(more_sigma, 0.1);
}

// c1 = EX0C + h EB0C - h EB0X, c2 = EY0C - h EA0C, c3 = EC0X: what an X-C trace says.
TEST(Chang, TheThreeCombinationsComeBack) {
  const identify::Result result = Identified(Exact({{'X', 100}}, Table2(), kKnownUm), {"EX0C", "EY0C", "EC0X"});
  const double expected[] = {32.03, 48.21, 21.60};
  for (int i = 0; i < 3; ++i) {
    ExpectPublished(result.estimates[i].value / result.estimates[i].factor, expected[i], 0.01,
                    absl::StrFormat("Chang 2019, Table 2, XC: c%d, %s", i + 1, i < 2 ? "um" : "urad"));
  }
}

// Balls mounted by hand and the bar's length beside the three combinations: 5 of 8, two offsets and an angle look like
// a mounting.
TEST(Chang, TheMountingHidesTheCombinationsToo) {
  const instruments::MeasuringRun run = Bound('X', kHeightMm);
  Eigen::MatrixXd rows(run.reading_count(), 8);
  for (int k = 0; k < run.reading_count(); ++k) {
    const double no_setup[6] = {};
    instruments::Evaluation evaluation;
    instruments::Evaluate(Machine(), run, k, {}, no_setup, &evaluation);
    const Eigen::RowVectorXd errors = Row(run, k, kXc);
    rows.row(k) << errors[0], errors[1], errors[5] / kBarMm, evaluation.by_setup.leftCols<2>(),
        evaluation.by_setup.rightCols<3>();
  }
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows);
  svd.setThreshold(1e-6);  // the balls' heights stand still, commands are rounded to 0.1 um
  EXPECT_EQ(svd.rank(), 5);
}

// "Decoupled by the pseudo-inverse": the minimum-norm answer, which depends on the unit of angles.
TEST(Chang, ThePublishedSixDependOnTheirUnits) {
  const instruments::MeasuringRun run = Bound('X', kHeightMm);
  Eigen::MatrixXd rows(run.reading_count(), 6);
  for (int k = 0; k < run.reading_count(); ++k) rows.row(k) = Row(run, k, kXc);
  Eigen::VectorXd column(6);
  column << 32.35, 47.69, -5.2, -1.6, 1.6, 21.6;  // um, urad
  const double um_urad[] = {31.4, 47.7, -4.8, 3.1, -3.1, 21.6}, mm_rad[] = {0.0, 0.0, -482, 160, -160, 21.6};
  for (const double mm_per_length_unit : {1e-3, 1.0}) {
    // Readings and lengths in the unit of lengths, angles in urad or rad.
    Eigen::MatrixXd in_units = rows;
    const bool is_um = mm_per_length_unit == 1e-3;
    if (is_um) in_units.rightCols(4) *= 1e-3;  // um per urad
    Eigen::VectorXd truth = column;
    if (!is_um) truth.head(2) *= 1e-3;
    if (!is_um) truth.tail(4) *= 1e-6;
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(in_units, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(1e-6);
    Eigen::VectorXd answer = svd.solve(in_units * truth);
    if (!is_um) answer.head(2) *= 1e3;
    if (!is_um) answer.tail(4) *= 1e6;
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(answer[i], is_um ? um_urad[i] : mm_rad[i], (!is_um && i >= 2 && i < 5) ? 0.6 : 0.06) << kXc[i];
    }
    EXPECT_NEAR(answer[4], -answer[3], 1e-6);  // the mark that the published values carry
  }
}

// 26 with the printed sign of R: no bar is 150 mm.
TEST(Chang, ThePrintedStepsOfEquation26TearTheBar) {
  double largest_mm = 0.0;
  for (int k = 0; k < 360; ++k) {
    const double u = k * base::kRadPerDeg, y = kBarMm * std::sin(u), x = kBarMm * std::cos(u) - kRadiusMm;
    const double t = std::atan2(y, x), out_mm = std::hypot(x, y);
    const double bar_mm = std::hypot(out_mm - kRadiusMm * std::cos(t), kRadiusMm * std::sin(t));
    largest_mm = std::max(largest_mm, std::abs(bar_mm - kBarMm));
  }
  EXPECT_NEAR(largest_mm, 200.0, 1e-6);
}

}  // namespace
}  // namespace axiscal::known_answers::linked
