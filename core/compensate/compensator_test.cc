#include "core/compensate/compensator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>
#include <random>

#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"

namespace axiscal::compensate {
namespace {

using base::kMmPerUm;
using base::kRadPerArcsec;
using base::kRadPerDeg;
using base::kRadPerUrad;
using base::kUmPerMm;
using machine::ErrorModel;
using machine::FindAxis;
using machine::Machine;
using ::testing::HasSubstr;

machine::ErrorTerm Term(const Machine& machine, const std::string& symbol, double amplitude) {
  return machine::ConstantTerm(machine, *machine::ParseErrorSymbol(symbol), amplitude);
}

Compensator MustCreate(const Machine& machine, const ErrorModel& errors, const Options& options) {
  auto compensator = Compensator::Create(machine, errors, options);
  EXPECT_TRUE(compensator.ok()) << compensator.status();
  return *std::move(compensator);
}

// The tool point by core/machine/chain.h alone, nominal machine or with errors.
Eigen::Vector3d Tip(const Machine& machine, const ErrorModel& errors, const Options& options, const Pose& at) {
  std::array<shapes::AxisState, machine::kMaxAxes> axes;
  for (int i = 0; i < machine.axis_count(); ++i) {
    axes[i].position = at.position[i];
    axes[i].sense = at.sense[i];
  }
  shapes::State state;
  state.axes = {axes.data(), static_cast<size_t>(machine.axis_count())};
  if (options.time_s) state.time_s = *options.time_s;
  if (options.temperature_celsius) state.temperature_celsius = *options.temperature_celsius;
  return machine::TipInTable(
      machine::EvaluateChain<double>(machine, at.position.data(), machine::ErrorsAt(machine, errors, state)),
      options.tool_tip_mm);
}

TEST(Compensator, APerfectMachineNeedsNoCorrection) {
  const Machine machine = machine::testing::MultiTasking();
  const Compensator compensator =
      MustCreate(machine, machine::DeclaredModel(machine), {Eigen::Vector3d(0, 0, -350), {}, {}});
  EXPECT_TRUE(compensator.is_null());
  Pose pose;
  pose.position = {1, 2, 3, 0.5, 0.7};
  const auto correction = compensator.Correct(pose);
  ASSERT_TRUE(correction.ok()) << correction.status();
  for (int i = 0; i < 5; ++i) EXPECT_EQ(correction->corrected[i], pose.position[i]);
  EXPECT_EQ(correction->before_mm, 0.0);
  EXPECT_EQ(correction->tilt_left_rad, 0.0);
}

// Yao 2022, Table 4.5: bXB = 24.11 arcsec in the model's sign, R_B = 356.3945 mm.
TEST(Compensator, KnownAnswerTiltOfTheHeadAboutB) {
  constexpr double kToleranceUm = 0.005;  // digits of the known answer, and second order: 0.0417^2 / 2 / 356 = 2e-6 mm
  const Machine machine = machine::testing::MultiTasking();
  Options options;
  options.tool_tip_mm = {0, 0, -356.3945};
  ErrorModel errors;
  errors.terms.push_back(Term(machine, "EB0B", 24.11 * kRadPerArcsec));
  const Compensator compensator = MustCreate(machine, errors, options);
  const int x = FindAxis(machine, "X"), y = FindAxis(machine, "Y"), z = FindAxis(machine, "Z"),
            b = FindAxis(machine, "B");
  struct Known {
    double b_deg, dx_um, dz_um;
  };
  for (const Known& known : {Known{0, 41.66, 0}, Known{45, 29.46, -29.46}, Known{90, 0, -41.66}}) {
    Pose pose;
    pose.position[x] = -390.0;
    pose.position[z] = -112.2605;
    pose.position[b] = known.b_deg * kRadPerDeg;
    const auto correction = compensator.Correct(pose);
    ASSERT_TRUE(correction.ok()) << correction.status();
    EXPECT_NEAR((correction->corrected[x] - pose.position[x]) * kUmPerMm, known.dx_um, kToleranceUm) << known.b_deg;
    EXPECT_NEAR((correction->corrected[y] - pose.position[y]) * kUmPerMm, 0.0, kToleranceUm);
    EXPECT_NEAR((correction->corrected[z] - pose.position[z]) * kUmPerMm, known.dz_um, kToleranceUm) << known.b_deg;
    EXPECT_EQ(correction->corrected[b], pose.position[b]);
    EXPECT_NEAR(correction->before_mm * kUmPerMm, 41.66, kToleranceUm);
    EXPECT_LE(correction->after_mm, kToleranceMm);
    EXPECT_NEAR(correction->tilt_left_rad, 24.11 * kRadPerArcsec, 1e-10);
  }
}

// Every declared error at once, 50 to 200 um and urad, over the whole working space of each structure.
TEST(Compensator, ConstantErrorsOfAllThreeStructuresAreTakenOutByTheChainItself) {
  std::mt19937 random(20);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    ErrorModel errors = machine::DeclaredModel(machine);
    for (auto& term : errors.terms) {
      const double size = unit(random) * 200;
      term.amplitude[0] = size * (machine::IsAngle(term.component) ? kRadPerUrad : kMmPerUm);
    }
    errors.terms.push_back(Term(machine, "EZ0W", 0.05));
    Options options;
    options.tool_tip_mm = {3, -2, -180};
    const Compensator compensator = MustCreate(machine, errors, options);
    for (int i = 0; i < 200; ++i) {
      Pose pose;
      for (int axis = 0; axis < machine.axis_count(); ++axis) {
        const bool is_linear = machine.axes[axis].kind == machine::AxisKind::kLinear;
        pose.position[axis] = unit(random) * (is_linear ? 500.0 : std::numbers::pi);
      }
      const auto correction = compensator.Correct(pose);
      ASSERT_TRUE(correction.ok()) << correction.status();
      Pose commanded = pose;
      commanded.position = correction->corrected;
      const Eigen::Vector3d wanted = Tip(machine, {}, options, pose);
      EXPECT_LT((Tip(machine, errors, options, commanded) - wanted).norm(), 1e-10) << machine.id;
      EXPECT_NEAR(correction->before_mm, (Tip(machine, errors, options, pose) - wanted).norm(), 1e-10);
      // Rounding a command moves the tool as tip_per_mm says.
      const int first = compensator.linear_axes()[0];
      Pose rounded = commanded;
      rounded.position[first] += 0.01;
      EXPECT_LT((Tip(machine, errors, options, rounded) - wanted - 0.01 * correction->tip_per_mm[0]).norm(), 1e-10);
    }
  }
}

// Constant errors have a closed form; with a vanishing error that varies the chain is stepped through instead.
TEST(Compensator, TheClosedFormIsTheChain) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::SwivelHead(), machine::testing::TiltingTable()}) {
    const Options options{Eigen::Vector3d(20, -30, -350), {}, {}};
    ErrorModel errors = machine::DeclaredModel(machine);
    for (auto& term : errors.terms) term.amplitude[0] = share(random) * (machine::IsAngle(term.component) ? 1e-3 : 0.1);
    const Compensator closed = MustCreate(machine, errors, options);
    for (int joint = 0; joint < machine.axis_count(); ++joint) {
      machine::ErrorTerm vanishing{
          joint, machine::Component::kX, shapes::Linear{0, shapes::Linear::kReferenceMm}, {1e-15}};
      errors.terms.push_back(vanishing);
    }
    const Compensator stepped = MustCreate(machine, errors, options);
    ASSERT_TRUE(closed.is_constant());
    ASSERT_FALSE(stepped.is_constant());
    for (int i = 0; i < 200; ++i) {
      Pose pose;
      for (int axis = 0; axis < machine.axis_count(); ++axis) {
        const bool is_rotary = machine.axes[axis].kind == machine::AxisKind::kRotary;
        pose.position[axis] = share(random) * (is_rotary ? std::numbers::pi : 500.0);
      }
      const auto by_form = closed.Correct(pose), by_chain = stepped.Correct(pose);
      ASSERT_TRUE(by_form.ok() && by_chain.ok());
      constexpr double kRoundOffMm = 1e-9, kRoundOffRad = 1e-12;
      for (const int axis : closed.linear_axes())
        EXPECT_NEAR(by_form->corrected[axis], by_chain->corrected[axis], kRoundOffMm);
      for (size_t k = 0; k < closed.linear_axes().size(); ++k)
        EXPECT_LT((by_form->tip_per_mm[k] - by_chain->tip_per_mm[k]).norm(), kRoundOffRad);
      EXPECT_NEAR(by_form->before_mm, by_chain->before_mm, kRoundOffMm);
      EXPECT_LT(by_form->after_mm, kRoundOffMm);
      EXPECT_NEAR(by_form->tilt_left_rad, by_chain->tilt_left_rad, kRoundOffRad);
    }
  }
}

TEST(Compensator, LargeErrorsNeedTheWholeInverse) {
  constexpr double kTiltRad = 0.05;  // 3 degrees: one linearised step would leave 0.4 mm
  const Machine machine = machine::testing::TiltingTable();
  ErrorModel errors;
  errors.terms = {Term(machine, "EB0A", kTiltRad), Term(machine, "EX0C", 2.0), Term(machine, "EC0Y", -kTiltRad)};
  machine::ErrorTerm scale = Term(machine, "EX0X", 0);
  scale.shape = shapes::Linear{FindAxis(machine, "X"), shapes::Linear::kReferenceMm};
  scale.amplitude[0] = 20.0;  // 2 percent
  errors.terms.push_back(scale);
  Options options;
  options.tool_tip_mm = {0, 0, -200};
  const Compensator compensator = MustCreate(machine, errors, options);
  Pose pose;
  pose.position = {300, -100, 200, 1.0, -2.0};
  const auto correction = compensator.Correct(pose);
  ASSERT_TRUE(correction.ok()) << correction.status();
  Pose commanded = pose;
  commanded.position = correction->corrected;
  EXPECT_LT((Tip(machine, errors, options, commanded) - Tip(machine, {}, options, pose)).norm(), kToleranceMm);
  EXPECT_GT(correction->before_mm, 5.0);
}

TEST(Compensator, BacklashFollowsTheSenseAndHarmonicsThePosition) {
  const Machine machine = machine::testing::MultiTasking();
  const int x = FindAxis(machine, "X"), b = FindAxis(machine, "B");
  machine::ErrorTerm backlash = Term(machine, "EX0X", 0);
  backlash.shape = shapes::Backlash{x};
  backlash.amplitude[0] = 0.010;  // peak to peak: 5 um each way
  ErrorModel errors;
  errors.terms = {backlash};
  const Compensator reversing = MustCreate(machine, errors, {});
  EXPECT_TRUE(reversing.uses_sense(x));
  EXPECT_FALSE(reversing.uses_sense(b));
  Pose pose;
  for (const double sense : {-1.0, 0.0, 1.0}) {
    pose.sense[x] = sense;
    EXPECT_NEAR(reversing.Correct(pose)->corrected[x], -0.005 * sense, 1e-9);
  }

  machine::ErrorTerm harmonic = Term(machine, "EZ0B", 0);
  harmonic.shape = shapes::Harmonic{b, 2.0};
  harmonic.amplitude = {0.02, 0.0};
  errors.terms = {backlash, harmonic};
  const Compensator both = MustCreate(machine, errors, {});
  pose.position[b] = std::numbers::pi / 2;  // cos(2 B) = -1: the point stands 20 um low
  const auto correction = both.Correct(pose);
  ASSERT_TRUE(correction.ok());
  EXPECT_NEAR(correction->corrected[FindAxis(machine, "Z")], 0.020, 1e-9);
  EXPECT_NEAR(correction->corrected[x], -0.005, 1e-9);
}

TEST(Compensator, WhatAProgramCannotCarryIsListedUnlessItsArgumentIsStated) {
  const Machine machine = machine::testing::MultiTasking();
  ErrorModel errors;
  machine::ErrorTerm thermal = Term(machine, "EZ0T", 0);
  thermal.shape = shapes::Thermal{};
  thermal.amplitude[0] = 0.003;
  errors.terms = {thermal};
  Options options;
  const Compensator cold = MustCreate(machine, errors, options);
  EXPECT_TRUE(cold.is_null());
  ASSERT_EQ(cold.not_carried().size(), 1u);
  EXPECT_THAT(cold.not_carried()[0], HasSubstr("no temperature is stated"));
  options.temperature_celsius = 30.0;
  const Compensator warm = MustCreate(machine, errors, options);
  EXPECT_TRUE(warm.not_carried().empty());
  EXPECT_NEAR(warm.Correct(Pose())->corrected[FindAxis(machine, "Z")], -0.030, 1e-9);
}

TEST(Compensator, AMachineThatCannotReachThreeDirectionsIsAnError) {
  using machine::testing::kX;
  using machine::testing::kY;
  using machine::testing::kZ;
  const Machine two = machine::testing::Make("two",
                                             {machine::testing::Linear("X", kX), machine::testing::Linear("Z", kZ),
                                              machine::testing::Rotary("B", kY, {0, 0, 0})},
                                             {}, {});
  ErrorModel errors;
  errors.terms = {Term(two, "EA0B", 1e-4)};
  const Compensator compensator = MustCreate(two, errors, {});
  const absl::Status status = compensator.Correct(Pose()).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(std::string(status.message()), HasSubstr("(X, Z) cannot move the tool in three directions at X0.0000"));

  const Machine parallel = machine::testing::Make(
      "parallel",
      {machine::testing::Linear("X", kX), machine::testing::Linear("Z", kZ), machine::testing::Linear("V", kZ)}, {},
      {});
  EXPECT_FALSE(MustCreate(parallel, {}, {}).Correct(Pose()).ok());
}

TEST(Compensator, AFourthLinearAxisSharesTheCorrection) {
  using machine::testing::kX;
  using machine::testing::kY;
  using machine::testing::kZ;
  const Machine quill = machine::testing::Make("quill",
                                               {machine::testing::Linear("X", kX), machine::testing::Linear("Y", kY),
                                                machine::testing::Linear("Z", kZ), machine::testing::Linear("V", kZ)},
                                               {}, {});
  ErrorModel errors;
  errors.terms = {Term(quill, "EZ0T", 0.1)};
  const auto correction = MustCreate(quill, errors, {}).Correct(Pose());
  ASSERT_TRUE(correction.ok()) << correction.status();
  EXPECT_NEAR(correction->corrected[2], -0.05, 1e-12);
  EXPECT_NEAR(correction->corrected[3], -0.05, 1e-12);
}

// A map over X alone and one over A and C: between nodes and at them.
TEST(Compensator, ErrorMapsAreTakenOut) {
  const Machine machine = machine::testing::TiltingTable();
  const auto errors = machine::ReadErrors(R"({"terms": [
      {"symbol": "EZX", "shape": "tabulated", "nodes_mm": [-200, 0, 150], "values": [30, -20, 45]},
      {"symbol": "EBC", "shape": "tabulated", "variable": "C", "nodes_deg": [0, 120, 240], "zero_mean": true,
       "over": {"variable": "A", "nodes_deg": [-90, 0]}, "values": [[50, -20, -30], [-10, 40, -30]]}]})",
                                          machine);
  ASSERT_TRUE(errors.ok()) << errors.status();
  Options options;
  options.tool_tip_mm = {0, 0, 150};
  const Compensator compensator = MustCreate(machine, *errors, options);
  EXPECT_LT(compensator.smooth_travel(FindAxis(machine, "X")), 150.0);
  for (const double x_mm : {-250.0, -70.0, 0.0, 33.0}) {
    for (const double c_deg : {0.0, 77.0, 300.0}) {
      Pose pose;
      pose.position[FindAxis(machine, "X")] = x_mm;
      pose.position[FindAxis(machine, "A")] = -40.0 * kRadPerDeg;
      pose.position[FindAxis(machine, "C")] = c_deg * kRadPerDeg;
      const auto correction = compensator.Correct(pose);
      ASSERT_TRUE(correction.ok()) << correction.status();
      EXPECT_GT(correction->before_mm, 1e-3);
      EXPECT_LE(correction->after_mm, kToleranceMm);
    }
  }
}

TEST(Compensator, FreeCurvesAreTakenOutAndATimeCurveIsNotCarried) {
  const Machine machine = machine::testing::TiltingTable();
  const auto errors = machine::ReadErrors(R"({"terms": [
      {"symbol": "EZX", "shape": "curve", "from_mm": -200, "to_mm": 150, "amplitudes": [30, -20, 15, 4]},
      {"symbol": "EBC", "shape": "curve", "amplitudes": [50, -20, 10, 5]},
      {"symbol": "EYX", "shape": "crossed", "over": "C", "from_mm": -200, "to_mm": 150, "amplitudes": [9, 4, 3, 2]},
      {"symbol": "EXX", "shape": "crossed", "over": "C", "from_mm": -200, "to_mm": 150,
       "amplitudes": [9, 4, 3, 2, 5, -3, 1, 2]},
      {"symbol": "EZT", "shape": "time-curve", "from_s": 0, "to_s": 900, "amplitudes": [9]},
      {"symbol": "EXT", "shape": "thermal-lag", "channel": "T_bed_C", "tau_s": 900, "amplitude": 2}]})",
                                          machine);
  ASSERT_TRUE(errors.ok()) << errors.status();
  Options options;
  options.tool_tip_mm = {0, 0, 150};
  options.time_s = 100.0;
  options.temperature_celsius = 25.0;
  const Compensator compensator = MustCreate(machine, *errors, options);
  EXPECT_THAT(compensator.not_carried(),
              ::testing::ElementsAre("EZT:time-curve: it is known for the time of its readings only",
                                     "EXT:thermal-lag(T_bed_C): no temperature T_bed_C can be stated"));
  EXPECT_LT(compensator.smooth_travel(FindAxis(machine, "X")), 20.0);
  for (const double x_mm : {-250.0, -70.0, 0.0, 33.0, 149.0}) {
    for (const double c_deg : {0.0, 77.0, 300.0}) {
      Pose pose;
      pose.position[FindAxis(machine, "X")] = x_mm;
      pose.position[FindAxis(machine, "C")] = c_deg * kRadPerDeg;
      const auto correction = compensator.Correct(pose);
      ASSERT_TRUE(correction.ok()) << correction.status();
      EXPECT_GT(correction->before_mm, 1e-3);
      EXPECT_LE(correction->after_mm, kToleranceMm);
    }
  }
}

// The bound holds for every shape that a program carries, and is not so loose that it would have every move sampled.
TEST(Compensator, TheDepartureBoundHolds) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    const int x = FindAxis(machine, "X"), c = FindAxis(machine, "C");
    for (int round = 0; round < 200; ++round) {
      ErrorModel errors = machine::DeclaredModel(machine);
      for (auto& term : errors.terms) {
        term.amplitude[0] = unit(random) * (machine::IsAngle(term.component) ? 1e-4 : 0.05);
        if (round % 9 == 1) term.shape = shapes::Linear{x, shapes::Linear::kReferenceMm};
        if (round % 9 == 2) term.shape = shapes::Quadratic{x};
        if (round % 9 == 3) term.shape = shapes::Harmonic{c, 3.0};
        if (round % 9 == 4) term.shape = shapes::Tabulated{x, {40.0, 60.0, 80.0}, false, {}, c, {0.5, 0.5, 0.7}};
        if (round % 9 == 5) term.shape = shapes::Curve{x, {-150.0, 200.0}};
        if (round % 9 == 6) term.shape = shapes::Curve{c, {.is_turn = true}};
        if (round % 9 == 7) term.shape = shapes::Crossed{x, c, {-150.0, 200.0}, {.is_turn = true}};
        if (round % 9 == 8) term.shape = shapes::ThermalLag{"temp_C", 600.0, x, 1000.0};
        if (round % 36 == 10) term.shape = shapes::DriftExp{600.0, TimesPositionOf(machine, x)};
        if (round % 36 == 19) term.shape = shapes::Drift{};
        if (round % 36 == 28) term.shape = shapes::Thermal{};
        if (round % 18 == 14) term.shape = shapes::BacklashCurve{{x, {-150.0, 200.0}}};
        for (int i = 0; shapes::IsFree(term.shape) && i < shapes::BasisCount(term.shape); ++i)
          term.amplitude[i] =
              unit(random) * shapes::PriorRoot(term.shape, i) * (machine::IsAngle(term.component) ? 4e-6 : 0.002);
      }
      Options options;
      options.tool_tip_mm = {0, 0, -200};
      options.temperature_celsius = 26.0;
      options.time_s = round % 2 == 0 ? -1'500.0 : 144'000.0;
      const Compensator compensator = MustCreate(machine, errors, options);
      Pose from, to, middle;
      for (Pose* const pose : {&from, &to, &middle}) pose->sense[x] = -1.0;
      const double size = std::pow(10.0, -3.0 * std::abs(unit(random)));
      for (int i = 0; i < machine.axis_count(); ++i) {
        const double full = machine.axes[i].kind == machine::AxisKind::kLinear ? 300.0 : 1.5;
        from.position[i] = unit(random) * full;
        to.position[i] = from.position[i] + unit(random) * full * size;
        middle.position[i] = 0.5 * (from.position[i] + to.position[i]);
      }
      const auto first = compensator.Correct(from), last = compensator.Correct(to), half = compensator.Correct(middle);
      ASSERT_TRUE(first.ok() && last.ok() && half.ok());
      double squared = 0;
      for (const int axis : compensator.linear_axes()) {
        const double departure = half->corrected[axis] - 0.5 * (first->corrected[axis] + last->corrected[axis]);
        squared += departure * departure;
      }
      constexpr double kRoundoffMm = 1e-11;
      const double bound = compensator.DepartureBound(from.position, to.position);
      EXPECT_LE(std::sqrt(squared), bound + kRoundoffMm) << machine.id << ' ' << round;
      EXPECT_LT(bound, 100 * size) << machine.id << ' ' << round;  // mm: finite, and shrinks with the move
    }
  }
}

TEST(Compensator, ATimeAtWhichNoErrorHasANumberIsNamed) {
  const Machine machine = machine::testing::MultiTasking();
  ErrorModel errors;
  errors.terms = {Term(machine, "EX0T", 0.01)};
  errors.terms[0].shape = shapes::DriftExp{600.0};
  Options options;
  options.time_s = -1e9;
  EXPECT_THAT(std::string(Compensator::Create(machine, errors, options).status().message()),
              HasSubstr("EXT:drift-exp is -inf at time_s = -1e+09, must be finite"));
  options.time_s = std::nan("");
  EXPECT_THAT(std::string(Compensator::Create(machine, {}, options).status().message()),
              HasSubstr("time_s = nan, must be finite"));
  options = {};
  options.temperature_celsius = INFINITY;
  EXPECT_THAT(std::string(Compensator::Create(machine, {}, options).status().message()),
              HasSubstr("temperature_celsius = inf, must be finite"));
}

TEST(Compensator, BadInputIsNamed) {
  const Machine machine = machine::testing::MultiTasking();
  Options options;
  options.tool_tip_mm.x() = std::nan("");
  EXPECT_EQ(Compensator::Create(machine, {}, options).status().code(), absl::StatusCode::kInvalidArgument);
  ErrorModel errors;
  errors.terms = {Term(machine, "EA0B", std::nan(""))};
  EXPECT_THAT(std::string(Compensator::Create(machine, errors, {}).status().message()), HasSubstr("EA0B = nan"));
  ErrorModel constant, varying;
  constant.terms = {Term(machine, "EA0B", 1e-4)};
  varying.terms = {{0, machine::Component::kX, shapes::Linear{0, shapes::Linear::kReferenceMm}, {0.01}}};
  for (const ErrorModel& model : {ErrorModel(), constant, varying}) {
    const Compensator compensator = MustCreate(machine, model, {});
    for (int axis = 0; axis < machine.axis_count(); ++axis) {
      for (const double value : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
        Pose pose;
        pose.position[axis] = value;
        const absl::Status status = compensator.Correct(pose).status();
        EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
        EXPECT_THAT(std::string(status.message()), HasSubstr("axis " + machine.axes[axis].name));
      }
    }
  }
}

}  // namespace
}  // namespace axiscal::compensate
