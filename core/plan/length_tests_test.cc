// Plans of length and direction instruments: simulated and identified, they give the errors that the machine has.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/machine/chain.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/plan/test.h"
#include "core/plan/testing/situations.h"
#include "core/synthetic/simulate.h"

namespace axiscal::plan {
namespace {

using ::testing::HasSubstr;

machine::Machine WithTravel() {
  machine::Machine machine = machine::testing::TiltingTable();  // Y under the table: tool and table move
  for (machine::Axis& axis : machine.axes) {
    if (axis.kind != machine::AxisKind::kLinear) continue;
    axis.min_position = -200.0;
    axis.max_position = 300.0;
  }
  return machine;
}

std::vector<PlannedSession> PlannedBy(const machine::Machine& machine, const std::string& test) {
  Mounted mounted;
  mounted.tips_mm = {{0, 0, -150}};
  return FindTest(test)->plan(SituationOfMachine(machine, mounted));
}

Eigen::Vector3d PointOf(const std::string& text) {
  Eigen::Vector3d point;
  std::istringstream(text) >> point.x() >> point.y() >> point.z();
  return point;
}

struct Counted {
  int held = 0, all = 0, within_three = 0;
};

// Simulates the sessions with these errors and identifies them again.
void AddFit(const machine::Machine& machine, const std::vector<PlannedSession>& planned, const std::string& errors,
            uint64_t seed, Counted* counted) {
  const machine::ErrorModel truth = *machine::ReadErrors(errors, machine);
  std::vector<session::Session> measured;
  for (const PlannedSession& one : planned) {
    synthetic::NoiseOptions noise;
    noise.seed = 100 * seed + measured.size();
    auto session = synthetic::Simulate(machine, truth, one.session, noise);
    ASSERT_TRUE(session.ok()) << session.status();
    measured.push_back(*std::move(session));
  }
  identify::Options options;
  options.model = truth;
  const auto result = identify::Identify(machine, measured, options);
  ASSERT_TRUE(result.ok()) << result.status();
  const std::vector<identify::Parameter> parameters = identify::ListParameters(truth, false);
  for (size_t i = 0; i < parameters.size(); ++i) {
    const identify::Estimate& estimate = result->estimates[i];
    ASSERT_TRUE(estimate.identifiable) << estimate.name;
    const double off = std::abs(estimate.value - identify::ValueOf(truth, parameters[i])) / estimate.sigma;
    ++counted->all;
    counted->held += off <= result->coverage_factor;
    counted->within_three += off <= 3.0;
  }
}

// 95 % intervals hold the truth in 95 % but for 3.5 binomial standard deviations; one in 370 is beyond three sigmas.
void ExpectHonest(const Counted& counted) {
  const double all = counted.all;
  EXPECT_GE(all, 60.0);
  EXPECT_NEAR(counted.held / all, 0.95, 3.5 * std::sqrt(0.95 * 0.05 / all));
  EXPECT_GE(counted.within_three / all, 1.0 - 1.0 / 370.0 - 3.5 * std::sqrt(1.0 / 370.0 / all));
}

void Expect(const std::string& test, size_t sessions, const std::string& errors) {
  const machine::Machine machine = WithTravel();
  const std::vector<PlannedSession> planned = PlannedBy(machine, test);
  ASSERT_EQ(planned.size(), sessions);
  Counted counted;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    AddFit(machine, planned, errors, seed, &counted);
    if (::testing::Test::HasFatalFailure()) return;
  }
  ExpectHonest(counted);
}

TEST(LengthTests, AnInterferometerTellsPositioning) {
  Expect("length-line", 3, R"({"terms": [{"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": 40},
      {"symbol": "EXX", "shape": "backlash", "variable": "X", "amplitude": 4},
      {"symbol": "EYY", "shape": "linear", "variable": "Y", "amplitude": -30},
      {"symbol": "EZZ", "shape": "quadratic", "variable": "Z", "amplitude": 9}]})");
}

TEST(LengthTests, StraightnessOpticsTellStraightness) {
  Expect("straightness-line", 6, R"({"terms": [
      {"symbol": "EYX", "shape": "quadratic", "variable": "X", "amplitude": 12},
      {"symbol": "EZY", "shape": "quadratic", "variable": "Y", "amplitude": -7},
      {"symbol": "EXZ", "shape": "quadratic", "variable": "Z", "amplitude": 5}]})");
}

TEST(LengthTests, AutocollimatorsTellTurns) {
  Expect("direction-line", 9, R"({"terms": [
      {"symbol": "EBX", "shape": "linear", "variable": "X", "amplitude": 60},
      {"symbol": "EAY", "shape": "quadratic", "variable": "Y", "amplitude": -25},
      {"symbol": "ECZ", "shape": "linear", "variable": "Z", "amplitude": 35}]})");
}

TEST(LengthTests, AnIndexingTableTellsAngles) {
  Expect("direction-turn", 2, R"({"terms": [
      {"symbol": "ECC", "shape": "harmonic", "variable": "C", "order": 1, "amplitude": 30, "phase_deg": 40},
      {"symbol": "EAA", "shape": "backlash", "variable": "A", "amplitude": 12}]})");
}

TEST(LengthTests, DistancesTellSquareness) {
  Expect("distance-grid", 3, R"({"EB0Z": 120, "EC0Y": -90,
      "terms": [{"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 200}]})");
}

// The tracker moves by a third of a mm and turns by as many mrad from look to look, as its set-up is drawn.
TEST(LengthTests, ATrackerThatMovesTellsScales) {
  Expect("tracker-references", 1, R"({"EB0Z": 120, "terms": [
      {"symbol": "EXX", "shape": "linear", "variable": "X", "amplitude": -150},
      {"symbol": "EZZ", "shape": "linear", "variable": "Z", "amplitude": 200}]})");
}

// Y moves the table: to the bed the tool never leaves y = 0, and targets there would stand in its way.
TEST(LengthTests, ReferencesStandBesideTheToolWhereTheTableMoves) {
  const machine::Machine machine = WithTravel();
  const std::vector<PlannedSession> planned = PlannedBy(machine, "tracker-references");
  ASSERT_EQ(planned.size(), 1u);
  for (const char* const name : {"reference R1", "reference R2", "reference R3"})
    EXPECT_GT(std::abs(PointOf(*session::FindHeader(planned[0].session, name)).y()), 150.0) << name;
}

// The targets' ends are nine tenths of the travel apart; L grows as the axis rises, whatever branch it stands on.
TEST(LengthTests, LinesGoOverTheTravelBothWays) {
  const machine::Machine machine = WithTravel();
  const std::vector<PlannedSession> planned = PlannedBy(machine, "length-line");
  const std::vector<double>& x_mm = session::FindColumn(planned[0].session, "X_mm")->values;
  ASSERT_EQ(x_mm.size(), 110u);
  EXPECT_EQ(x_mm.front(), -175.0);
  EXPECT_EQ(x_mm[10], 275.0);
  EXPECT_EQ(x_mm[11], 275.0);
  EXPECT_EQ(session::FindColumn(planned[0].session, "X_sense")->values[10], 1.0);
  EXPECT_EQ(session::FindColumn(planned[0].session, "X_sense")->values[11], -1.0);
  EXPECT_THAT(planned[0].text, HasSubstr("X from -175 to 275 mm, 11 targets, 5 times there and back"));
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  for (const PlannedSession& one : planned) {
    const auto session = synthetic::Simulate(machine, {}, one.session, exact);
    ASSERT_TRUE(session.ok()) << session.status();
    const std::vector<double>& read_mm = session::FindColumn(*session, "L_mm")->values;
    EXPECT_NEAR(read_mm[10] - read_mm[0], 450.0, 1e-9) << one.text;
  }
}

double LeastDistance(const Eigen::Vector3d& a_mm, const Eigen::Vector3d& b_mm, const Eigen::Vector3d& c_mm,
                     const Eigen::Vector3d& d_mm) {
  constexpr int kPoints = 100;
  double least_mm = INFINITY;
  for (int i = 0; i <= kPoints; ++i) {
    for (int k = 0; k <= kPoints; ++k) {
      const double s = i / double{kPoints}, t = k / double{kPoints};
      least_mm = std::min(least_mm, ((1 - s) * a_mm + s * b_mm - (1 - t) * c_mm - t * d_mm).norm());
    }
  }
  return least_mm;
}

// Its upper arm goes from (0, 0, -1110) to (0, 0, -660) at home and turns with the joints 1 and 2.
TEST(LengthTests, WiresToAnArmStayClearOfIt) {
  const machine::Machine machine = testing::Arm();
  const Situation situation = testing::NeverMeasured(machine);
  const std::vector<PlannedSession> planned = FindTest("distance-grid")->plan(situation);
  ASSERT_EQ(planned.size(), 3u);
  const Eigen::Vector3d tip_mm = situation.tips_mm.front();
  for (const PlannedSession& one : planned) {
    const Eigen::Vector3d anchor_mm = PointOf(*session::FindHeader(one.session, "anchor_mm"));
    EXPECT_EQ(session::FindHeader(one.session, "anchor_on"), "bed");
    ASSERT_EQ(one.session.reading_count(), 60);
    double shortest_mm = INFINITY, longest_mm = 0.0;
    for (int k = 0; k < 60; ++k) {
      std::vector<double> positions;
      for (const machine::Axis& axis : machine.axes) {
        const double deg = session::FindColumn(one.session, axis.name + "_deg")->values[static_cast<size_t>(k)];
        EXPECT_LE(std::abs(deg), 90.0) << axis.name;
        positions.push_back(deg * base::kRadPerDeg);
      }
      const auto chain = machine::EvaluateChain<double>(machine, positions.data(), machine::JointErrors<double>());
      const Eigen::Vector3d target_mm = chain.bed_from_tool * tip_mm;
      const Eigen::Vector3d base_mm(0, 0, -1510), shoulder_mm(0, 0, -1110);
      const Eigen::Vector3d elbow_mm =
          shoulder_mm + Eigen::AngleAxisd(positions[0], Eigen::Vector3d::UnitZ()) *
                            (Eigen::AngleAxisd(positions[1], -Eigen::Vector3d::UnitY()) * Eigen::Vector3d(0, 0, 450));
      EXPECT_GE(LeastDistance(shoulder_mm, elbow_mm, anchor_mm, target_mm), 99.9) << one.text << " pose " << k;
      EXPECT_GE(LeastDistance(base_mm, shoulder_mm, anchor_mm, target_mm), 99.9) << one.text << " pose " << k;
      shortest_mm = std::min(shortest_mm, (target_mm - anchor_mm).norm());
      longest_mm = std::max(longest_mm, (target_mm - anchor_mm).norm());
    }
    EXPECT_GE(shortest_mm, 200.0);
    EXPECT_THAT(one.text, HasSubstr(absl::StrFormat("lengths of %.0f to %.0f mm", shortest_mm, longest_mm)));
  }
}

TEST(LengthTests, WiresTellAnArmsErrors) {
  const machine::Machine machine = testing::Arm();
  const std::vector<PlannedSession> planned = FindTest("distance-grid")->plan(testing::NeverMeasured(machine));
  Counted counted;
  for (uint64_t seed = 1; seed <= 30; ++seed) {
    AddFit(machine, planned, R"({"EX0J3": 120, "EA0J3": -90, "EC0J4": 60, "terms": [
        {"symbol": "EBJ2", "shape": "backlash", "variable": "J2", "amplitude": 80}]})",
           seed, &counted);
    if (HasFatalFailure()) return;
  }
  ExpectHonest(counted);
}

// Where its joints have no room there are no poses.
TEST(LengthTests, AnArmThatCannotMoveHasNoWires) {
  machine::Machine machine = testing::Arm();
  for (machine::Axis& axis : machine.axes) axis.min_position = axis.max_position = 0.0;
  EXPECT_TRUE(FindTest("distance-grid")->plan(testing::NeverMeasured(machine)).empty());
}

}  // namespace
}  // namespace axiscal::plan
