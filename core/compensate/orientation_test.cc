#include "core/compensate/orientation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <random>

#include "core/base/units.h"
#include "core/compensate/folded_chain.h"
#include "core/machine/testing/machines.h"

namespace axiscal::compensate {
namespace {

using base::kRadPerDeg;
using machine::ErrorModel;
using machine::FindAxis;
using machine::Machine;
using ::testing::HasSubstr;

constexpr double kBoundRad = 0.05 * kRadPerDeg;
constexpr double kPi = std::numbers::pi;
constexpr AxisValues kNothing{};

machine::ErrorTerm Term(const Machine& machine, const std::string& symbol, double amplitude) {
  return machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), amplitude);
}

Compensator MustCreate(const Machine& machine, const ErrorModel& errors) {
  Options options;
  options.tool_tip_mm = {3, -2, -180};
  auto compensator = Compensator::Create(machine, errors, options);
  EXPECT_TRUE(compensator.ok()) << compensator.status();
  return *std::move(compensator);
}

// By core/machine/chain.h alone.
struct Tool {
  Eigen::Vector3d tip_mm, direction;
};

Tool ToolAt(const Machine& machine, const ErrorModel& errors, const Pose& at) {
  std::array<shapes::AxisState, machine::kMaxAxes> axes;
  for (int i = 0; i < machine.axis_count(); ++i) {
    axes[i].position = at.position[i];
    axes[i].sense = at.sense[i];
  }
  shapes::State state;
  state.axes = {axes.data(), static_cast<size_t>(machine.axis_count())};
  const auto pose =
      machine::EvaluateChain<double>(machine, at.position.data(), machine::ErrorsAt(machine, errors, state));
  return {machine::TipInTable(pose, {3, -2, -180}), machine::ToolDirectionInTable(machine, pose)};
}

struct Corrected {
  Turned turned;
  Correction correction;
  Pose commanded;
};

Corrected Correct(const Compensator& compensator, const Pose& pose, double bound_rad = kBoundRad) {
  Corrected corrected;
  EXPECT_TRUE(CorrectDirection(compensator, pose, bound_rad, kNothing, &corrected.turned).ok());
  EXPECT_TRUE(compensator.CorrectTurned(pose, corrected.turned.position, kNothing, &corrected.correction).ok());
  corrected.commanded = pose;
  corrected.commanded.position = corrected.correction.corrected;
  return corrected;
}

double Angle(const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.cross(b).norm(); }

ErrorModel SomeErrors(const Machine& machine, std::mt19937* random, bool with_shapes) {
  std::uniform_real_distribution<double> unit(-1, 1);
  ErrorModel errors = machine::DeclaredModel(machine);
  for (auto& term : errors.terms) term.amplitude[0] = unit(*random) * (machine::IsAngle(term.component) ? 1e-4 : 0.1);
  if (!with_shapes) return errors;
  const int x = FindAxis(machine, "X"), c = FindAxis(machine, "C");
  machine::ErrorTerm pitch = Term(machine, "EC0C", 0);
  pitch.shape = shapes::Harmonic{c, 3.0};
  pitch.amplitude = {5e-5, -2e-5};
  machine::ErrorTerm roll = Term(machine, "EA0X", 0);
  roll.shape = shapes::Linear{x, shapes::Linear::kReferenceMm};
  roll.amplitude[0] = 1e-4;
  errors.terms.push_back(pitch);
  errors.terms.push_back(roll);
  return errors;
}

Pose RandomPose(const Machine& machine, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Pose pose;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kLinear) {
      pose.position[i] = 400.0 * unit(*random);
    } else if (machine.axes[i].name == "C") {
      pose.position[i] = 3.0 * 2 * kPi * unit(*random);  // several turns
    } else {
      // Through +-90, farther from the singular pose than the bound needs: 2e-4 rad of errors / 8.7e-4 rad = sin 14 deg
      const double deg = 20.0 + 100.0 * std::abs(unit(*random));
      pose.position[i] = (unit(*random) < 0 ? -deg : deg) * kRadPerDeg;
    }
  }
  return pose;
}

// Point and direction of the commanded pose, by the chain, are the programmed ones; and the branch is kept.
TEST(Orientation, AllThreeStructuresReachPointAndDirection) {
  std::mt19937 random(7);
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    for (const bool with_shapes : {false, true}) {
      for (int round = 0; round < 150; ++round) {
        const ErrorModel errors = SomeErrors(machine, &random, with_shapes);
        const Compensator compensator = MustCreate(machine, errors);
        const Pose pose = RandomPose(machine, &random);
        const Corrected corrected = Correct(compensator, pose, 0.2 * kRadPerDeg);
        const Tool wanted = ToolAt(machine, {}, pose), found = ToolAt(machine, errors, corrected.commanded);
        EXPECT_LT((found.tip_mm - wanted.tip_mm).norm(), kToleranceMm) << machine.id;
        EXPECT_LT(Angle(found.direction, wanted.direction), kDirectionToleranceRad) << machine.id;
        EXPECT_EQ(corrected.turned.limit, DirectionLimit::kNone) << machine.id;
        const Tool before = ToolAt(machine, errors, pose);
        EXPECT_NEAR(corrected.correction.before_mm, (before.tip_mm - wanted.tip_mm).norm(), 1e-9);
        EXPECT_NEAR(corrected.correction.tilt_before_rad, Angle(before.direction, wanted.direction), 1e-12);
        EXPECT_NEAR(corrected.correction.tilt_left_rad, Angle(found.direction, wanted.direction), 1e-10);
        for (int i = 0; i < machine.axis_count(); ++i) {
          const double turn = std::abs(corrected.commanded.position[i] - pose.position[i]);
          EXPECT_TRUE(machine.axes[i].kind == machine::AxisKind::kLinear || turn < 0.2 * kRadPerDeg);
        }
      }
    }
  }
}

// EB0B alone: B gives it back, exactly, and nothing else turns.
TEST(Orientation, KnownAnswerTiltAboutB) {
  const Machine machine = machine::testing::MultiTasking();
  const int b = FindAxis(machine, "B"), c = FindAxis(machine, "C");
  ErrorModel errors;
  errors.terms = {Term(machine, "EB0B", 1e-4)};
  const Compensator compensator = MustCreate(machine, errors);
  for (const double b_deg : {0.0, 45.0, 90.0, -90.0}) {
    Pose pose;
    pose.position[b] = b_deg * kRadPerDeg;
    pose.position[c] = 4 * kPi + 0.3;
    const Corrected corrected = Correct(compensator, pose);
    EXPECT_NEAR(corrected.commanded.position[b] - pose.position[b], -1e-4, 1e-12) << b_deg;
    EXPECT_NEAR(corrected.commanded.position[c], pose.position[c], 1e-9) << b_deg;
    EXPECT_NEAR(corrected.correction.tilt_before_rad, 1e-4, 1e-12);
  }
}

// A tilt of the head about the tool's travel X: only C can turn it away, and only where B is turned.
TEST(Orientation, NearTheSingularPoseTheTurnIsBoundedContinuousAndItsRestStated) {
  const Machine machine = machine::testing::MultiTasking();
  const int b = FindAxis(machine, "B"), c = FindAxis(machine, "C");
  constexpr double kTiltRad = 1e-4;
  ErrorModel errors;
  errors.terms = {Term(machine, "EA0B", kTiltRad)};
  const Compensator compensator = MustCreate(machine, errors);
  double last_turn = 0, largest_turn = 0;
  for (double b_deg = -20.0; b_deg <= 20.0; b_deg += 0.01) {
    Pose pose;
    pose.position[b] = b_deg * kRadPerDeg;
    const Corrected corrected = Correct(compensator, pose);
    const double turn = corrected.commanded.position[c];
    const double left = corrected.correction.tilt_left_rad;
    EXPECT_LE(std::abs(turn), kBoundRad);
    EXPECT_LE(left, kTiltRad * (1 + 1e-6));
    // No jump: over 0.01 deg of B the turn changes by what bound and width of the neighbourhood give, 6.6 deg.
    const double jump = b_deg > -20.0 ? std::abs(turn - last_turn) : 0.0;
    EXPECT_LT(jump, 4.0 * kBoundRad * 0.01 / 6.6) << b_deg;
    last_turn = turn;
    largest_turn = std::max(largest_turn, std::abs(turn));
    const double reach_rad = std::asin(kTiltRad / kBoundRad);
    if (std::abs(b_deg) * kRadPerDeg > 1.01 * reach_rad) {
      EXPECT_LT(left, kDirectionToleranceRad) << b_deg;
      EXPECT_EQ(corrected.turned.limit, DirectionLimit::kNone) << b_deg;
    } else if (std::abs(b_deg) * kRadPerDeg < 0.99 * reach_rad) {
      EXPECT_GT(left, 1e-7) << b_deg;
      EXPECT_NE(corrected.turned.limit, DirectionLimit::kNone) << b_deg;
    }
    const Tool wanted = ToolAt(machine, {}, pose), found = ToolAt(machine, errors, corrected.commanded);
    EXPECT_LT((found.tip_mm - wanted.tip_mm).norm(), kToleranceMm);
  }
  EXPECT_GT(largest_turn, 0.9 * kBoundRad);
  const Corrected at_pole = Correct(compensator, Pose());
  EXPECT_NEAR(at_pole.commanded.position[c], 0.0, 1e-9);
  EXPECT_NEAR(at_pole.correction.tilt_left_rad, kTiltRad, 1e-9);
  EXPECT_THAT(ToString(at_pole.turned, kBoundRad), HasSubstr("no rotary axis turns the tool that way"));
  Pose near;
  near.position[b] = 1.0 * kRadPerDeg;
  EXPECT_THAT(ToString(Correct(compensator, near).turned, kBoundRad), HasSubstr("the bound is 0.05 deg"));
}

// The bound holds wherever it is finite, and is small enough for the short moves of five-axis programs.
TEST(Orientation, TheDepartureBoundHolds) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  int finite[4] = {};
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    const int x = FindAxis(machine, "X"), c = FindAxis(machine, "C");
    for (int round = 0; round < 300; ++round) {
      // Constant; a harmonic and a linear term; quadratic; a map.
      ErrorModel errors = SomeErrors(machine, &random, round % 4 == 1);
      for (auto& term : errors.terms) {
        if (round % 4 == 2) term.shape = shapes::Quadratic{x};
        if (round % 4 == 3) term.shape = shapes::Tabulated{x, {40.0, 60.0, 80.0}, false, {}, c, {0.5, 0.5, 0.7}};
      }
      const Compensator compensator = MustCreate(machine, errors);
      const Pose from = RandomPose(machine, &random);
      Pose to = from, middle = from;
      const double size = std::pow(10.0, -3.0 * std::abs(unit(random)));
      for (int i = 0; i < machine.axis_count(); ++i) {
        const bool is_linear = machine.axes[i].kind == machine::AxisKind::kLinear;
        to.position[i] += unit(random) * size * (is_linear ? 100.0 : 0.3);
        middle.position[i] = 0.5 * (from.position[i] + to.position[i]);
      }
      constexpr double kWideRad = 0.05;
      const Corrected first = Correct(compensator, from, kWideRad), last = Correct(compensator, to, kWideRad),
                      half = Correct(compensator, middle, kWideRad);
      double direction_bound_rad = 0;
      const double bound_mm =
          compensator.TurnDepartureBound(from.position, to.position, last.turned.least_turn, &direction_bound_rad);
      if (!std::isfinite(bound_mm)) continue;
      ++finite[round % 4];
      Pose chord = middle;
      for (int i = 0; i < machine.axis_count(); ++i)
        chord.position[i] = 0.5 * (first.commanded.position[i] + last.commanded.position[i]);
      TurnColumns columns;
      compensator.Aim(half.commanded, &columns);
      Eigen::Vector3d point_mm = Eigen::Vector3d::Zero(), direction = Eigen::Vector3d::Zero();
      for (int i = 0; i < machine.axis_count(); ++i) {
        const double departure = chord.position[i] - half.commanded.position[i];
        if (machine.axes[i].kind == machine::AxisKind::kRotary) {
          point_mm += columns.tip_per_rad[i] * departure;
          direction += columns.direction_per_rad[i] * departure;
        }
      }
      for (size_t k = 0; k < compensator.linear_axes().size(); ++k) {
        const int axis = compensator.linear_axes()[k];
        point_mm += half.correction.tip_per_mm[k] * (chord.position[axis] - half.commanded.position[axis]);
      }
      EXPECT_LE(point_mm.norm(), bound_mm + 1e-9) << machine.id << ' ' << round;
      EXPECT_LE(direction.norm(), direction_bound_rad + 1e-11) << machine.id << ' ' << round;
      if (round % 4 < 2) {
        EXPECT_TRUE(size > 0.002 || bound_mm < 0.001) << bound_mm;
      }
    }
  }
  for (const int count : finite) EXPECT_GT(count, 100);
}

TEST(Orientation, OneRotaryAxisCorrectsItsShareAndTheRestIsLeft) {
  using namespace machine::testing;  // NOLINT
  const Machine machine =
      Make("four", {Linear("X", kX), Linear("Y", kY), Linear("Z", kZ), Rotary("B", kY, kOrigin)}, {}, {});
  ErrorModel errors;
  errors.terms = {Term(machine, "EA0B", 3e-5), Term(machine, "EB0B", 4e-5)};
  const Compensator compensator = MustCreate(machine, errors);
  Pose pose;
  const Corrected corrected = Correct(compensator, pose);
  EXPECT_NEAR(corrected.commanded.position[3], -4e-5, 1e-8);
  EXPECT_NEAR(corrected.correction.tilt_before_rad, 5e-5, 1e-8);
  EXPECT_NEAR(corrected.correction.tilt_left_rad, 3e-5, 1e-8);
  EXPECT_EQ(corrected.turned.limit, DirectionLimit::kNoAxis);
  const Tool wanted = ToolAt(machine, {}, pose), found = ToolAt(machine, errors, corrected.commanded);
  EXPECT_LT((found.tip_mm - wanted.tip_mm).norm(), kToleranceMm);
}

TEST(Orientation, AnAxisStopsAtTheEndOfItsTravel) {
  Machine machine = machine::testing::MultiTasking();
  const int b = FindAxis(machine, "B");
  machine.axes[static_cast<size_t>(b)].min_position = 0.0;
  ErrorModel errors;
  errors.terms = {Term(machine, "EB0B", 1e-4)};
  const Compensator compensator = MustCreate(machine, errors);
  const Corrected corrected = Correct(compensator, Pose());
  EXPECT_EQ(corrected.commanded.position[b], 0.0);
  EXPECT_NEAR(corrected.correction.tilt_left_rad, 1e-4, 1e-9);
  EXPECT_EQ(corrected.turned.limit, DirectionLimit::kTravel);
}

TEST(Orientation, BadInputIsNamed) {
  const Compensator compensator = MustCreate(machine::testing::MultiTasking(), {});
  Pose pose;
  pose.position[4] = std::nan("");
  Turned turned;
  EXPECT_THAT(std::string(CorrectDirection(compensator, pose, kBoundRad, kNothing, &turned).message()),
              HasSubstr("axis C = nan"));
}

}  // namespace
}  // namespace axiscal::compensate
