// What is at fault beside the machine: the readings that each fault gives, and a truth that it does not touch.
#include "core/synthetic/fault.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/machine/error_json.h"
#include "core/synthetic/scenario.h"
#include "core/synthetic/testing/plans.h"

namespace axiscal::synthetic {
namespace {

using ::testing::HasSubstr;
using testing::Swing;

const machine::Machine& Mt() {
  static const machine::Machine* const kMachine = new machine::Machine(machine::testing::MultiTasking());
  return *kMachine;
}

// Without noise and set-up, on a machine with some errors.
Scenario Quiet() {
  Scenario scenario;
  scenario.errors = machine::ReadErrors(R"({"EX0C": 30, "EA0B": -60, "EB0C": 25})", Mt()).value();
  scenario.noise.sigma_scale = 0.0;
  scenario.noise.draw_setup = false;
  scenario.text = "{}";
  return scenario;
}

absl::StatusOr<SimulatedCase> Simulated(const Fault& fault, Form form = Form::kOwn) {
  Scenario scenario = Quiet();
  scenario.faults = {fault};
  return RunScenario(
      Mt(), scenario,
      {{Swing("R", "rtest", 300, 0.0), Swing("B", "ballbar", 300, 1000.0)}, {Swing("T", "tracker", 100, 2000.0)}}, form,
      5);
}

const SimulatedCase& Sound() {
  static const SimulatedCase* const kSound =
      new SimulatedCase(RunScenario(Mt(), Quiet(),
                                    {{Swing("R", "rtest", 300, 0.0), Swing("B", "ballbar", 300, 1000.0)},
                                     {Swing("T", "tracker", 100, 2000.0)}},
                                    Form::kOwn, 5)
                            .value());
  return *kSound;
}

const std::vector<double>& Read(const session::Session& session, const std::string& column) {
  return session::FindColumn(session, column)->values;
}

std::vector<double> Less(std::vector<double> a, const std::vector<double>& b) {
  for (size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

Fault Of(FaultKind kind) {
  Fault fault;
  fault.kind = kind;
  return fault;
}

TEST(Faults, GainIsAShareOfTheReading) {
  Fault gain = Of(FaultKind::kGain);
  gain.gain = 0.1;
  const SimulatedCase faulty = Simulated(gain).value();
  const std::vector<double>&bar = Read(faulty.measured.fit[1], "dL_mm"),
        &sound = Read(Sound().measured.fit[1], "dL_mm");
  const double factor = bar[40] / sound[40];
  EXPECT_NEAR(std::abs(factor - 1.0), 0.1, 1e-9);
  for (size_t k = 0; k < bar.size(); ++k) EXPECT_NEAR(bar[k], factor * sound[k], 1e-12);
  EXPECT_EQ(faulty.measured.check[0], Sound().measured.check[0]);  // a tracker has no such channels
  // A channel alone has no crosstalk; three have.
  gain.gain = 0.0;
  gain.crosstalk = 0.05;
  const SimulatedCase crossed = Simulated(gain).value();
  EXPECT_EQ(crossed.measured.fit[1], Sound().measured.fit[1]);
  EXPECT_GT(RmsAboutMean(Less(Read(crossed.measured.fit[0], "dx_mm"), Read(Sound().measured.fit[0], "dx_mm"))), 1e-6);
}

TEST(Faults, ScaleIsAShareOfTheBar) {
  Fault scale = Of(FaultKind::kScale);
  scale.scale = 50e-6;
  const SimulatedCase faulty = Simulated(scale).value();
  const std::vector<double>&bar = Read(faulty.measured.fit[1], "dL_mm"),
        &sound = Read(Sound().measured.fit[1], "dL_mm");
  for (size_t k = 0; k < bar.size(); ++k) EXPECT_NEAR(bar[k] - sound[k], 50e-6 * (100.0 + sound[k]), 1e-12);
  EXPECT_EQ(faulty.measured.fit[0], Sound().measured.fit[0]);
}

TEST(Faults, SlipMovesWhatTheTableCarriesFromThenOn) {
  Fault slip = Of(FaultKind::kSlip);
  slip.sessions = {"R"};
  slip.at = 0.4;
  slip.moved_mm = {3e-3, 0, -2e-3};
  const SimulatedCase faulty = Simulated(slip).value();
  const std::vector<double> moved = Less(Read(faulty.measured.fit[0], "dx_mm"), Read(Sound().measured.fit[0], "dx_mm"));
  EXPECT_EQ(moved[119], 0.0);
  EXPECT_NEAR(moved[120], -3e-3, 1e-9);  // the tool stands too far to the other side
  EXPECT_NEAR(Less(Read(faulty.measured.fit[0], "dz_mm"), Read(Sound().measured.fit[0], "dz_mm"))[299], 2e-3, 1e-9);
}

TEST(Faults, ClockReadsTheMachineLater) {
  Fault clock = Of(FaultKind::kClock);
  clock.delay_s = 0.5;  // one reading
  const SimulatedCase faulty = Simulated(clock, Form::kIndependent).value();
  Scenario still = Quiet();
  still.errors = {};
  // A sound machine that stands elsewhere when it is read: the R-test sees the way of half a second.
  still.faults = {clock};
  const std::vector<double> seen =
      Read(RunScenario(Mt(), still, {{Swing("R", "rtest", 300, 0.0)}, {}}, Form::kOwn, 5)->measured.fit[0], "dx_mm");
  EXPECT_GT(RmsAboutMean(seen), 0.01);
  EXPECT_NE(faulty.measured.fit[0], Sound().measured.fit[0]);
  EXPECT_EQ(Read(faulty.measured.fit[0], "X_mm"), Read(Sound().measured.fit[0], "X_mm"));
}

TEST(Faults, LateLogsShowOtherPositions) {
  Fault late = Of(FaultKind::kLoggedLate);
  late.delay_s = 0.2;
  late.sessions = {"R"};
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const SimulatedCase faulty = Simulated(late, form).value();
    EXPECT_EQ(Read(faulty.measured.fit[0], "dx_mm"), Read(Sound().measured.fit[0], "dx_mm"));
    const std::vector<double>&shown = Read(faulty.measured.fit[0], "C_deg"),
          &at = Read(Sound().measured.fit[0], "C_deg");
    // Turning steadily at 17e-3 x 170 deg per half second.
    EXPECT_NEAR(shown[4], at[4] - 0.2 * (at[4] - at[3]) / 0.5, 0.02);
    EXPECT_EQ(faulty.measured.fit[1], Sound().measured.fit[1]);
  }
}

// Balls, lobes, growth and motion have the size that was asked for, over the readings that have them, in both forms;
// and the forms are not the same.
TEST(Faults, HaveTheSizeThatWasAskedFor) {
  for (const FaultKind kind : {FaultKind::kBall, FaultKind::kLobes, FaultKind::kGrowth}) {
    Fault fault = Of(kind);
    fault.rms_mm = 2e-3;
    fault.tau_s = 60.0;
    fault.sessions = {"B"};
    fault.carrier =
        instruments::Carrier::kTool;  // the bar turns with the table: it touches the ball there at one point
    std::vector<double> of_own;
    for (const Form form : {Form::kOwn, Form::kIndependent}) {
      const SimulatedCase faulty = Simulated(fault, form).value();
      const std::vector<double> off =
          Less(Read(faulty.measured.fit[1], "dL_mm"), Read(Sound().measured.fit[1], "dL_mm"));
      EXPECT_NEAR(RmsAboutMean(off), 2e-3, 1e-9) << FaultWords()[static_cast<int>(kind)];
      if (form == Form::kIndependent) {
        EXPECT_GT(RmsAboutMean(Less(off, of_own)), 1e-5) << FaultWords()[static_cast<int>(kind)];
      }
      of_own = off;
    }
  }
  Fault motion = Of(FaultKind::kMotion);
  motion.rms_mm = 2e-3;
  motion.sessions = {"R"};
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const SimulatedCase faulty = Simulated(motion, form).value();
    std::vector<double> off;
    for (const char* const column : {"dx_mm", "dy_mm", "dz_mm"}) {
      const std::vector<double> one = Less(Read(faulty.measured.fit[0], column), Read(Sound().measured.fit[0], column));
      off.insert(off.end(), one.begin(), one.end());
    }
    EXPECT_NEAR(RmsAboutMean(off), 2e-3, 1e-8);
  }
  motion.sessions = {"T"};
  EXPECT_NE(Simulated(motion)->measured.check[0], Sound().measured.check[0]);
}

TEST(Faults, AreNotInTheTruth) {
  for (const FaultKind kind : {FaultKind::kGain, FaultKind::kSlip, FaultKind::kMotion, FaultKind::kClock}) {
    Fault fault = Of(kind);
    fault.gain = 0.1;
    fault.rms_mm = 5e-3;
    fault.delay_s = 0.1;
    fault.moved_mm = {1e-2, 0, 0};
    const SimulatedCase faulty = Simulated(fault).value();
    const auto errors = [](const SimulatedCase& simulated) {
      return WriteTruthTable(ErrorsAlong(simulated.truth, simulated.truth.tip_mm, BoxPoses(simulated, 20, 1)));
    };
    EXPECT_EQ(errors(faulty), errors(Sound()));
  }
}

TEST(Faults, AreRefusedWhereNoInstrumentHasThem) {
  Fault ball = Of(FaultKind::kBall);
  ball.rms_mm = 1e-3;
  ball.sessions = {"T"};
  EXPECT_EQ(Simulated(ball).status().message(),
            "faults[0] (ball): the instrument of session 'T' cannot have this fault");
  ball.sessions = {"Q"};
  EXPECT_EQ(Simulated(ball).status().message(), "faults[0] (ball): the plan has no session 'Q'");
}

// Wrong nominal data change what is written, never what is true.
TEST(NominalFaults, ChangeFilesAndDescription) {
  Scenario scenario = Quiet();
  NominalFault direction, pivot, length, swapped, unit;
  direction.axis = 4;
  pivot.kind = NominalKind::kPivot;
  pivot.axis = 3;
  pivot.offset_mm = {0, 0, 0.4};
  length.kind = NominalKind::kToolLength;
  length.offset_mm = {0, 0, -1};
  swapped.kind = NominalKind::kSwapped;
  swapped.columns = {"dx_mm", "dy_mm"};
  unit.kind = NominalKind::kUnit;
  unit.columns = {"dL_mm"};
  unit.factor = 1000.0;
  scenario.nominal = {direction, pivot, length, swapped, unit};
  const SimulatedCase wrong = RunScenario(Mt(), scenario,
                                          {{Swing("R", "rtest", 300, 0.0), Swing("B", "ballbar", 300, 1000.0)},
                                           {Swing("T", "tracker", 100, 2000.0)}},
                                          Form::kOwn, 5)
                                  .value();
  EXPECT_FALSE(wrong.truth.is_all_in_errors());
  EXPECT_EQ(wrong.described.axes[4].direction, Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(wrong.described.axes[3].point_mm, Eigen::Vector3d(0, 0, 0.4));
  EXPECT_EQ(wrong.truth.machine.axes[4].direction, Eigen::Vector3d(0, 0, 1));
  const session::Session &rtest = wrong.measured.fit[0], &sound = Sound().measured.fit[0];
  EXPECT_EQ(session::FindHeader(rtest, "tool_tip_mm"), "0 0 -301");
  EXPECT_EQ(Read(rtest, "dx_mm"), Read(sound, "dy_mm"));
  EXPECT_EQ(Read(rtest, "dy_mm"), Read(sound, "dx_mm"));
  EXPECT_EQ(Read(wrong.measured.fit[1], "dL_mm")[7], 1000.0 * Read(Sound().measured.fit[1], "dL_mm")[7]);
  scenario.nominal[3].sessions = {"B"};
  EXPECT_THAT(
      std::string(
          RunScenario(Mt(), scenario, {{Swing("B", "ballbar", 300, 0.0)}, {}}, Form::kOwn, 5).status().message()),
      HasSubstr("nominal[3]: session 'B': the session has no column 'dx_mm'"));
}

}  // namespace
}  // namespace axiscal::synthetic
