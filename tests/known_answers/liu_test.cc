// Liu, Li, Wang: static errors from sums of block coordinates, on a swivel head with a rotary table and on a double
// head. Sums are only the test that the engine agrees with the patterns; it takes every touch as a reading.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/liu_blocks.h"
#include "tests/known_answers/published.h"

namespace axiscal::known_answers::blocks {
namespace {

using base::kRadPerDeg;
using Eigen::Vector3d;

// Errors by symbol: mm and deg.
using Errors = std::map<std::string, double>;

machine::JointErrors<double> JointErrorsOf(const machine::Machine& machine, const Errors& errors) {
  machine::JointErrors<double> out;
  for (const auto& [text, value] : errors) {
    const machine::ErrorSymbol symbol = machine::ParseErrorSymbol(text).value();
    out[machine::FindJoint(machine, symbol.axis)][static_cast<int>(symbol.component)] =
        value * (machine::IsAngle(symbol.component) ? kRadPerDeg : 1.0);
  }
  return out;
}

std::vector<double> PositionsOf(const machine::Machine& machine, const Pattern& pattern) {
  std::vector<double> positions(machine.axis_count(), 0.0);
  for (const auto& [axis, deg] : pattern.rotary_deg) positions[machine::FindAxis(machine, axis)] = deg * kRadPerDeg;
  return positions;
}

// A head's sum by the exact chain: twice the displacement of the stylus centre along the pair.
double HeadSum(const machine::Machine& machine, double tool_mm, const Pattern& pattern, const Errors& errors) {
  const std::vector<double> positions = PositionsOf(machine, pattern);
  const Vector3d tip_mm(0, 0, -tool_mm);
  const Vector3d moved_mm =
      machine::EvaluateChain<double>(machine, positions.data(), JointErrorsOf(machine, errors)).bed_from_tool * tip_mm -
      machine::EvaluateChain<double>(machine, positions.data(), {}).bed_from_tool * tip_mm;
  return 2.0 * moved_mm[pattern.what == "x" ? 0 : 1];
}

// The table's sum of a pair's coordinates, or for tops the difference of their heights, at C = 0.
double TableSum(const Pattern& pattern, const Errors& errors) {
  const std::vector<double> positions = PositionsOf(SwivelHead(), pattern);
  const auto pose = machine::EvaluateChain<double>(SwivelHead(), positions.data(), JointErrorsOf(SwivelHead(), errors));
  constexpr double kZMm = 30;
  const Vector3d along = Vector3d::Unit(pattern.what[0] == 'x' ? 0 : 1);
  const Vector3d plus_mm = kPairMm * along + kZMm * Vector3d::UnitZ(), minus_mm = plus_mm - 2.0 * kPairMm * along;
  const Vector3d plus_moved_mm = pose.bed_from_table * plus_mm - plus_mm,
                 minus_moved_mm = pose.bed_from_table * minus_mm - minus_mm;
  if (pattern.what.size() > 1) return plus_moved_mm.z() - minus_moved_mm.z();
  return along.dot(plus_moved_mm + minus_moved_mm);
}

std::vector<double> HeadSums(const machine::Machine& machine, double tool_mm, const std::vector<Pattern>& patterns,
                             const Errors& errors) {
  std::vector<double> sums;
  for (const Pattern& pattern : patterns) sums.push_back(HeadSum(machine, tool_mm, pattern, errors));
  return sums;
}

// d(sum)/d(error) by the chain at zero: mm per mm, mm per rad.
Eigen::MatrixXd Coefficients(const machine::Machine& machine, double tool_mm, const std::vector<Pattern>& patterns,
                             const std::vector<std::string>& symbols) {
  Eigen::MatrixXd rows(patterns.size(), symbols.size());
  for (size_t i = 0; i < symbols.size(); ++i) {
    const bool is_angle = machine::IsAngle(machine::ParseErrorSymbol(symbols[i])->component);
    const double step = is_angle ? 1e-4 : 1e-3, unit = is_angle ? kRadPerDeg : 1.0;
    for (size_t k = 0; k < patterns.size(); ++k) {
      rows(k, i) = (HeadSum(machine, tool_mm, patterns[k], {{symbols[i], step}}) -
                    HeadSum(machine, tool_mm, patterns[k], {{symbols[i], -step}})) /
                   (2.0 * step * unit);
    }
  }
  return rows;
}

// Published formulas 3-1 to 3-5; order EX0B EY0B EA0B EB0B EC0B.
const std::vector<std::string> kHeadErrors = {"EX0B", "EY0B", "EA0B", "EB0B", "EC0B"};
Eigen::MatrixXd HeadFormulas(double l) {
  const double c = std::cos(30 * kRadPerDeg), s = std::sin(-30 * kRadPerDeg);
  Eigen::MatrixXd rows(5, 5);
  rows << 2, 0, 0, -2 * l, 0, 0, 2, 2 * l, 0, 0, 2, 0, 0, 0, 0, 0, 2, 0, 0, 2 * l, 0, 2, 2 * l * c, 0, -2 * l * s;
  return rows;
}

// 4-3 to 4-9; order EX0B EY0B EA0B EB0B EC0B EC0A EZ0A.
const std::vector<std::string> kDoubleErrors = {"EX0B", "EY0B", "EA0B", "EB0B", "EC0B", "EC0A", "EZ0A"};
Eigen::MatrixXd DoubleFormulas(double r) {
  const double c = std::cos(30 * kRadPerDeg), s = std::sin(30 * kRadPerDeg);
  Eigen::MatrixXd rows(7, 7);
  rows << 2, 0, 0, -2 * r, 0, 0, 0,  //
      0, 2, 2 * r, 0, 0, 0, 0,       //
      2, 0, 0, 0, 0, 0, -2,          //
      0, 2, 0, 0, 2 * r, 0, 0,       //
      2, 0, 0, 0, 2 * r, 2 * r, 0,   //
      0, 2, 0, 0, 0, 0, 0,           //
      2, 0, 0, -2 * r * c, 0, 0, -2 * s;
  return rows;
}

// The first data set (Tables 4-1 to 4-3): mm and deg.
const Errors kHead = {{"EA0B", 0.0150}, {"EB0B", -0.0100}, {"EC0B", 0.0200}, {"EX0B", 0.0300}, {"EY0B", 0.0250}};
const Errors kTable = {{"EA0C", 0.0150}, {"EB0C", -0.0100}, {"EX0C", 0.0300}, {"EY0C", 0.0250}};
Errors DoubleTruth() {
  Errors errors = kHead;
  errors["EC0A"] = 0.0120;
  errors["EZ0A"] = 0.0100;
  return errors;
}

Eigen::VectorXd Solved(const Eigen::MatrixXd& formulas, const std::vector<double>& sums) {
  return formulas.fullPivLu().solve(Eigen::VectorXd::Map(sums.data(), static_cast<Eigen::Index>(sums.size())));
}

TEST(LiuBlocks, TheHeadsCoefficientsAreThoseOfTheChain) {
  const Eigen::MatrixXd chain = Coefficients(SwivelHead(), kHeadMm, HeadPatterns(), kHeadErrors);
  EXPECT_LT((chain - HeadFormulas(kHeadMm)).cwiseAbs().maxCoeff(), 1e-6 * kHeadMm);
  Eigen::MatrixXd scaled = HeadFormulas(kHeadMm);
  scaled.rightCols(3) /= kHeadMm;
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
  ExpectPublished(values[0] / values[4], 13.7, 0.1, "Liu, head: condition of the coefficients, 1");
  // dy, a, g of 2-a, 2-c and 3: 1 - cos 30 - sin 30, in units of the coefficients 2 and 2 L.
  const Eigen::Matrix3d y_block = HeadFormulas(kHeadMm)({1, 3, 4}, {1, 2, 4}) / 2.0;
  ExpectPublished(std::abs(y_block.determinant()) / (kHeadMm * kHeadMm), 0.366, 5e-4,
                  "Liu, head: determinant of the y block, 1");
}

TEST(LiuBlocks, HeadSumsAndWhatTheLinearEquationsRecover) {
  const double expected[] = {0.130750062, 0.156125091, 0.059969129, 0.191481596, 0.212647823};
  const std::vector<double> sums = HeadSums(SwivelHead(), kHeadMm, HeadPatterns(), kHead);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(sums[i], expected[i], 1e-8) << i;
  const Eigen::VectorXd recovered = Solved(HeadFormulas(kHeadMm), sums);
  const double published[] = {0.029985, 0.025000, 0.015000, -0.010004, 0.019997};  // second order: 15 nm off in dx
  for (int i = 0; i < 5; ++i)
    ExpectPublished(recovered[i] * (i < 2 ? 1.0 : base::kDegPerRad), published[i], 1e-6,
                    absl::StrCat("Liu, head, linear equations: ", kHeadErrors[i], i < 2 ? ", mm" : ", deg"));
}

TEST(LiuBlocks, TableSumsAndThePrintedSignOf3_6) {
  const double sums[] = {TableSum({"xtop", {}}, kTable), TableSum({"y", {}}, kTable), TableSum({"x", {}}, kTable),
                         TableSum({"ytop", {}}, kTable)};
  const double expected[] = {0.010471975, 0.034292037, 0.049528025, 0.015707963};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(sums[i], expected[i], 1e-8) << i;
  constexpr double kZMm = 30, kPrinted = 5e-5;
  const double a = sums[3] / (2.0 * kPairMm), y = sums[1] / 2.0 + kZMm * a;
  ExpectPublished(a * base::kDegPerRad, 0.0150, kPrinted, "Liu, table: a, deg");
  ExpectPublished(y, 0.0250, kPrinted, "Liu, table: dy, mm");
  const double b = sums[0] / (-2.0 * kPairMm), x = sums[2] / 2.0 - kZMm * b;
  ExpectPublished(b * base::kDegPerRad, -0.0100, kPrinted, "Liu, table: b, the sign of 3-6 put right, deg");
  ExpectPublished(x, 0.0300, kPrinted, "Liu, table: dx, mm");
  // Printed with +: b comes out with the wrong sign, and dx 10.5 um off.
  const double b_printed = -b, x_printed = sums[2] / 2.0 - kZMm * b_printed;
  EXPECT_NEAR(b_printed * base::kDegPerRad, 0.0100, kPrinted);
  EXPECT_NEAR(x_printed, 0.0195, kPrinted);
}

// A pair that stands aside by e looks like dx = e at one angle of C; the mean of C and C + 180 does not see it.
TEST(LiuBlocks, AnAsymmetricPairLooksLikeAnOffsetAtOneAngle) {
  constexpr double kAsideMm = 0.02, kZMm = 30;
  const auto sum_mm = [&](double c_deg) {
    const std::vector<double> positions = PositionsOf(SwivelHead(), {"x", {{"C", c_deg}}});
    const auto pose =
        machine::EvaluateChain<double>(SwivelHead(), positions.data(), JointErrorsOf(SwivelHead(), kTable));
    return (pose.bed_from_table * Vector3d(kPairMm + kAsideMm, 0, kZMm)).x() +
           (pose.bed_from_table * Vector3d(-kPairMm + kAsideMm, 0, kZMm)).x();
  };
  const double published_mm = 0.049528025;  // 2 dx + 2 z b
  EXPECT_NEAR(sum_mm(0) - published_mm, 2.0 * kAsideMm, 1e-7);
  EXPECT_NEAR(sum_mm(180) - published_mm, -2.0 * kAsideMm, 1e-7);
  EXPECT_NEAR(0.5 * (sum_mm(0) + sum_mm(180)), published_mm, 1e-7);
}

TEST(LiuBlocks, DoubleHeadSumsAndWhatTheLinearEquationsRecover) {
  const Eigen::MatrixXd chain = Coefficients(DoubleHead(), kDoubleMm, DoubleHeadPatterns(), kDoubleErrors);
  EXPECT_LT((chain - DoubleFormulas(kDoubleMm)).cwiseAbs().maxCoeff(), 1e-6 * kDoubleMm);
  const double expected[] = {0.129809679, 0.154714516, 0.039969540, 0.189601075, 0.283398639, 0.050070847, 0.110441725};
  const std::vector<double> sums = HeadSums(DoubleHead(), kDoubleMm, DoubleHeadPatterns(), DoubleTruth());
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(sums[i], expected[i], 1e-8) << i;
  const Eigen::VectorXd recovered = Solved(DoubleFormulas(kDoubleMm), sums);
  const double published[] = {0.030000, 0.025035, 0.014989, -0.009999, 0.019986, 0.012013, 0.010015};
  for (int i = 0; i < 7; ++i) {
    const bool is_angle = i >= 2 && i < 6;
    ExpectPublished(
        recovered[i] * (is_angle ? base::kDegPerRad : 1.0), published[i], 1e-6,
        absl::StrCat("Liu, double head, linear equations: ", kDoubleErrors[i], is_angle ? ", deg" : ", mm"));
  }
}

// Columns that the double head's formulas leave out, and the rank with all twelve.
TEST(LiuBlocks, WhatTheDoubleHeadsFormulasLeaveOut) {
  const auto patterns = DoubleHeadPatterns();
  const Eigen::MatrixXd left_out =
      Coefficients(DoubleHead(), kDoubleMm, patterns, {"EX0A", "EY0A", "EB0A", "EA0A", "EZ0B"});
  Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(7, 5);
  const double c = std::cos(30 * kRadPerDeg);
  expected.col(0) << 2, 0, 0, 0, 2, 0, 2 * c;
  expected.col(1) << 0, 2, 0, 2, 0, 2, 0;
  expected.col(2) << -2 * kDoubleMm, 0, 0, 0, 0, 0, -2 * kDoubleMm * c;
  expected.col(3) << 0, 2 * kDoubleMm, 0, 2 * kDoubleMm, 0, 0, 0;
  EXPECT_LT((left_out - expected).cwiseAbs().maxCoeff(), 1e-6 * kDoubleMm) << left_out;  // EZ0B: no sum sees it
  Eigen::MatrixXd all(7, 12);
  all << DoubleFormulas(kDoubleMm), left_out;
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(all);
  EXPECT_EQ(svd.rank(), 7);
}

// Table 4-3 lists alpha_BA, dx_BA, dz_BZ, none of which is in 4-3 to 4-9: at their word the equations go wrong.
TEST(LiuBlocks, TheNamesOfTable4_3GoWrong) {
  Errors at_their_word = kHead;
  at_their_word["EA0A"] = 0.0120;
  at_their_word["EX0A"] = 0.0100;
  const Eigen::VectorXd recovered =
      Solved(DoubleFormulas(kDoubleMm), HeadSums(DoubleHead(), kDoubleMm, DoubleHeadPatterns(), at_their_word));
  constexpr double kPrinted = 1e-4;
  EXPECT_NEAR(recovered[2] * base::kDegPerRad, 0.0270, kPrinted);   // for 0.0150
  EXPECT_NEAR(recovered[5] * base::kDegPerRad, -0.0091, kPrinted);  // for 0.0120
  EXPECT_NEAR(recovered[6], 0.0000, kPrinted);                      // for 0.0100
}

// Equation 2-2 prints the error after B. Its own patterns need it before: they would be off by millimetres' hundredths.
TEST(LiuBlocks, TheErrorStandsBeforeB) {
  const auto errors = JointErrorsOf(SwivelHead(), kHead);
  const auto error = machine::ErrorTransform<double>(errors[machine::FindAxis(SwivelHead(), "B")], Vector3d::Zero());
  const Vector3d tip_mm(0, 0, -kHeadMm);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(-90 * kRadPerDeg, Vector3d::UnitY()).toRotationMatrix();
  const double before = 2.0 * (error * Vector3d(turn * tip_mm) - turn * tip_mm).x();
  const double after = 2.0 * (turn * (error * tip_mm) - turn * tip_mm).x();
  EXPECT_NEAR(before, 0.059969129, 1e-8);  // pattern 2-b
  EXPECT_GT(std::abs(after - before), 0.05);
}

// ---- the engine: every touch a reading ----

machine::ErrorModel ModelOf(const machine::Machine& machine, const Errors& errors) {
  machine::ErrorModel model;
  const machine::JointErrors<double> by_joint = JointErrorsOf(machine, errors);
  for (const auto& [text, value] : errors) {
    machine::ErrorTerm term = machine::ConstantTerm(machine, machine::ParseErrorSymbol(text).value());
    term.amplitude[0] = by_joint[term.joint][static_cast<int>(term.component)];
    model.terms.push_back(term);
  }
  return model;
}

session::Session Exact(const machine::Machine& machine, const session::Session& planned, const Errors& errors) {
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  const auto session = synthetic::Simulate(machine, ModelOf(machine, errors), planned, exact);
  EXPECT_TRUE(session.ok()) << session.status();
  return *session;
}

identify::Result Identified(const machine::Machine& machine, const session::Session& session,
                            const std::vector<std::string>& symbols) {
  identify::Options options;
  Errors zero;
  for (const std::string& symbol : symbols) zero[symbol] = 0.0;
  options.model = ModelOf(machine, zero);
  return identify::Identify(machine, {session}, options).value();
}

void ExpectTruth(const identify::Result& result, const Errors& truth) {
  ASSERT_EQ(result.estimates.size(), truth.size());
  for (const identify::Estimate& estimate : result.estimates) {
    const bool is_angle = estimate.unit == "urad";
    EXPECT_NEAR(estimate.value * (is_angle ? base::kDegPerRad : 1.0), truth.at(estimate.name), 1e-8) << estimate.name;
  }
}

constexpr double kKnownUm = 1e-3;

TEST(LiuBlocks, TouchesGiveTheHeadsErrors) {
  const session::Session touched =
      Exact(SwivelHead(), Touches(SwivelHead(), "head", kHeadMm, HeadPatterns(), kKnownUm), kHead);
  const identify::Result known = Identified(SwivelHead(), touched, kHeadErrors);
  EXPECT_EQ(known.rank, 5);
  ExpectTruth(known, kHead);
  // Where nobody knows where the cubes stand, the angles stay and the offsets go to the setup.
  session::Session by_hand = touched;
  by_hand.header = Touches(SwivelHead(), "head", kHeadMm, HeadPatterns(), std::nullopt).header;
  const identify::Result free = Identified(SwivelHead(), by_hand, kHeadErrors);
  EXPECT_EQ(free.rank, 5 - 2);
  for (const identify::Estimate& estimate : free.estimates)
    EXPECT_EQ(estimate.identifiable, estimate.unit == "urad") << estimate.name;
}

TEST(LiuBlocks, TouchesGiveTheDoubleHeadsErrors) {
  const session::Session touched =
      Exact(DoubleHead(), Touches(DoubleHead(), "double", kDoubleMm, DoubleHeadPatterns(), kKnownUm), DoubleTruth());
  const identify::Result known = Identified(DoubleHead(), touched, kDoubleErrors);
  EXPECT_EQ(known.rank, 7);
  ExpectTruth(known, DoubleTruth());
  std::vector<std::string> twelve = kDoubleErrors;
  twelve.insert(twelve.end(), {"EX0A", "EY0A", "EB0A", "EA0A", "EZ0B"});
  EXPECT_EQ(Identified(DoubleHead(), touched, twelve).rank, 7);
  session::Session by_hand = touched;
  by_hand.header = Touches(DoubleHead(), "double", kDoubleMm, DoubleHeadPatterns(), std::nullopt).header;
  const identify::Result free = Identified(DoubleHead(), by_hand, kDoubleErrors);
  EXPECT_EQ(free.rank, 7 - 2);
  for (const identify::Estimate& estimate : free.estimates)
    EXPECT_EQ(estimate.identifiable, estimate.name != "EX0B" && estimate.name != "EY0B") << estimate.name;
}

// A tool longer by 0.05 mm than stated looks like dx and b.
TEST(LiuBlocks, TheLengthOfTheToolIsNotSeparable) {
  Errors longer = kHead;
  longer["EZ0T"] = -0.05;
  const session::Session touched =
      Exact(SwivelHead(), Touches(SwivelHead(), "head", kHeadMm, HeadPatterns(), kKnownUm), longer);
  const identify::Result result = Identified(SwivelHead(), touched, kHeadErrors);
  for (const identify::Estimate& estimate : result.estimates) {
    const double off = estimate.value * (estimate.unit == "urad" ? base::kDegPerRad : 1.0) - kHead.at(estimate.name);
    const double expected = estimate.name == "EX0B" ? 0.05 : estimate.name == "EB0B" ? 0.01413 : 0.0;
    EXPECT_NEAR(off, expected, 2e-5) << estimate.name;
  }
  std::vector<std::string> with_length = kHeadErrors;
  with_length.push_back("EZ0T");
  EXPECT_EQ(Identified(SwivelHead(), touched, with_length).rank, 5);
}

// Head first, then the table with the head's errors as found; the cubes' own place free.
TEST(LiuBlocks, TheTablesErrorsOnceTheHeadsAreKnown) {
  Errors both = kHead;
  both.insert(kTable.begin(), kTable.end());
  const session::Session touched =
      Exact(SwivelHead(), Touches(SwivelHead(), "table", kHeadMm, TablePatterns(), std::nullopt), both);
  auto problem = identify::MakeProblem(SwivelHead(), identify::BindSessions(SwivelHead(), {touched}).value());
  ASSERT_TRUE(problem.ok()) << problem.status();
  problem->fixed_model = ModelOf(SwivelHead(), kHead);
  const auto fit = identify::FitProblem(
      *std::move(problem), ModelOf(SwivelHead(), {{"EA0C", 0}, {"EB0C", 0}, {"EX0C", 0}, {"EY0C", 0}}), {});
  ASSERT_TRUE(fit.ok()) << fit.status();
  EXPECT_EQ(fit->result.rank, 4);
  ExpectTruth(fit->result, kTable);
  // Together from the table's touches alone, the head's constants look like the table's.
  std::vector<std::string> nine = kHeadErrors;
  nine.insert(nine.end(), {"EX0C", "EY0C", "EA0C", "EB0C"});
  const identify::Result together = Identified(SwivelHead(), touched, nine);
  EXPECT_EQ(together.rank, 4);
  EXPECT_THAT(together.not_separable, ::testing::SizeIs(5));
  for (const identify::Estimate& estimate : together.estimates)
    EXPECT_EQ(estimate.identifiable, estimate.name == "EA0C" || estimate.name == "EB0C") << estimate.name;
}

// Latched positions show a table's displacement, and minus a head's: a stylus displaced by +d touches d earlier.
TEST(LiuBlocks, LatchedPositionsShowMinusTheHeadsDisplacement) {
  const auto latched_sum = [](const Errors& errors, const Pattern& pattern, std::optional<double> known) {
    const session::Session touched =
        Exact(SwivelHead(), Touches(SwivelHead(), "one", kHeadMm, {pattern}, known), errors);
    const session::Column& x = *session::FindColumn(touched, "X_mm");
    return (x.values[0] + x.values[1] + x.values[2] + x.values[3]) /
           2.0;  // X moves the table to -x: this is the tool's place over it
  };
  EXPECT_NEAR(latched_sum(kHead, {"x", {{"B", 0}}}, kKnownUm), -0.130750062, 1e-6);
  EXPECT_NEAR(latched_sum(kTable, {"x", {{"C", 0}}}, kKnownUm), 0.049528025, 1e-4);
}

}  // namespace
}  // namespace axiscal::known_answers::blocks
