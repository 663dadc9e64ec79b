#include "core/instruments/evaluation.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/centres/centres_model.h"
#include "core/instruments/direction/direction_model.h"
#include "core/instruments/distortion.h"
#include "core/instruments/eccentricity/eccentricity_model.h"
#include "core/instruments/length/length_model.h"
#include "core/instruments/registry.h"
#include "core/instruments/rtest/rtest_model.h"
#include "core/instruments/touch/touch_model.h"
#include "core/instruments/tracker/tracker_model.h"
#include "core/machine/testing/machines.h"

namespace axiscal::instruments {
namespace {

using machine::JointErrors;
using machine::kComponents;
using machine::Machine;

constexpr int kErrorColumns = kComponents * 7;
constexpr int kColumns = kErrorColumns + kMaxInstrumentParameters;
using Jet = ceres::Jet<double, kColumns>;

// One reading at a typical pose; linear commands bring the tool ball a bar's length from the table ball.
MeasuringRun OneReading(const Machine& machine, const Instrument& instrument, std::mt19937* random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  MeasuringRun run;
  run.kind = instrument.kind;
  run.setup = instrument.setup();
  run.row_count = std::max(1, static_cast<int>(instrument.reading_columns.size()));
  run.axis_count = machine.axis_count();
  run.tip_mm = Eigen::Vector3d(0, 0, -300);
  run.ball_mm = Eigen::Vector3d(50, 20, 60);
  run.bar_length_mm = 100.0;
  run.measured_mm = Eigen::MatrixXd::Zero(run.row_count, 1);
  run.positions.resize(machine.axis_count());
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axes[i].kind == machine::AxisKind::kRotary) run.positions[i] = 1.5 * uniform(*random);
  }
  Eigen::Vector3d aim_mm = run.ball_mm;
  if (run.kind == Kind::kBallbar)
    aim_mm += 100.0 * Eigen::Vector3d(uniform(*random), uniform(*random), 1.0).normalized();
  EXPECT_TRUE(centres::SolveNominalCommands(machine, run.tip_mm, aim_mm, run.positions.data()).ok());
  if (run.kind == Kind::kTouch) {
    // A sphere or a face by turns, touched a little beside the nominal place.
    const Eigen::Vector3d normal = Eigen::Vector3d(uniform(*random), uniform(*random), 1.0).normalized();
    const bool is_sphere = uniform(*random) > 0.0;
    run.touches = {{{"f", is_sphere, run.ball_mm - 15.0 * normal, normal, 12.0}},
                   Eigen::Vector3d(20, -5, 7),
                   3.0,
                   {0},
                   {-normal},
                   {},
                   {}};
  }
  if (run.kind == Kind::kEccentricity) {
    // Three places of a trace, with weights that add up to nothing.
    MeasuringRun trace = OneReading(machine, *FindInstrument("ballbar"), random);
    for (const double turned_rad : {0.3, 0.6}) {
      for (int i = 0; i < machine.axis_count(); ++i) {
        const bool is_rotary = machine.axes[i].kind == machine::AxisKind::kRotary;
        trace.positions.push_back(trace.positions[i] + (is_rotary ? turned_rad : 5.0));
      }
    }
    trace.measured_mm = Eigen::MatrixXd::Zero(1, 3);
    trace.time_s.assign(3, 0.0);
    trace.temperature_celsius.assign(3, 20.0);
    DeriveMotion(&trace);
    run.path_readings = std::make_shared<const eccentricity::Eccentricities>(
        eccentricity::Eccentricities{{trace}, {{0, Eigen::Vector3d(0.7, -1.5, 0.8), 0, 0}}});
  }
  run.time_s = {0.0};
  run.temperature_celsius = {20.0};
  DeriveMotion(&run);
  if (run.kind == Kind::kLength) {
    run.length.is_on_bed = uniform(*random) > 0.0;
    run.length.is_beam = uniform(*random) > 0.0;
    run.length.beam = Eigen::Vector3d(uniform(*random), uniform(*random), 1.0).normalized();
    if (run.length.is_beam) run.setup = length::BeamSetupParameters();
    run.ball_mm += Eigen::Vector3d(400, -300, 200);  // a wire has a length
  }
  if (run.kind == Kind::kDirection) {
    run.direction.is_on_bed = uniform(*random) > 0.0;
    run.direction.about = Eigen::Vector3d(uniform(*random), 1.0, uniform(*random)).normalized();
  }
  if (run.kind == Kind::kTracker) {
    run.tracker_from_machine.rotation = geometry::RotationXyz(0.4, -1.0, 2.0);
    run.tracker_from_machine.translation_mm = Eigen::Vector3d(2000, -500, 300);
  }
  return run;
}

void PredictJets(const Machine& machine, const MeasuringRun& run, const JointErrors<Jet>& errors, const Jet* setup,
                 Jet* out) {
  const std::vector<Jet> positions(run.positions.begin(), run.positions.end());
  switch (run.kind) {
    case Kind::kBallbar:
      return ballbar::Predict<Jet>(machine, run, positions.data(), errors, setup, out);
    case Kind::kRtest:
      return rtest::Predict<Jet>(machine, run, positions.data(), errors, setup, out);
    case Kind::kCentres:
      return centres::Predict<Jet>(machine, run, positions.data(), errors, setup, out);
    case Kind::kTracker:
      return tracker::Predict<Jet>(machine, run, 0, positions.data(), errors, setup, out);
    case Kind::kTouch:
      return touch::Predict<Jet>(machine, run, 0, positions.data(), errors, setup, out);
    case Kind::kEccentricity:
      return eccentricity::Predict<Jet>(machine, run, 0, errors, setup, out);
    case Kind::kLength:
      return length::Predict<Jet>(machine, run, positions.data(), errors, setup, out);
    case Kind::kDirection:
      return direction::Predict<Jet>(machine, run, positions.data(), errors, setup, out);
  }
}

class EvaluationTest : public testing::TestWithParam<double> {};

TEST_P(EvaluationTest, DerivativesAgreeWithAutomaticOnes) {
  const double scale = GetParam();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    std::vector<Instrument> instruments = Instruments();
    // Bed and table, anchor and beam are drawn: several of each.
    for (int more = 0; more < 8; ++more)
      for (const char* const name : {"length", "direction"}) instruments.push_back(*FindInstrument(name));
    for (const Instrument& instrument : instruments) {
      const MeasuringRun run = OneReading(machine, instrument, &random);
      JointErrors<double> errors;
      JointErrors<Jet> jet_errors;
      for (int joint = 0; joint < machine.joint_count(); ++joint) {
        for (int c = 0; c < kComponents; ++c) {
          errors[joint][c] = scale * uniform(random) * (c < 3 ? 1.0 : 1e-3);
          jet_errors[joint][c] = Jet(errors[joint][c], kComponents * joint + c);
        }
      }
      double setup[kMaxSetupParameters];
      Jet jet_setup[kMaxSetupParameters], reference[kMaxRows];
      for (int i = 0; i < kMaxSetupParameters; ++i) {
        setup[i] = scale * uniform(random);
        // What was appended to an instrument's own setup takes no part here.
        jet_setup[i] = i < kMaxInstrumentParameters ? Jet(setup[i], kErrorColumns + i) : Jet(setup[i]);
      }
      PredictJets(machine, run, jet_errors, jet_setup, reference);
      Evaluation evaluation;
      Evaluate(machine, run, 0, errors, setup, &evaluation);
      double predicted[kMaxRows];
      Predict(machine, run, 0, errors, setup, predicted);
      // Levers reach 1e3 mm. Sphere centres take the angle errors of the linear axes for zero (see there): scale times
      // a few.
      const double tolerance = 1e-9 + (run.kind == Kind::kCentres ? 10.0 * scale : 0.0);
      for (int row = 0; row < run.row_count; ++row) {
        EXPECT_NEAR(evaluation.predicted_mm[row], reference[row].a, 1e-9) << machine.id << ' ' << instrument.name;
        EXPECT_NEAR(predicted[row], reference[row].a, 1e-9) << machine.id << ' ' << instrument.name;
        for (int i = 0; i < kComponents * machine.joint_count(); ++i) {
          EXPECT_NEAR(evaluation.by_error(row, i), reference[row].v[i], tolerance)
              << machine.id << ' ' << instrument.name << ' ' << i;
        }
        for (size_t i = 0; i < run.setup.size(); ++i) {
          EXPECT_NEAR(evaluation.by_setup(row, i), reference[row].v[kErrorColumns + i], tolerance)
              << instrument.name << ' ' << i;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scales, EvaluationTest, testing::Values(0.0, 1e-3, 0.1));

TEST(Evaluation, APerfectMachineReadsZero) {
  std::mt19937 random(3);
  for (const Machine& machine :
       {machine::testing::MultiTasking(), machine::testing::TiltingTable(), machine::testing::SwivelHead()}) {
    for (const char* name : {"ballbar", "rtest"}) {
      const MeasuringRun run = OneReading(machine, *FindInstrument(name), &random);
      const double setup[kMaxSetupParameters] = {};
      double predicted[kMaxRows] = {NAN, NAN, NAN};
      Predict(machine, run, 0, {}, setup, predicted);
      for (int row = 0; row < run.row_count; ++row)
        EXPECT_NEAR(predicted[row], 0.0, 1e-10) << machine.id << ' ' << name;
    }
  }
}

// An axis whose datum was set anew stands a constant from its commanded position: as if it had been commanded there.
// The derivatives are those of differences, by the constant and by the axis' own errors, whose turns turn it along.
TEST(Evaluation, AFreeDatumMovesItsAxes) {
  const auto machine = machine::testing::MultiTasking();
  std::mt19937 random(7);
  for (const Instrument& instrument : Instruments()) {
    if (instrument.kind == Kind::kEccentricity) continue;
    const MeasuringRun run = OneReading(machine, instrument, &random);
    const int rows = run.row_count;
    const size_t own = run.setup.size();
    MeasuringRun free = run;
    const int x = machine::FindAxis(machine, "X"), z = machine::FindAxis(machine, "Z");
    AddDatum(machine, x, &free);
    AddDatum(machine, z, &free);
    EXPECT_EQ(free.setup.back().name, "datum_Z");
    machine::JointErrors<double> errors;
    for (int joint = 0; joint < machine.joint_count(); ++joint) errors[joint] << 0.01, -0.02, 0.03, 1e-3, -2e-3, 3e-3;
    double setup[kMaxSetupParameters] = {};
    setup[own] = 0.7;
    setup[own + 1] = -0.4;
    MeasuringRun moved = run;
    moved.positions[x] += 0.7;
    moved.positions[z] -= 0.4;
    double expected_mm[kMaxRows], predicted_mm[kMaxRows];
    Predict(machine, moved, 0, errors, setup, expected_mm);
    // Where the machine moves until a condition holds, it stops as much before as the axes stand ahead.
    if (instrument.kind == Kind::kCentres) {
      Predict(machine, run, 0, errors, setup, expected_mm);
      expected_mm[0] -= 0.7;
      expected_mm[2] += 0.4;
    }
    Predict(machine, free, 0, errors, setup, predicted_mm);
    for (int row = 0; row < rows; ++row) EXPECT_NEAR(predicted_mm[row], expected_mm[row], 1e-10) << instrument.name;
    machine::JointTransforms transforms(machine);
    transforms.Set(errors);
    Predict(machine, free, 0, transforms, setup, predicted_mm);
    for (int row = 0; row < rows; ++row) EXPECT_NEAR(predicted_mm[row], expected_mm[row], 1e-10) << instrument.name;
    Evaluation evaluation;
    Evaluate(machine, free, 0, errors, setup, &evaluation);
    ASSERT_EQ(evaluation.by_setup.cols(), static_cast<Eigen::Index>(own + 2));
    constexpr double kStep = 1e-5, kNear = 1e-6;  // central differences: second order
    const auto differ = [&](double* at, int row) {
      const double was = *at;
      double low[kMaxRows], high[kMaxRows];
      *at = was - kStep;
      Predict(machine, free, 0, errors, setup, low);
      *at = was + kStep;
      Predict(machine, free, 0, errors, setup, high);
      *at = was;
      return (high[row] - low[row]) / (2.0 * kStep);
    };
    for (int row = 0; row < rows; ++row) {
      EXPECT_NEAR(evaluation.predicted_mm[row], expected_mm[row], 1e-10);
      // The slopes of sphere centres are those of a machine without errors (core/instruments/centres/centres_model.cc):
      // 3 mrad of 500 mm.
      const double near = instrument.kind == Kind::kCentres ? 0.02 : kNear;
      for (size_t k = 0; k < own + 2; ++k)
        EXPECT_NEAR(evaluation.by_setup(row, static_cast<Eigen::Index>(k)), differ(setup + k, row), near) << k;
      for (const int axis : {x, z}) {
        for (int c = 0; c < machine::kComponents; ++c) {
          const double slope = differ(&errors[axis][c], row);
          EXPECT_NEAR(evaluation.by_error(row, machine::kComponents * axis + c), slope,
                      instrument.kind != Kind::kCentres ? 1e-4
                      : c < 3                           ? 0.02
                                                        : 3.0)
              << instrument.name << ' ' << axis << ' ' << c;
        }
      }
    }
  }
}

// What slipped on the table is as if the artefact had stood there, what slipped in the holder as if the tool joint had
// erred, from the slip's reading on.
TEST(Evaluation, ASlipMovesWhatItsCarrierBearsFromItsReadingOn) {
  std::mt19937 random(5);
  const Eigen::Vector3d by_mm(0.3, -0.2, 0.5);
  for (const Machine& machine : {machine::testing::MultiTasking(), machine::testing::TiltingTable()}) {
    for (const Instrument& instrument : Instruments()) {
      if (instrument.kind == Kind::kEccentricity || instrument.kind == Kind::kDirection) continue;  // no place
      const MeasuringRun whole = OneReading(machine, instrument, &random);
      for (const Carrier carrier : {Carrier::kTable, Carrier::kTool}) {
        double moved[kMaxSetupParameters] = {};
        JointErrors<double> errors;
        for (int k = 0; k < 3; ++k)
          (carrier == Carrier::kTable ? moved[k] : errors[machine.tool_joint()][k]) = by_mm[k];
        double setup[kMaxSetupParameters] = {};
        std::copy(by_mm.begin(), by_mm.end(), setup + whole.setup.size());
        for (const bool is_after : {false, true}) {
          MeasuringRun slipped = whole;
          AddSlip({carrier, is_after ? 0 : 1}, &slipped);
          ASSERT_EQ(slipped.setup.size(), whole.setup.size() + 3);
          const double none[kMaxSetupParameters] = {};
          double predicted[kMaxRows], reference[kMaxRows];
          Predict(machine, slipped, 0, {}, setup, predicted);
          if (is_after) {
            Predict(machine, whole, 0, errors, moved, reference);
          } else {
            Predict(machine, whole, 0, {}, none, reference);
          }
          Evaluation evaluation, undisturbed;
          Evaluate(machine, slipped, 0, {}, setup, &evaluation);
          Evaluate(machine, whole, 0, is_after ? errors : JointErrors<double>(), is_after ? moved : none, &undisturbed);
          ASSERT_EQ(evaluation.by_setup.cols(), static_cast<Eigen::Index>(slipped.setup.size()));
          for (int row = 0; row < whole.row_count; ++row) {
            EXPECT_NEAR(predicted[row], reference[row], 1e-12) << instrument.name;
            EXPECT_NEAR(evaluation.predicted_mm[row], reference[row], 1e-9) << instrument.name;
            for (int k = 0; k < 3; ++k) {
              const double slope = carrier == Carrier::kTable
                                       ? undisturbed.by_setup(row, k)
                                       : undisturbed.by_error(row, kComponents * machine.tool_joint() + k);
              EXPECT_EQ(evaluation.by_setup(row, static_cast<Eigen::Index>(whole.setup.size()) + k),
                        is_after ? slope : 0.0)
                  << instrument.name;
            }
          }
        }
      }
    }
  }
}

// Two readings at one pose, 100 s and 3 K apart; every axis moves at the second.
MeasuringRun TwoReadings(const Machine& machine, const Instrument& instrument, std::mt19937* random) {
  MeasuringRun run = OneReading(machine, instrument, random);
  run.has_time = run.has_temperature = true;
  const std::vector<double> positions = run.positions;
  run.positions.insert(run.positions.end(), positions.begin(), positions.end());
  run.time_s = {0.0, 100.0};
  run.temperature_celsius = {20.0, 23.0};
  run.measured_mm = Eigen::MatrixXd::Zero(run.row_count, 2);
  DeriveMotion(&run);
  for (int axis = 0; axis < machine.axis_count(); ++axis)
    run.axis_states.Own()[machine.axis_count() + axis].speed =
        machine.axes[axis].kind == machine::AxisKind::kRotary ? 0.05 * (axis + 1) : 10.0 - 3.0 * axis;
  return run;
}

std::vector<Distortion> EveryDistortion(Kind instrument) {
  return {{.kind = Distortion::kGain, .instrument = instrument, .amplitude_mm = {}, .sigma_mm = {}},
          {.kind = Distortion::kScale, .instrument = instrument, .amplitude_mm = {}, .sigma_mm = {}},
          {.kind = Distortion::kBall, .instrument = instrument, .amplitude_mm = {}, .sigma_mm = {}},
          {.kind = Distortion::kLobes,
           .instrument = instrument,
           .carrier = Carrier::kTable,
           .order = 3,
           .amplitude_mm = {},
           .sigma_mm = {}},
          {.kind = Distortion::kLobes, .instrument = instrument, .order = 5, .amplitude_mm = {}, .sigma_mm = {}},
          {.kind = Distortion::kGrowth, .instrument = instrument, .tau_s = 60.0, .amplitude_mm = {}, .sigma_mm = {}},
          {.kind = Distortion::kMotion,
           .instrument = instrument,
           .from_s = -20.0,
           .length_s = 300.0,
           .amplitude_mm = {},
           .sigma_mm = {}},
          {.kind = Distortion::kMotion,
           .instrument = instrument,
           .carrier = Carrier::kTable,
           .length_s = 300.0,
           .amplitude_mm = {},
           .sigma_mm = {}},
          {.kind = Distortion::kClock,
           .instrument = instrument,
           .from_s = -20.0,
           .length_s = 300.0,
           .amplitude_mm = {},
           .sigma_mm = {}}};
}

double* SetupBehind(const MeasuringRun& run, double* setup) { return setup + run.setup.size(); }

// An instrument at fault in every way at once: the derivatives by errors and by all set-up offsets are those of
// differences.
TEST(Evaluation, DerivativesOfDistortedReadingsAreThoseOfDifferences) {
  std::mt19937 random(11);
  for (const Machine& machine : {machine::testing::MultiTasking(), machine::testing::TiltingTable()}) {
    for (const char* name : {"ballbar", "rtest", "tracker"}) {
      MeasuringRun run = TwoReadings(machine, *FindInstrument(name), &random);
      for (const Distortion& one : EveryDistortion(run.kind))
        if (CanHave(run, one)) AddDistortion(one, &run);
      AddSlip({Carrier::kTool, 1}, &run);
      ASSERT_GE(run.distortions.size(), 5u) << name;
      double setup[kMaxSetupParameters] = {};
      std::uniform_real_distribution<double> uniform(-0.02, 0.02);
      for (size_t k = 0; k < run.setup.size(); ++k) setup[k] = uniform(random);
      JointErrors<double> errors;
      for (int joint = 0; joint < machine.joint_count(); ++joint) errors[joint] << 0.01, -0.02, 0.03, 1e-4, -2e-4, 3e-4;
      Evaluation evaluation;
      Evaluate(machine, run, 1, errors, setup, &evaluation);
      ASSERT_EQ(evaluation.by_setup.cols(), static_cast<Eigen::Index>(run.setup.size()));
      double predicted[kMaxRows];
      machine::JointTransforms transforms(machine);
      transforms.Set(errors);
      Predict(machine, run, 1, transforms, setup, predicted);
      for (int row = 0; row < run.row_count; ++row)
        EXPECT_NEAR(evaluation.predicted_mm[row], predicted[row], 1e-9) << name;
      constexpr double kStep = 1e-5;
      const auto differ = [&](double* at, int row) {
        const double was = *at;
        double low[kMaxRows], high[kMaxRows];
        *at = was - kStep;
        Predict(machine, run, 1, errors, setup, low);
        *at = was + kStep;
        Predict(machine, run, 1, errors, setup, high);
        *at = was;
        return (high[row] - low[row]) / (2.0 * kStep);
      };
      for (int row = 0; row < run.row_count; ++row) {
        // Balls are touched in the nominal direction, and a clock's turns are small: of second order both.
        for (size_t k = 0; k < run.setup.size(); ++k)
          EXPECT_NEAR(evaluation.by_setup(row, static_cast<Eigen::Index>(k)), differ(setup + k, row), 2e-3)
              << name << ' ' << run.setup[k].name;
        for (int joint = 0; joint < machine.joint_count(); ++joint) {
          for (int c = 0; c < kComponents; ++c) {
            const double slope = differ(&errors[joint][c], row);
            // The way that a late clock puts an axis behind is not turned with its error: hundredths of a millimetre.
            EXPECT_NEAR(evaluation.by_error(row, kComponents * joint + c), slope, 2e-3 * (1.0 + std::abs(slope)))
                << name << ' ' << joint << ' ' << c;
          }
        }
      }
    }
  }
}

// What each fault makes of a reading, in closed form.
TEST(Evaluation, KnownAnswersOfDistortions) {
  std::mt19937 random(13);
  const Machine machine = machine::testing::TiltingTable();
  JointErrors<double> errors;
  errors[machine.tool_joint()] << 0.03, -0.02, 0.05, 0, 0, 0;
  const auto read = [&](const MeasuringRun& run, const double* setup) {
    Eigen::Vector3d out(NAN, NAN, NAN);
    Predict(machine, run, 1, errors, setup, out.data());
    return out;
  };
  const double none[kMaxSetupParameters] = {};
  const MeasuringRun rtest = TwoReadings(machine, *FindInstrument("rtest"), &random);
  const Eigen::Vector3d sound = read(rtest, none);
  {  // x reads 2 % of itself and 1 % of y too much
    MeasuringRun run = rtest;
    AddDistortion({.kind = Distortion::kGain, .amplitude_mm = {}, .sigma_mm = {}}, &run);
    EXPECT_EQ(run.setup[3].name, "gain_xx");
    EXPECT_EQ(run.setup[4].name, "gain_xy");
    double setup[kMaxSetupParameters] = {};
    SetupBehind(rtest, setup)[0] = 0.02 * kGainReadingMm;
    SetupBehind(rtest, setup)[1] = 0.01 * kGainReadingMm;
    const Eigen::Vector3d added = read(run, setup) - sound;
    EXPECT_NEAR(added.x(), 0.02 * sound.x() + 0.01 * sound.y(), 1e-12);
    EXPECT_EQ(added.tail<2>(), Eigen::Vector2d::Zero());
  }
  {  // the axes stand where they did 0.03 s before
    MeasuringRun run = rtest;
    AddDistortion({.kind = Distortion::kClock, .amplitude_mm = {}, .sigma_mm = {}}, &run);
    double setup[kMaxSetupParameters] = {};
    *SetupBehind(rtest, setup) = 0.03 * kClockSpeedMmPerS;
    MeasuringRun late = rtest;
    const auto axes = static_cast<size_t>(machine.axis_count());
    for (size_t i = 0; i < axes; ++i) late.positions[axes + i] -= 0.03 * late.AxisStatesOf(1)[i].speed;
    EXPECT_LT((read(run, setup) - read(late, none)).norm(), 1e-9);
  }
  {  // two clocks that run apart, and a path of straight ways: all axes come along that to the reading
    MeasuringRun run = rtest;
    const auto axes = static_cast<size_t>(machine.axis_count());
    for (size_t i = 0; i < axes; ++i) run.positions[i] -= 2.0 * static_cast<double>(i + 1);  // in 100 s
    AddDistortion({.kind = Distortion::kClock, .from_s = 0.0, .length_s = 400.0, .amplitude_mm = {}, .sigma_mm = {}},
                  &run);
    double setup[kMaxSetupParameters] = {};
    for (const int k : {0, 1, 3}) SetupBehind(rtest, setup)[k] = 0.03 * kClockSpeedMmPerS;
    MeasuringRun late = rtest;
    for (size_t i = 0; i < axes; ++i) {
      const double apart = -0.5 * late.AxisStatesOf(1)[i].speed;  // a quarter of the time is over
      late.positions[axes + i] -= 0.03 * (0.02 * static_cast<double>(i + 1) + apart);
    }
    EXPECT_LT((read(run, setup) - read(late, none)).norm(), 1e-9);
  }
  {  // z has grown by 1 - 1 / e after one time constant
    MeasuringRun run = rtest;
    AddDistortion({.kind = Distortion::kGrowth, .tau_s = 100.0, .amplitude_mm = {}, .sigma_mm = {}}, &run);
    double setup[kMaxSetupParameters] = {};
    SetupBehind(rtest, setup)[2] = 0.01;
    EXPECT_LT((read(run, setup) - sound - Eigen::Vector3d(0, 0, 0.01 * (1.0 - std::exp(-1.0)))).norm(), 1e-12);
  }
  {  // a bar of 100 mm that is 1 um/m/K longer by 3 K
    const MeasuringRun bar = TwoReadings(machine, *FindInstrument("ballbar"), &random);
    MeasuringRun run = bar;
    AddDistortion({.kind = Distortion::kScale, .instrument = Kind::kBallbar, .amplitude_mm = {}, .sigma_mm = {}}, &run);
    double setup[kMaxSetupParameters] = {}, before = NAN, after = NAN;
    *SetupBehind(bar, setup) = 1e-6 * kScaleLengthMm;
    Predict(machine, bar, 1, errors, none, &before);
    Predict(machine, run, 1, errors, setup, &after);
    EXPECT_NEAR(after - before, 1e-6 * 3.0 * (100.0 + before), 1e-12);
  }
  {  // half of the motion's first cosine: what stands on the table is there
    MeasuringRun run = rtest;
    AddDistortion({.kind = Distortion::kMotion,
                   .carrier = Carrier::kTable,
                   .length_s = 300.0,
                   .amplitude_mm = {},
                   .sigma_mm = {}},
                  &run);
    double setup[kMaxSetupParameters] = {}, there[kMaxSetupParameters] = {};
    SetupBehind(rtest, setup)[1] = 0.02;
    there[1] = 0.02 * 0.5;  // cos(pi / 3)
    EXPECT_LT((read(run, setup) - read(rtest, there)).norm(), 1e-12);
  }
}

// Two of the other kinds of instruments are no matter of theirs; without a clock nothing grows.
TEST(Evaluation, OnlyWhatAnInstrumentCanHaveIsAsked) {
  std::mt19937 random(17);
  MeasuringRun run = TwoReadings(machine::testing::TiltingTable(), *FindInstrument("rtest"), &random);
  EXPECT_TRUE(CanHave(run, {.kind = Distortion::kGain, .amplitude_mm = {}, .sigma_mm = {}}));
  EXPECT_FALSE(
      CanHave(run, {.kind = Distortion::kGain, .instrument = Kind::kBallbar, .amplitude_mm = {}, .sigma_mm = {}}));
  EXPECT_FALSE(
      CanHave(run, {.kind = Distortion::kBall, .carrier = Carrier::kTable, .amplitude_mm = {}, .sigma_mm = {}}));
  EXPECT_TRUE(CanHave(run, {.kind = Distortion::kGrowth, .tau_s = 60.0, .amplitude_mm = {}, .sigma_mm = {}}));
  run.has_time = false;
  EXPECT_FALSE(CanHave(run, {.kind = Distortion::kGrowth, .tau_s = 60.0, .amplitude_mm = {}, .sigma_mm = {}}));
  EXPECT_FALSE(CanHave(run, {.kind = Distortion::kClock, .amplitude_mm = {}, .sigma_mm = {}}));
}

}  // namespace
}  // namespace axiscal::instruments
