#include "core/predict/tool_point.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/base/units.h"
#include "core/compensate/compensator.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::predict {
namespace {

using base::kRadPerDeg;
using machine::Machine;

const Eigen::Vector3d kTip(0, 0, -350);

machine::KnownErrors Known(const std::string& text, const Machine& machine) {
  auto known = machine::ReadKnownErrors(text, machine);
  EXPECT_TRUE(known.ok()) << known.status();
  return *std::move(known);
}

// A state at rest at these positions, in the order of the machine.
std::vector<shapes::AxisState> At(const std::vector<double>& positions) {
  std::vector<shapes::AxisState> axes;
  for (const double position : positions) axes.push_back({position, 1.0, 3.0, 2.0});
  return axes;
}

ToolPointError Urads(double ex_um, double ey_um, double ez_um, double ea_urad, double eb_urad, double ec_urad) {
  ToolPointError error;
  error << ex_um * 1e-3, ey_um * 1e-3, ez_um * 1e-3, ea_urad * 1e-6, eb_urad * 1e-6, ec_urad * 1e-6;
  return error;
}

// The table stands 53.1 um to +X, so the tool stands 53.1 um to -X of the workpiece; a turn of -101.2 urad about X
// takes the tip, 350 mm below the axis B, 101.2e-6 x 350 mm = 35.42 um to -Y. A table that is turned by 90 deg sees the
// machine's -X as its +Y and the machine's -Y as its -X.
TEST(ToolPoint, IsWhatAReaderComputesByHand) {
  const Machine machine = machine::testing::MultiTasking();  // Z Y X B, then C carries the table
  const machine::KnownErrors errors = Known(R"({"EX0C": 53.1, "EA0B": -101.2})", machine);
  ToolPoint tool(machine, errors, kTip);
  constexpr double kToleranceMm = 1e-8;  // the turn's second order: (1e-4)^2 350 / 2 = 2e-6
  const auto home = At({20, 10, -300, 0, 0});
  EXPECT_NEAR((tool.ErrorAt({home}) - Urads(-53.1, -35.42, 0, -101.2, 0, 0)).head<2>().norm(), 0.0, kToleranceMm);
  EXPECT_NEAR(tool.ErrorAt({home})[2], 2e-6, 1e-6);
  EXPECT_NEAR((tool.ErrorAt({home}) - Urads(0, 0, 0, -101.2, 0, 0)).tail<3>().norm(), 0.0, 1e-14);
  const auto turned = At({20, 10, -300, 0, 90 * kRadPerDeg});
  EXPECT_NEAR((tool.ErrorAt({turned}) - Urads(-35.42, 53.1, 0, 0, 101.2, 0)).head<2>().norm(), 0.0, kToleranceMm);
  EXPECT_NEAR((tool.ErrorAt({turned}) - Urads(0, 0, 0, 0, 101.2, 0)).tail<3>().norm(), 0.0, 1e-14);
  EXPECT_TRUE(ToolPoint(machine, Known("{}", machine), kTip).ErrorAt({turned}).isZero(1e-12));
}

// 36 um in an hour, of which the readings saw a half: it stays there, and its sigma grows by as much as it would have
// gone on.
TEST(ToolPoint, ADriftStaysWhereItWasSeenLast) {
  const Machine machine = machine::testing::MultiTasking();
  const machine::KnownErrors errors = Known(
      R"({"terms": [{"symbol": "EZT", "shape": "drift", "amplitude": -36, "from_s": 0, "to_s": 1800}],
          "covariance": {"of": ["EZT:drift"], "sigma": [0.5], "correlation": [[]]}})",
      machine);
  EXPECT_EQ(std::get<shapes::Drift>(errors.model.terms[0].shape).to_s, 1800.0);
  ToolPoint tool(machine, errors, kTip);
  const auto home = At({20, 10, -300, 0, 0});
  EXPECT_NEAR(tool.ErrorAt({home, 900.0, 20.0})[2], -9e-3, 1e-6);
  EXPECT_NEAR(tool.SigmaAt({home, 900.0, 20.0})[2], 0.125e-3, 1e-6);
  EXPECT_NEAR(tool.ErrorAt({home, 5400.0, 20.0})[2], -18e-3, 1e-6);
  EXPECT_NEAR(tool.SigmaAt({home, 5400.0, 20.0})[2], std::hypot(36e-3, 0.25e-3), 1e-6);
}

// What the readings did not reach is as unknown as the prior, or as the warmth that was not seen.
TEST(ToolPoint, TheBandOpensBeyondWhatWasMeasured) {
  const Machine machine = machine::testing::MultiTasking();
  const machine::KnownErrors errors =
      Known(R"({"terms": [{"symbol": "EYX", "shape": "curve", "from_mm": -100, "to_mm": 100, "amplitudes": [2],
                           "prior_sigma": 5},
                          {"symbol": "EXT", "shape": "time-curve", "from_s": 0, "to_s": 100, "amplitudes": [1],
                           "prior_sigma": 3},
                          {"symbol": "EZT", "shape": "thermal-lag", "tau_s": 600, "amplitude": -2,
                           "from_celsius": 20, "to_celsius": 24}],
                "covariance": {"of": ["EYX:curve.1"], "sigma": [0.4], "correlation": [[]]}})",
            machine);
  ToolPoint tool(machine, errors, kTip);
  const double root3 = std::sqrt(3.0);
  const auto inside = At({20, 10, 100, 0, 0});  // Z, Y, X: at the end of the span
  shapes::State state{inside, 50.0, 23.0};
  EXPECT_NEAR(tool.ErrorAt(state)[1], 2e-3 * root3, 1e-7);
  EXPECT_NEAR(tool.ErrorAt(state)[2], -6e-3, 1e-6);
  EXPECT_NEAR(tool.SigmaAt(state)[1], 0.4e-3 * root3, 1e-7);
  EXPECT_NEAR(tool.SigmaAt(state)[0], 0.0, 1e-7);
  EXPECT_NEAR(tool.SigmaAt(state)[2], 0.0, 1e-7);
  const auto outside = At({20, 10, 125, 0, 0});
  state = {outside, 101.0, 29.0};
  const double kept = std::exp(-1.0);
  EXPECT_NEAR(tool.ErrorAt(state)[1], kept * 2e-3 * root3, 1e-7);
  EXPECT_NEAR(tool.SigmaAt(state)[1], std::hypot(kept * 0.4e-3 * root3, 5e-3 * std::sqrt(1.0 - kept * kept)), 1e-7);
  EXPECT_NEAR(tool.ErrorAt(state)[0], 0.0, 1e-7);  // a time curve foretells nothing
  EXPECT_NEAR(tool.SigmaAt(state)[0], 3e-3, 1e-7);
  EXPECT_NEAR(tool.ErrorAt(state)[2], -8e-3, 1e-6);  // as at 24 deg C, and 5 K more than was seen
  EXPECT_NEAR(tool.SigmaAt(state)[2], 10e-3, 1e-6);
}

TEST(ToolPoint, SigmaByHand) {
  const Machine machine = machine::testing::MultiTasking();
  const machine::KnownErrors errors =
      Known(R"({"EX0C": 53.1, "EA0B": -101.2, "EY0C": 1, "covariance": {"of": ["EX0C", "EA0B", "EY0C"],)"
            R"( "sigma": [2, 4, 1], "correlation": [[], [0], [0, 1]]}})",
            machine);
  ToolPoint tool(machine, errors, kTip);
  const auto home = At({20, 10, -300, 0, 0});
  const ToolPointError sigma = tool.SigmaAt({home});
  EXPECT_NEAR(sigma[0], 2e-3, 1e-9);
  // -350 mm x 4 urad = -1.4 um to -Y times -1 (a positive turn takes the tip to +Y), and -1 um of the table: ey moves
  // by +1.4 - 1 with the one number that both are.
  EXPECT_NEAR(sigma[1], 0.4e-3, 1e-7);
  EXPECT_NEAR(sigma[3], 4e-6, 1e-12);
  EXPECT_NEAR(sigma[4], 0.0, 1e-12);
  EXPECT_TRUE(TakenForExact(machine, errors).empty());
}

// Of all numbers that an error may have, on a machine whose table moves and turns.
TEST(ToolPoint, SigmaIsThatOfFiniteDifferencesOfTheChain) {
  const Machine machine = machine::testing::TiltingTable();
  const std::string errors = R"("EZ0A": 30, "EC0Y": -80, "EB0C": 40, "EX0T": 12, "EA0T": 33, "terms": [)"
                             R"({"symbol": "EAX", "shape": "linear", "amplitude": 50},)"
                             R"({"symbol": "EXA", "shape": "backlash", "amplitude": 6},)"
                             R"({"symbol": "ECC", "shape": "harmonic", "order": 3, "amplitude": 40, "phase_deg": 30},)"
                             R"({"symbol": "EYX", "shape": "reversal", "length_mm": 4, "amplitude": 5},)"
                             R"({"symbol": "EZT", "shape": "drift-exp", "tau_s": 900, "amplitude": 20},)"
                             R"({"symbol": "EBY", "shape": "thermal", "amplitude": 9}])";
  const std::vector<std::string> names = {"EZ0A",
                                          "EC0Y",
                                          "EB0C",
                                          "EA0T",
                                          "EAX:linear",
                                          "EXA:backlash",
                                          "ECC:harmonic(3).cos",
                                          "ECC:harmonic(3).sin",
                                          "ECC:harmonic(3).frequency",
                                          "EYX:reversal",
                                          "EYX:reversal.length",
                                          "EZT:drift-exp.tau",
                                          "EBY:thermal"};
  const auto axes = At({150, -80, 60, -0.6, 1.1});
  const shapes::State state{axes, 700.0, 23.0};
  for (const std::string& name : names) {
    const machine::KnownErrors known = Known(
        "{" + errors + R"(, "covariance": {"of": [")" + name + R"("], "sigma": [1], "correlation": [[]]}})", machine);
    ToolPoint tool(machine, known, kTip);
    const machine::ErrorCovariance::Number& number = known.covariance.of[0];
    const double unit = known.covariance.root(0, 0);
    const auto moved = [&](double by) {
      machine::KnownErrors other = known;
      machine::ErrorTerm& term = other.model.terms[number.term];
      if (auto* const harmonic = std::get_if<shapes::Harmonic>(&term.shape);
          harmonic != nullptr && number.is_nonlinear) {
        harmonic->frequency += by;
      } else if (number.is_nonlinear) {
        *shapes::NonlinearParameter(term.shape) += by;
      } else {
        term.amplitude[number.basis] += by;
      }
      return ToolPoint(machine, other, kTip).ErrorAt(state);
    };
    constexpr double kStep = 1e-2;  // of the unit
    const ToolPointError slope = (moved(kStep * unit) - moved(-kStep * unit)) / (2.0 * kStep);
    const ToolPointError sigma = tool.SigmaAt(state);
    EXPECT_GT(sigma.norm(), 1e-7) << name;
    for (int i = 0; i < 6; ++i) {
      // A tilt's finite difference is that of the rotation vector, which differs from the turn by its half: 1e-4.
      EXPECT_NEAR(sigma[i], std::abs(slope[i]), 2e-4 * sigma.head<3>().norm() + (i < 3 ? 1e-10 : 1e-12))
          << name << " " << i;
    }
  }
}

// Predicted error = minus what compensation adds to the commands, both as the tool point moves in the table's frame.
TEST(ToolPoint, IsMinusTheCorrection) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> anywhere(-1.0, 1.0);
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    const machine::KnownErrors errors = Known(
        R"({"EX0C": 53.1, "EA0C": -60, "EZ0T": 20, "EC0Y": 45, "terms": [)"
        R"({"symbol": "EXX", "shape": "linear", "amplitude": 30}, {"symbol": "EYC", "shape": "harmonic",)"
        R"( "order": 2, "amplitude": 9, "phase_deg": 70}, {"symbol": "EZX", "shape": "backlash", "amplitude": 4}]})",
        machine);
    const auto compensator = compensate::Compensator::Create(machine, errors.model, {kTip, {}, {}});
    ASSERT_TRUE(compensator.ok()) << compensator.status();
    ToolPoint tool(machine, errors, kTip);
    for (int draw = 0; draw < 20; ++draw) {
      compensate::Pose pose;
      std::vector<shapes::AxisState> axes;
      for (int i = 0; i < machine.axis_count(); ++i) {
        const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
        pose.position[i] = anywhere(random) * (is_rotary ? 1.5 : 300.0);
        pose.sense[i] = anywhere(random) > 0.0 ? 1.0 : -1.0;
        axes.push_back({pose.position[i], pose.sense[i]});
      }
      const auto correction = compensator->Correct(pose);
      ASSERT_TRUE(correction.ok()) << correction.status();
      Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();
      for (size_t k = 0; k < compensator->linear_axes().size(); ++k) {
        const int axis = compensator->linear_axes()[k];
        moved_mm += correction->tip_per_mm[k] * (correction->corrected[axis] - pose.position[axis]);
      }
      const ToolPointError error = tool.ErrorAt({axes});
      // The scale error is taken at the corrected command: 30e-6 x 0.1 mm; and the compensator's own tolerance.
      constexpr double kToleranceMm = 3e-6 + 1e-7;
      EXPECT_NEAR((error.head<3>() + moved_mm).norm(), 0.0, kToleranceMm) << machine.id << " " << draw;
      EXPECT_LE(correction->tilt_left_rad, error.tail<3>().norm() + 1e-9);
    }
  }
}

TEST(ToolPoint, SaysWhatIsTakenForExactAndWhatAColumnIsMissingFor) {
  const Machine machine = machine::testing::MultiTasking();
  const machine::KnownErrors errors =
      Known(R"({"EX0C": 53.1, "EY0C": 0, "terms": [{"symbol": "EXX", "shape": "lag", "amplitude": 2},)"
            R"({"symbol": "EZT", "shape": "thermal", "amplitude": 1}], "covariance": {"of": ["EZT:thermal"],)"
            R"( "sigma": [1], "correlation": [[]]}})",
            machine);
  EXPECT_THAT(TakenForExact(machine, errors), ::testing::ElementsAre("EX0C", "EXX:lag"));
  EXPECT_TRUE(RequireState(machine, errors.model, true, {"temp_C"}).ok());
  EXPECT_THAT(std::string(RequireState(machine, errors.model, false, {"temp_C"}).message()),
              "column t_s is missing: the error EXX:lag depends on the time");
  EXPECT_THAT(std::string(RequireState(machine, errors.model, true, {}).message()),
              "column temp_C is missing: the error EZT:thermal depends on the temperature");
}

}  // namespace
}  // namespace axiscal::predict
