// Figures of an R-test of one rotary axis, and of cones, in which rotary axes move while a ball bar goes round.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "core/base/units.h"
#include "core/figures/rotary_sessions.h"
#include "core/instruments/centres/centres_model.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/synthetic/simulate.h"

namespace axiscal::figures {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;

// Rotary positions in deg by axis, and where the tool point stands from the ball, table's frame.
struct Pose {
  std::map<std::string, double> rotary_deg;
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();
};

session::Session Planned(const machine::Machine& machine, const std::string& instrument, const std::vector<Pose>& poses,
                         const Eigen::Vector3d& ball_mm) {
  session::Session session;
  session.header = {{"machine", machine.id},
                    {"session", "s"},
                    {"instrument", instrument},
                    {"sigma_um", "0.2"},
                    {"tool_tip_mm", "0 0 -300"},
                    {"table_ball_mm", absl::StrFormat("%g %g %g", ball_mm.x(), ball_mm.y(), ball_mm.z())}};
  if (instrument == "ballbar") session.header.push_back({"bar_length_mm", "100"});
  session.columns = {{"t_s", {}, {}}};
  for (const machine::Axis& axis : machine.axes)
    session.columns.push_back({axis.name + (axis.kind == machine::AxisKind::kLinear ? "_mm" : "_deg"), {}, {}});
  for (size_t k = 0; k < poses.size(); ++k) {
    std::vector<double> at(machine.axes.size(), 0.0);
    for (const auto& [name, deg] : poses[k].rotary_deg)
      at[static_cast<size_t>(machine::FindAxis(machine, name))] = deg * base::kRadPerDeg;
    EXPECT_TRUE(centres::SolveNominalCommands(machine, {0, 0, -300}, ball_mm + poses[k].offset_mm, at.data()).ok());
    session.columns[0].values.push_back(static_cast<double>(k));
    for (size_t i = 0; i < at.size(); ++i) {
      const double unit = machine.axes[i].kind == machine::AxisKind::kRotary ? base::kDegPerRad : 1.0;
      session.columns[1 + i].values.push_back(std::round(at[i] * unit * 1e4) / 1e4);
    }
  }
  return session;
}

MeasuredTest TestOf(const machine::Machine& machine, const session::Session& planned, const std::string& errors) {
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  const auto session =
      synthetic::Simulate(machine, machine::ReadErrors(errors, machine).value(), planned, exact).value();
  const Figures figures = FiguresOf(machine, {instruments::BindSession(session, machine).value()});
  EXPECT_THAT(figures.left_out, SizeIs(0)) << figures.left_out.front();
  EXPECT_THAT(figures.tests, SizeIs(1));
  return figures.tests.front();
}

double Um(const MeasuredTest& test, const std::string& symbol) {
  for (const Figure& figure : test.figures)
    if (figure.symbol == symbol) return figure.value_mm * base::kUmPerMm;
  ADD_FAILURE() << test.what << " has no " << symbol;
  return NAN;
}

std::vector<Pose> ThereAndBack(const std::string& axis, double from_deg, double to_deg, int steps) {
  std::vector<Pose> poses;
  const auto add = [&](int k) { poses.emplace_back().rotary_deg[axis] = from_deg + (to_deg - from_deg) * k / steps; };
  for (int k = 0; k <= steps; ++k) add(k);
  for (int k = steps; k >= 0; --k) add(k);
  return poses;
}

constexpr double kRoundingUm = 0.15;  // of commands to 0.1 um, and second order

// A table whose angle is off by 50 urad cos C at a radius of 200 mm: 10 um tangentially, a range of 20.
TEST(Rotary, ATablesAngleIsTangential) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const session::Session planned = Planned(machine, "rtest", ThereAndBack("C", 0, 360, 72), {200, 0, 50});
  const MeasuredTest test =
      TestOf(machine, planned,
             R"({"terms": [{"symbol": "ECC", "shape": "harmonic", "order": 1, "amplitude": 50, "phase_deg": 0}]})");
  EXPECT_EQ(test.kind, "rotary");
  EXPECT_EQ(test.what, "R-test of C from 0 to 360 deg");
  EXPECT_NEAR(Um(test, "E tan"), 20.0, kRoundingUm);
  EXPECT_NEAR(Um(test, "E rad"), 0.0, kRoundingUm);
  EXPECT_NEAR(Um(test, "E ax"), 0.0, kRoundingUm);
  EXPECT_NEAR(Um(test, "E Y"), 20.0, kRoundingUm);  // the ball stands along the table's x
  EXPECT_NEAR(Um(test, "E X(up)"), 0.0, kRoundingUm);
}

// C stands 12 um beside its place: once round in the table's frame, a range of 24 radially and tangentially.
TEST(Rotary, AnOffsetAxisIsRadialAndTangential) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const MeasuredTest test =
      TestOf(machine, Planned(machine, "rtest", ThereAndBack("C", 0, 360, 72), {200, 0, 50}), R"({"EX0C": 12})");
  EXPECT_NEAR(Um(test, "E rad"), 24.0, kRoundingUm);
  EXPECT_NEAR(Um(test, "E tan(down)"), 24.0, kRoundingUm);
  EXPECT_NEAR(Um(test, "E ax"), 0.0, kRoundingUm);
}

// A head whose angle is off by 50 urad cos B, the tool point 300 mm below B: e = 15 um cos B along the way t that the
// tool point takes. Less its mean m, which lies along X (t . x = - cos B, and the readings are symmetric about B = 0),
// there is a radial part too: - m . r, r = (- sin B, 0, - cos B).
TEST(Rotary, AHeadsAngleIsTangentialBesideWhereTheBallWasMounted) {
  const machine::Machine machine = machine::testing::MultiTasking();
  constexpr int kSteps = 36;
  const MeasuredTest test =
      TestOf(machine, Planned(machine, "rtest", ThereAndBack("B", -90, 90, kSteps), {0, 0, 50}),
             R"({"terms": [{"symbol": "EBB", "shape": "harmonic", "order": 1, "amplitude": 50, "phase_deg": 0}]})");
  constexpr double kAmplitudeUm = 50e-3 * 300.0;
  double mean = 0.0;  // of cos^2 B
  for (int k = 0; k <= kSteps; ++k) mean += std::pow(std::sin(M_PI * k / kSteps), 2) / (kSteps + 1);
  EXPECT_EQ(test.what, "R-test of B from -90 to 90 deg");
  EXPECT_NEAR(Um(test, "E tan"), kAmplitudeUm * (1.0 - mean), kRoundingUm);
  EXPECT_NEAR(Um(test, "E rad"), kAmplitudeUm * 2.0 * mean, kRoundingUm);
  EXPECT_NEAR(Um(test, "E ax"), 0.0, kRoundingUm);
  EXPECT_NEAR(Um(test, "E Y"), 0.0, kRoundingUm);
}

// A head's axis that stands 12 um beside its place moves all readings alike: that is where the ball was mounted.
TEST(Rotary, AHeadBesideItsPlaceIsNotSeen) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const MeasuredTest test =
      TestOf(machine, Planned(machine, "rtest", ThereAndBack("B", -60, 90, 30), {0, 0, 50}), R"({"EX0B": 12})");
  for (const char* const symbol : {"E rad", "E tan", "E ax"}) EXPECT_NEAR(Um(test, symbol), 0.0, kRoundingUm) << symbol;
}

// The bar goes once round a cone about the table's z while C turns once. Seen from the bed it goes round twice, at
// azimuth 2 t. X, which Y carries, is out of square by 100 urad, which puts the tool 100 urad x too far in Y:
//   dL = 100 urad 100 mm sin^2(half angle) sin(2 t) cos(2 t), four periods, which no centre takes up.
TEST(Cone, OfSquarenessByHand) {
  const machine::Machine machine = machine::testing::MultiTasking();
  constexpr double kHalfDeg = 60.0, kBarMm = 100.0;
  const double across = std::sin(kHalfDeg * base::kRadPerDeg), along = std::cos(kHalfDeg * base::kRadPerDeg);
  for (const bool is_ccw : {true, false}) {
    std::vector<Pose> poses;
    for (int k = 0; k <= 180; ++k) {
      const double t_deg = is_ccw ? 2.0 * k : 360.0 - 2.0 * k, t = t_deg * base::kRadPerDeg;
      poses.push_back({{{"C", t_deg}}, kBarMm * Eigen::Vector3d(across * std::cos(t), across * std::sin(t), along)});
    }
    const MeasuredTest test = TestOf(machine, Planned(machine, "ballbar", poses, {0, 0, 50}), R"({"EC0X": 100})");
    EXPECT_EQ(test.kind, "cone");
    EXPECT_EQ(test.what, "cone of half angle 60 deg about (0.00 0.00 1.00), bar 100 mm");
    EXPECT_NEAR(Um(test, is_ccw ? "G ccw" : "G cw"), 100e-3 * kBarMm * across * across, kRoundingUm);
    EXPECT_THAT(test.notes, SizeIs(1));  // the other sense was not measured
  }
}

// 15 degrees of the cone's half angle to and fro: the bar follows no cone.
TEST(Cone, ABarThatNodsHasNoFigures) {
  const machine::Machine machine = machine::testing::MultiTasking();
  std::vector<Pose> poses;
  for (int k = 0; k <= 180; ++k) {
    const double t = 2.0 * k * base::kRadPerDeg, half = (60.0 + 15.0 * std::sin(3.0 * t)) * base::kRadPerDeg;
    poses.push_back(
        {{{"C", 2.0 * k}},
         100.0 * Eigen::Vector3d(std::sin(half) * std::cos(t), std::sin(half) * std::sin(t), std::cos(half))});
  }
  const auto session = synthetic::Simulate(machine, {}, Planned(machine, "ballbar", poses, {0, 0, 50}), {}).value();
  const Figures figures = FiguresOf(machine, {instruments::BindSession(session, machine).value()});
  EXPECT_THAT(figures.tests, SizeIs(0));
  ASSERT_THAT(figures.left_out, SizeIs(1));
  EXPECT_THAT(figures.left_out[0], HasSubstr("does not go round at a constant angle to an axis of the table"));
}

TEST(Rotary, ABallOnTheAxisHasNoRadialDirection) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const session::Session planned = Planned(machine, "rtest", ThereAndBack("C", 0, 360, 12), {0, 0, 50});
  const auto session = synthetic::Simulate(machine, {}, planned, {}).value();
  const Figures figures = FiguresOf(machine, {instruments::BindSession(session, machine).value()});
  ASSERT_THAT(figures.left_out, SizeIs(1));
  EXPECT_THAT(figures.left_out[0], HasSubstr("the ball stands on C"));
}

}  // namespace
}  // namespace axiscal::figures
