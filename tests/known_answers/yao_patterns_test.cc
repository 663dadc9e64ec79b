// The ball-bar patterns of Yao 2022 on our one engine: eccentricities of twelve patterns under each of thirteen
// deviations, and what sets of patterns can see. Formulas: chapters 2 and 4, signs corrected (README.md lists them).
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <map>

#include "core/identify/identify.h"
#include "core/instruments/ballbar/ballbar_plan.h"
#include "core/instruments/evaluation.h"
#include "core/machine/chain.h"
#include "tests/known_answers/published.h"
#include "tests/known_answers/yao_machine.h"

namespace axiscal::known_answers {
namespace {

using ballbar::Pattern;
using ballbar::PatternOptions;

constexpr double kOffsetMm = 0.020, kAngleRad = 0.005 * base::kRadPerDeg;
// Second order: 0.005 degrees squared at the machine's reach is 0.004 um; 0.02 is allowed.
constexpr double kToleranceUm = 0.02;

const machine::Machine kMachine = YaoMachine();

// The axis commands of a pattern as a measuring run.
instruments::MeasuringRun PlannedRun(Pattern pattern, const PatternOptions& options) {
  PatternOptions one_way = options;
  one_way.both_senses = false;
  session::Session session = ballbar::PlanPattern(kMachine, "run", pattern, one_way).value();
  session.columns.push_back({"dL_mm", std::vector<double>(session.reading_count(), 0.0), {}});
  return instruments::BindSession(session, kMachine).value();
}

machine::JointErrors<double> ErrorsOf(const Deviations& deviations) {
  return machine::ErrorsAt(kMachine, ModelOf(kMachine, deviations), {});
}

// The table ball is set against the tool ball at the start: W_C = M_CZ^-1 T(B = 0; pivot at (0, 0, Zc + R_B), with Rc
// along X for tests of C), as the offset from the nominal ball.
Eigen::Vector3d BallSetAgainstTool(const instruments::MeasuringRun& run, Pattern pattern, const PatternOptions& options,
                                   const machine::JointErrors<double>& errors) {
  std::vector<double> positions(kMachine.axis_count(), 0.0);
  positions[machine::FindAxis(kMachine, "X")] = ballbar::TurnsB(pattern) ? 0.0 : options.ball_radius_mm;
  positions[machine::FindAxis(kMachine, "Z")] = options.ball_height_mm + options.tool_length_mm;
  const auto pose = machine::EvaluateChain<double>(kMachine, positions.data(), errors);
  return machine::TipInTable(pose, run.tip_mm) - run.ball_mm;
}

// dL = r0 + e1 p1 + e2 p2 with a free radius; (p1, p2) = (sin p, cos p) for B, (cos q, sin q) for C. mm.
Eigen::Vector2d Eccentricity(Pattern pattern, const PatternOptions& options, const Deviations& deviations,
                             const Eigen::Vector3d& mounting_mm = Eigen::Vector3d::Zero()) {
  const instruments::MeasuringRun run = PlannedRun(pattern, options);
  const machine::JointErrors<double> errors = ErrorsOf(deviations);
  double setup[instruments::kMaxSetupParameters] = {};
  Eigen::Map<Eigen::Vector3d>(setup, 3) = BallSetAgainstTool(run, pattern, options, errors) + mounting_mm;
  const int axis = machine::FindAxis(kMachine, ballbar::TurnsB(pattern) ? "B" : "C");
  Eigen::MatrixX3d design(run.reading_count(), 3);
  Eigen::VectorXd length_mm(run.reading_count());
  for (int k = 0; k < run.reading_count(); ++k) {
    instruments::Predict(kMachine, run, k, errors, setup, &length_mm[k]);
    const double angle_rad = run.PositionsOf(k)[axis], s = std::sin(angle_rad), c = std::cos(angle_rad);
    design.row(k) << 1.0, ballbar::TurnsB(pattern) ? s : c, ballbar::TurnsB(pattern) ? c : s;
  }
  const Eigen::Vector3d solution = design.colPivHouseholderQr().solve(length_mm);
  return solution.tail<2>();
}

Deviations operator+(Deviations a, const Deviations& b) {
  for (const NamedDeviation& d : AllDeviations()) a.*d.member += b.*d.member;
  return a;
}
Deviations operator*(double factor, Deviations a) {
  for (const NamedDeviation& d : AllDeviations()) a.*d.member *= factor;
  return a;
}

struct FirstOrder {
  Deviations first, second;  // coefficients: mm per mm, mm per rad
};

// The corrected first-order table.
FirstOrder Published(Pattern pattern, const PatternOptions& o) {
  const double rb = o.tool_length_mm, zc = o.ball_height_mm, rc = o.ball_radius_mm;
  const Deviations cr = {.dxBT = -1, .bXB = rb, .bYZ = rb, .bCZ = zc, .dxCZ = 1};
  const Deviations ct = {.aBT = rb, .aXB = rb, .aYZ = rb, .aCZ = zc, .dyCZ = -1};
  switch (pattern) {
    case Pattern::kBX:
      return {{.dzBT = 1}, {.dxBT = 1, .bXB = -rb, .bYZ = -rb}};
    case Pattern::kBY:
    case Pattern::kBAxial:
      return {{.gXB = -rb}, {.aXB = rb, .aYZ = rb}};
    case Pattern::kBZ:
      return {{.dxBT = -1, .bXB = rb}, {.dzBT = 1}};
    case Pattern::kBRadial:
      return {{.dxBT = -1, .bXB = rb}, {.dzBT = -1}};
    case Pattern::kBTangential:
      return {{.dzBT = 1}, {.dxBT = -1, .bXB = rb}};
    case Pattern::kCR:
      return {cr, -1.0 * ct};
    case Pattern::kCT:
      return {ct, cr};
    case Pattern::kCA:
    case Pattern::kCZ:
      return {{.bYZ = -rc, .bCZ = rc}, {.aYZ = rc, .aCZ = -rc}};
    case Pattern::kCX:
      return {cr, ct + Deviations{.gXY = rc}};
    case Pattern::kCY:
      return {-1.0 * ct, cr};
  }
  return {};
}

// B radial and tangential under b_YZ are not in the table: the lever X runs with B and bends the trace.
bool IsTabulated(Pattern pattern, const std::string& deviation) {
  return deviation != "bYZ" || (pattern != Pattern::kBRadial && pattern != Pattern::kBTangential);
}

class YaoPatterns : public testing::TestWithParam<std::pair<std::string, Pattern>> {};

TEST_P(YaoPatterns, EccentricitiesAgreeWithTheFirstOrderTable) {
  PublishedTable rows("Yao 2022, Table 2.6 corrected: eccentricities of " + GetParam().first + ", um", kToleranceUm);
  for (const double tool_length_mm : {356.4, 406.4}) {
    PatternOptions options;
    options.tool_length_mm = tool_length_mm;
    const FirstOrder table = Published(GetParam().second, options);
    for (const NamedDeviation& deviation : AllDeviations()) {
      if (!IsTabulated(GetParam().second, deviation.name)) continue;
      const double size = deviation.name[0] == 'd' ? kOffsetMm : kAngleRad;
      Deviations one;
      one.*deviation.member = size;
      const Eigen::Vector2d ours_um = base::kUmPerMm * Eccentricity(GetParam().second, options, one);
      rows.Add(ours_um[0], base::kUmPerMm * size * (table.first.*deviation.member));
      rows.Add(ours_um[1], base::kUmPerMm * size * (table.second.*deviation.member));
    }
  }
}

// Table 2.6 prints six terms with the other sign: what its eccentricity is off by, beside ours.
TEST(YaoTable26, PrintedSignsMissByTwiceTheTerm) {
  const PatternOptions options;
  const double rb = options.tool_length_mm, zc = options.ball_height_mm;
  const struct {
    Pattern pattern;
    int component;
    double Deviations::*deviation;
    double printed;  // mm per mm, mm per rad
  } terms[] = {{Pattern::kBX, 1, &Deviations::bXB, rb},  {Pattern::kBZ, 0, &Deviations::dxBT, 1},
               {Pattern::kCR, 0, &Deviations::bCZ, -zc}, {Pattern::kCR, 1, &Deviations::aCZ, zc},
               {Pattern::kCT, 0, &Deviations::aCZ, -zc}, {Pattern::kCT, 1, &Deviations::bCZ, -zc}};
  for (const auto& term : terms) {
    const double size = term.deviation == &Deviations::dxBT ? kOffsetMm : kAngleRad;
    Deviations one;
    one.*term.deviation = size;
    const double ours_um = base::kUmPerMm * Eccentricity(term.pattern, options, one)[term.component];
    const double printed_um = base::kUmPerMm * size * term.printed;
    EXPECT_NEAR(ours_um, -printed_um, kToleranceUm);
    EXPECT_GT(std::abs(printed_um - ours_um), 10.0);  // 11 um of the tilts of C, 62 um of B's
  }
}

// The trace of b_YZ on B radial and tangential, by the same least squares from its closed first-order form. Beyond Y
// the tool ball stands at (x, z) = (L u_x, -R_B cos p), u the bar's direction; a turn b about Y moves it by b (z, -x),
// and at the start it moved the table ball by b (-R_B, 0):   dL = b ((z + R_B) u_x - x u_z).
TEST(YaoPatternsClosedForm, WhatTheTableLeavesOutIsTheChainsOwn) {
  PatternOptions options;
  const double length = options.bar_length_mm, rb = options.tool_length_mm;
  for (const Pattern pattern : {Pattern::kBRadial, Pattern::kBTangential}) {
    Eigen::MatrixX3d design(91, 3);
    Eigen::VectorXd expected_mm(91);
    for (int k = 0; k <= 90; ++k) {
      const double s = std::sin(k * base::kRadPerDeg), c = std::cos(k * base::kRadPerDeg);
      design.row(k) << 1.0, s, c;
      const bool is_radial = pattern == Pattern::kBRadial;
      const double ux = is_radial ? s : c, uz = is_radial ? c : -s;
      const double x = length * ux, z = -rb * c;
      expected_mm[k] = kAngleRad * ((z + rb) * ux - x * uz);
    }
    const Eigen::Vector3d expected = design.colPivHouseholderQr().solve(expected_mm);
    const Eigen::Vector2d ours = Eccentricity(pattern, options, {.bYZ = kAngleRad});
    EXPECT_NEAR(ours[0] * base::kUmPerMm, expected[1] * base::kUmPerMm, kToleranceUm);
    EXPECT_NEAR(ours[1] * base::kUmPerMm, expected[2] * base::kUmPerMm, kToleranceUm);
  }
}

TEST_P(YaoPatterns, MountingOfTheTableBall) {
  constexpr double kNothingUm = 1e-6, kMuchUm = 1.0;
  const std::map<Pattern, bool> moves = {
      {Pattern::kBRadial, true}, {Pattern::kBTangential, true}, {Pattern::kCX, true}, {Pattern::kCY, true}};
  const Deviations none;
  const Eigen::Vector2d still = Eccentricity(GetParam().second, {}, none);
  double largest_um = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d mounting_mm = kOffsetMm * Eigen::Vector3d::Unit(axis);
    const Eigen::Vector2d moved = Eccentricity(GetParam().second, {}, none, mounting_mm);
    largest_um = std::max(largest_um, base::kUmPerMm * (moved - still).cwiseAbs().maxCoeff());
  }
  if (moves.contains(GetParam().second)) {
    EXPECT_GT(largest_um, kMuchUm);
  } else {
    EXPECT_LT(largest_um, kNothingUm);
  }
}

INSTANTIATE_TEST_SUITE_P(All, YaoPatterns, testing::ValuesIn(ballbar::Patterns()), [](const auto& param) {
  std::string name = param.param.first;
  std::erase(name, '-');
  return name;
});

// Rows: eccentricities of patterns, columns: deviations, all rows in mm per 1 mm or 1 / 100 mm rad.
Eigen::MatrixXd EccentricityJacobian(const std::vector<std::pair<Pattern, double>>& patterns) {
  Eigen::MatrixXd jacobian(2 * patterns.size(), AllDeviations().size());
  for (size_t row = 0; row < patterns.size(); ++row) {
    PatternOptions options;
    options.tool_length_mm = patterns[row].second;
    options.step_deg = 5.0;
    for (size_t column = 0; column < AllDeviations().size(); ++column) {
      const double size = AllDeviations()[column].name[0] == 'd' ? 1e-3 : 1e-5;
      Deviations plus, minus;
      plus.*AllDeviations()[column].member = size;
      minus.*AllDeviations()[column].member = -size;
      jacobian.block<2, 1>(2 * row, column) =
          (Eccentricity(patterns[row].first, options, plus) - Eccentricity(patterns[row].first, options, minus)) / 2e-3;
    }
  }
  return jacobian;
}

int Rank(const std::vector<std::pair<Pattern, double>>& patterns) {
  Eigen::JacobiSVD<Eigen::MatrixXd> svd(EccentricityJacobian(patterns));
  svd.setThreshold(1e-6);
  return static_cast<int>(svd.rank());
}

std::vector<std::pair<Pattern, double>> OneTool() {
  return {{Pattern::kBX, 356.4}, {Pattern::kBY, 356.4}, {Pattern::kCR, 356.4}, {Pattern::kCA, 356.4}};
}
std::vector<std::pair<Pattern, double>> Measured() {
  auto patterns = OneTool();
  patterns.push_back({Pattern::kCR, 406.4});
  return patterns;
}
std::vector<std::pair<Pattern, double>> AllTwelveWithTwoTools() {
  std::vector<std::pair<Pattern, double>> patterns;
  for (const double tool_length_mm : {356.4, 406.4}) {
    for (const auto& [name, pattern] : ballbar::Patterns()) patterns.push_back({pattern, tool_length_mm});
  }
  return patterns;
}

TEST(YaoRanks, RanksOfTheEccentricities) {
  EXPECT_EQ(Rank(OneTool()), 8);
  EXPECT_EQ(Rank(Measured()), 10);
  EXPECT_EQ(Rank(AllTwelveWithTwoTools()), 12);
}

}  // namespace
}  // namespace axiscal::known_answers
