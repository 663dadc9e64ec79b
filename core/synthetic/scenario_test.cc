// Scenarios read, refused, run: the same bytes each time, and a truth that is the chain's.
#include "core/synthetic/scenario.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/machine/error_json.h"
#include "core/session/write_session.h"
#include "core/synthetic/testing/plans.h"

namespace axiscal::synthetic {
namespace {

using ::testing::HasSubstr;
using ::testing::SizeIs;
using testing::Swing;

const machine::Machine& Mt() {
  static const machine::Machine* const kMachine = new machine::Machine(machine::testing::MultiTasking());
  return *kMachine;
}

PlannedCase Plan() {
  return {{Swing("R", "rtest", 400, 0.0), Swing("B", "ballbar", 400, 0.0)}, {Swing("C", "rtest", 200, 0.0)}};
}

std::string Json(const std::string& members) { return "{\"axiscal\": \"scenario/1\", " + members + "}"; }

Scenario Read(const std::string& members) {
  auto scenario = ReadScenario(Json(members), Mt());
  EXPECT_TRUE(scenario.ok()) << scenario.status();
  return *std::move(scenario);
}

std::string Refusal(const std::string& members) {
  return std::string(ReadScenario(Json(members), Mt()).status().message());
}

SimulatedCase Simulated(const Scenario& scenario, Form form = Form::kOwn, uint64_t seed = 3) {
  auto simulated = RunScenario(Mt(), scenario, Plan(), form, seed);
  EXPECT_TRUE(simulated.ok()) << simulated.status();
  return *std::move(simulated);
}

const std::vector<double>& Column(const session::Session& session, const std::string& name) {
  return session::FindColumn(session, name)->values;
}

constexpr char kEverything[] = R"(
 "errors": {"EX0C": 30, "terms": [{"symbol": "EXX", "shape": "linear", "amplitude": 20}]},
 "gravity": [0, 0, -1],
 "sampling": {"stride": 2, "kept_share": 0.9, "lost_share": 0.05, "slower": 1.3, "time_jitter": 0.4, "gap_s": 60},
 "temperatures": [{"name": "temp_C", "start_C": 21, "rise_C": 2, "tau_s": 900, "C_per_h": 0.5,
                   "swing_C": 0.3, "period_s": 700},
                  {"name": "column", "recorded": false, "rise_C": 4, "tau_s": 2000}],
 "effects": [{"kind": "curve", "symbol": "EYX", "rms": 3, "length_mm": 60},
             {"kind": "curve", "symbol": "ECC", "rms": 20, "length_deg": 40},
             {"kind": "time-curve", "symbol": "EXT", "rms": 2, "length_s": 300},
             {"kind": "ripple", "symbol": "ECC", "rms": 10, "order": 36.5},
             {"kind": "ripple", "symbol": "EXX", "rms": 1, "period_mm": 10},
             {"kind": "gravity", "symbol": "EBB", "rms": 15, "body": "T"},
             {"kind": "crossed", "symbol": "EZY", "rms": 3, "variables": ["Y", "B"]},
             {"kind": "thermal", "symbol": "EZT", "rms": 4, "channel": "temp_C", "tau_s": 600},
             {"kind": "thermal", "symbol": "EZT", "rms": 2, "channel": "column", "tau_s": 300, "times": "X"},
             {"kind": "thermal", "symbol": "EXT", "rms": 3, "channel": "time", "tau_s": 900},
             {"kind": "backlash", "symbol": "EXX", "rms": 2},
             {"kind": "wind-up", "symbol": "EBB", "rms": 10, "length_deg": 3},
             {"kind": "friction", "symbol": "EYY", "rms": 1, "length_mm": 15},
             {"kind": "last-move", "symbol": "ECC", "rms": 5},
             {"kind": "following", "symbol": "EYY", "rms": 1, "delay_ms": 15, "of": "speed"},
             {"kind": "following", "symbol": "EXX", "rms": 1, "of": "acceleration"}],
 "faults": [{"kind": "gain", "gain_percent": 3, "crosstalk_percent": 1}, {"kind": "scale", "ppm": 20, "ppm_per_K": 5},
            {"kind": "ball", "rms_um": 0.5}, {"kind": "lobes", "rms_um": 0.5, "order": 5, "carrier": "tool"},
            {"kind": "growth", "rms_um": 1, "tau_s": 60}, {"kind": "motion", "rms_um": 1, "carrier": "table"},
            {"kind": "clock", "delay_ms": 5}, {"kind": "logged-late", "delay_ms": 3, "sessions": ["B"]},
            {"kind": "slip", "sessions": ["R"], "at": 0.6, "moved_um": [1, 2, 0]}],
 "nominal": [{"kind": "direction", "axis": "C"}, {"kind": "pivot", "axis": "B", "offset_mm": [0, 0, 0.1]},
             {"kind": "tool-length", "offset_mm": [0, 0, -0.5]}, {"kind": "swapped", "columns": ["dx_mm", "dy_mm"]},
             {"kind": "unit", "column": "dL_mm", "factor": -1, "sessions": ["B"]}],
 "noise": {"sigma_scale": 1.2, "ar1": 0.5, "white_share": 0.3, "student_degrees": 4, "heavy_share": 0.02,
           "bad_share": 0.01, "pose_share": 0.2, "resolution_um": 0.1}
)";

std::string Bytes(const SimulatedCase& simulated, const Scenario& scenario, Form form) {
  std::string bytes = WriteTruth(simulated, scenario, form, 3);
  for (const auto* sessions : {&simulated.measured.fit, &simulated.measured.check}) {
    for (const session::Session& session : *sessions) {
      const auto text = session::WriteSession(session);
      EXPECT_TRUE(text.ok()) << text.status();
      bytes += text.value_or("");
    }
  }
  const History poses = BoxPoses(simulated, 50, 3);
  return bytes + WritePoses(simulated.truth, poses) +
         WriteTruthTable(ErrorsAlong(simulated.truth, simulated.truth.tip_mm, poses));
}

TEST(Scenario, EverythingAtOnceGivesTheSameBytesForTheSameSeed) {
  const Scenario scenario = Read(kEverything);
  EXPECT_THAT(scenario.effects, SizeIs(16));
  EXPECT_THAT(scenario.faults, SizeIs(9));
  EXPECT_THAT(scenario.nominal, SizeIs(5));
  for (const Form form : {Form::kOwn, Form::kIndependent}) {
    const SimulatedCase simulated = Simulated(scenario, form);
    const std::string bytes = Bytes(simulated, scenario, form);
    EXPECT_EQ(bytes, Bytes(Simulated(scenario, form), scenario, form));
    EXPECT_NE(bytes, Bytes(Simulated(scenario, form, 4), scenario, form));
    EXPECT_GT(simulated.truth.bad.size(), 0u);
    // Terms of errors.json carry curves, crossed errors, ripples, a start and servos in the own form, and nothing in
    // the other.
    EXPECT_THAT(simulated.truth.effects, SizeIs(form == Form::kOwn ? 8 : 16));
    EXPECT_FALSE(simulated.truth.is_all_in_errors());
  }
}

// An effect more leaves what is drawn for the others as it was.
TEST(Scenario, DrawsOfOneThingDoNotMoveOthers) {
  const Scenario one = Read(R"("effects": [{"kind": "curve", "symbol": "EYX", "rms": 3}])");
  const Scenario two = Read(
      R"("effects": [{"kind": "curve", "symbol": "EYX", "rms": 3}, {"kind": "curve", "symbol": "EZX", "rms": 1e-6}])");
  const std::vector<double> a = Column(Simulated(one).measured.fit[0], "dx_mm"),
                            b = Column(Simulated(two).measured.fit[0], "dx_mm");
  for (size_t k = 0; k < a.size(); ++k) EXPECT_NEAR(a[k], b[k], 1e-7);
}

TEST(Scenario, TruthIsTheChainsAndAllInErrorsWhereItCanBe) {
  const Scenario scenario = Read(R"("errors": {"EX0C": 30, "EB0C": 40})");
  const SimulatedCase simulated = Simulated(scenario, Form::kIndependent);
  EXPECT_TRUE(simulated.truth.is_all_in_errors());
  History pose = testing::Moving({0.0}, {0.0});
  const ToolPointError error = ErrorsAlong(simulated.truth, {0, 0, -300}, pose)[0];
  // The table stands 30 um to +x and is turned by 40 urad about y: the tool stands to -x of it and, 300 mm below the
  // axis' point, EB x 300 mm more.
  EXPECT_NEAR(error.shift_mm.x(), -0.03 + 40e-6 * 300.0, 1e-6);
  EXPECT_NEAR(error.turn_rad.y(), -40e-6, 1e-12);
  EXPECT_NEAR(error.shift_mm.y(), 0.0, 1e-12);
}

TEST(Scenario, SessionsFollowEachOther) {
  const SimulatedCase simulated = Simulated(Read(R"("sampling": {"gap_s": 50})"));
  const auto times = [](const session::Session& session) { return Column(session, "t_s"); };
  EXPECT_EQ(times(simulated.measured.fit[0]).front(), 0.0);
  EXPECT_EQ(times(simulated.measured.fit[1]).front(), times(simulated.measured.fit[0]).back() + 50.0);
  EXPECT_EQ(times(simulated.measured.check[0]).front(), times(simulated.measured.fit[1]).back() + 50.0);
  for (size_t k = 1; k < simulated.history.size(); ++k)
    EXPECT_GE(simulated.history.time_s[k], simulated.history.time_s[k - 1]);
}

TEST(Scenario, SamplingIsIrregular) {
  const SimulatedCase simulated = Simulated(Read(R"("sampling": {"kept_share": 0.5, "time_jitter": 0.5})"));
  const std::vector<double>& times = Column(simulated.measured.fit[0], "t_s");
  EXPECT_GT(times.size(), 150u);
  EXPECT_LT(times.size(), 250u);
  std::set<long> steps;
  for (size_t k = 1; k < times.size(); ++k) {
    EXPECT_GT(times[k], times[k - 1]);
    steps.insert(std::lround(1e3 * (times[k] - times[k - 1])));
  }
  EXPECT_GT(steps.size(), 50u);
}

TEST(Scenario, TemperaturesAreWrittenWhereTheyAreRecorded) {
  const SimulatedCase simulated = Simulated(Read(
      R"("temperatures": [{"name": "temp_C", "start_C": 22, "C_per_h": 36},
                           {"name": "hidden", "recorded": false, "rise_C": 5}])"));
  const std::vector<double>& celsius = Column(simulated.measured.fit[0], "temp_C");
  EXPECT_NEAR(celsius[100], 22.0 + 36.0 * 50.0 / 3600.0, 1e-9);
  EXPECT_EQ(session::FindColumn(simulated.measured.fit[0], "hidden"), nullptr);
  EXPECT_TRUE(simulated.history.celsius.contains("hidden"));
  EXPECT_THAT(WritePoses(simulated.truth, BoxPoses(simulated, 2, 1)),
              HasSubstr("t_s,Z_mm,Y_mm,X_mm,B_deg,C_deg,temp_C\n"));
}

// Poses of the box are reached no faster than the sessions went: what a servo does beyond that nobody measured.
TEST(Scenario, BoxPosesKeepToMeasuredSpeeds) {
  const SimulatedCase simulated = Simulated(Read("\"note\": \"\""));
  const History poses = BoxPoses(simulated, 100, 1);
  const auto fastest = [](const History& history, int axis) {
    double speed = 0.0;
    for (size_t k = 0; k < history.size(); ++k) speed = std::max(speed, std::abs(history.AxisAt(k, axis).speed));
    return speed;
  };
  for (int axis = 0; axis < poses.axis_count; ++axis) {
    EXPECT_LE(fastest(poses, axis), fastest(simulated.history, axis) * (1.0 + 1e-9));
    EXPECT_GE(RangeOf(poses, axis).low, RangeOf(simulated.history, axis).low - 1e-4);
    EXPECT_LE(RangeOf(poses, axis).high, RangeOf(simulated.history, axis).high + 1e-4);
  }
}

TEST(Scenario, SessionsOfOneSetUpShareItsOffsets) {
  PlannedCase plan = Plan();
  plan.fit[0].header.push_back({"setup", "morning"});
  plan.check[0].header.push_back({"setup", "morning"});
  Scenario scenario = Read(R"("noise": {"sigma_scale": 0})");
  const SimulatedCase shared = RunScenario(Mt(), scenario, plan, Form::kOwn, 3).value();
  EXPECT_EQ(Column(shared.measured.fit[0], "dx_mm")[0], Column(shared.measured.check[0], "dx_mm")[0]);
  const SimulatedCase apart = Simulated(scenario);
  EXPECT_NE(Column(apart.measured.fit[0], "dx_mm")[0], Column(apart.measured.check[0], "dx_mm")[0]);
}

// Variance as stated whatever the tails; common to a pose where it is asked.
TEST(Noise, HasTheStatedSpread) {
  for (const char* const noise : {"{}", R"({"student_degrees": 5})", R"({"pose_share": 0.5})", R"({"ar1": 0.5})"}) {
    Scenario scenario = Read(std::string("\"noise\": ") + noise);
    scenario.noise.draw_setup = false;
    std::vector<double> all;
    for (uint64_t seed = 1; seed <= 10; ++seed) {
      for (const char* const column : {"dx_mm", "dy_mm", "dz_mm"}) {
        const std::vector<double> one = Column(Simulated(scenario, Form::kOwn, seed).measured.fit[0], column);
        all.insert(all.end(), one.begin(), one.end());
      }
    }
    EXPECT_NEAR(RmsAboutMean(all), 0.5e-3, 0.03e-3) << noise;  // 12,000 draws: 4 sigma of what t(5) gives
  }
  const Scenario heavy = Read(R"("noise": {"heavy_share": 0.1, "draw_setup": false})");
  // 1 + 0.1 (25 - 1) times the variance.
  EXPECT_NEAR(RmsAboutMean(Column(Simulated(heavy).measured.fit[0], "dx_mm")), 0.5e-3 * std::sqrt(3.4), 0.2e-3);
}

TEST(Noise, CommonToAPose) {
  PlannedCase plan = Plan();
  for (session::Column& column : plan.fit[0].columns) {  // every pose twice
    if (column.name == "t_s") continue;
    for (size_t k = 0; k < 200; ++k) column.values[200 + k] = column.values[k];
  }
  Scenario scenario = Read(R"("noise": {"pose_share": 1.0, "draw_setup": false})");
  const std::vector<double> read = Column(RunScenario(Mt(), scenario, plan, Form::kOwn, 3)->measured.fit[0], "dx_mm");
  for (size_t k = 0; k < 200; ++k) EXPECT_NEAR(read[k], read[200 + k], 1e-15);
  EXPECT_GT(RmsAboutMean(read), 0.3e-3);
}

TEST(Reader, NamesPlaceValueAndRule) {
  EXPECT_EQ(
      Refusal(R"("efects": [])"),
      "efects: unknown field, expected some of axiscal, effects, errors, faults, gravity, machine, noise, nominal, "
      "note, plan, sampling, temperatures");
  EXPECT_THAT(Refusal(R"("effects": [{"kind": "wiggle", "symbol": "EYX", "rms": 1}])"),
              HasSubstr("effects[0].kind: \"wiggle\", expected one of curve, time-curve, ripple"));
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "curve", "symbol": "EYX"}])"), "effects[0].rms: is missing");
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "curve", "symbol": "EYX", "rms": -3}])"),
            "effects[0].rms: -3, expected a number from 1e-06 to 10000");
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "curve", "symbol": "EYQ", "rms": 3}])"),
            "effects[0].symbol: EYQ: machine mt has no axis Q");
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "curve", "symbol": "EX0C", "rms": 3}])"),
            "effects[0].symbol: EX0C: a 0 means constant, which belongs into 'errors'");
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "curve", "symbol": "EZT", "rms": 3}])"),
            "effects[0].variable: is missing: the symbol names no axis");
  EXPECT_THAT(Refusal(R"("effects": [{"kind": "curve", "symbol": "EYX", "rms": 3, "length_deg": 3}])"),
              HasSubstr("effects[0].length_deg: unknown field, expected some of kind, length_mm"));
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "ripple", "symbol": "ECC", "rms": 3}])"), "effects[0].order: is missing");
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "crossed", "symbol": "EZX", "rms": 3, "variables": ["X", "X"]}])"),
            "effects[0].variables: expected two axes of machine mt");
  EXPECT_EQ(Refusal(R"("effects": [{"kind": "thermal", "symbol": "EZT", "rms": 3, "tau_s": 100}])"),
            "effects[0].channel: is missing, expected a temperature's name or \"time\"");
  EXPECT_THAT(Refusal(R"("errors": {"EX0Q": 3})"), HasSubstr("machine 'mt' has no axis Q"));
  EXPECT_EQ(Refusal(R"("gravity": [0, 0, -9.81])"), "gravity: [0,0,-9.81], expected three numbers within +-1");
  EXPECT_EQ(Refusal(R"("gravity": [0, 0, -0.5])"), "gravity: must have length 1: the direction in which things fall");
  EXPECT_EQ(Refusal(R"("noise": {"ar1": 1})"), "noise.ar1: 1, expected a number from 0 to 0.9999");
  EXPECT_EQ(Refusal(R"("noise": {"student_degrees": 2.5})"),
            "noise.student_degrees: 2.5, expected a number from 3 to 100");
  EXPECT_EQ(Refusal(R"("sampling": 3)"), "sampling: 3, expected an object");
  EXPECT_EQ(Refusal(R"("faults": [{"kind": "slip", "moved_um": [1, 2, 3]}])"),
            "faults[0].sessions: is missing, expected those in which it slips");
  EXPECT_EQ(Refusal(R"("faults": [{"kind": "clock", "delay_ms": 0}])"), "faults[0].delay_ms: 0, expected a delay");
  EXPECT_EQ(Refusal(R"("nominal": [{"kind": "pivot", "axis": "X", "offset_mm": [0, 0, 1]}])"),
            "nominal[0].axis: X is linear, expected a rotary axis");
  EXPECT_EQ(Refusal(R"("nominal": [{"kind": "direction", "axis": "Q"}])"),
            "nominal[0].axis: 'Q', expected an axis of machine mt");
  EXPECT_EQ(Refusal(R"("temperatures": [{"name": "spindle"}])"),
            "temperatures[0].name: 'spindle', expected temp_C or T_NAME_C, or \"recorded\": false");
  EXPECT_EQ(Refusal(R"("temperatures": [{"name": "temp_C"}, {"name": "temp_C"}])"),
            "temperatures: 'temp_C' is there twice");
  EXPECT_EQ(ReadScenario("{}", Mt()).status().message(), "expected an object with \"axiscal\": \"scenario/1\"");
}

TEST(Reader, PlansComeFromOnePlace) {
  const auto refusal = [](const std::string& members) {
    return std::string(ReadPlanSource(Json(members)).status().message());
  };
  const PlanSource tests = ReadPlanSource(Json(R"("machine": "m.json", "plan": {"tests": ["rtest-grid"],
      "tool_tip_mm": [0, 0, -300], "bar_mm": 150, "travel_deg": {"B": [-30, 90]}})"))
                               .value();
  EXPECT_EQ(tests.machine, "m.json");
  EXPECT_EQ(tests.tests, std::vector<std::string>{"rtest-grid"});
  EXPECT_EQ(tests.travel_deg[0].first, "B");
  EXPECT_EQ(tests.travel_deg[0].second[1], 90.0);
  EXPECT_EQ(ReadPlanSource(Json(R"("plan": {"case": "tuesday"})"))->case_folder, "tuesday");
  EXPECT_EQ(refusal(R"("machine": "m.json")"), "plan: expected one of 'case', 'fit' (session files) and 'tests'");
  EXPECT_EQ(refusal(R"("machine": "m.json", "plan": {"case": "a", "fit": ["b.csv"]})"),
            "plan: expected one of 'case', 'fit' (session files) and 'tests'");
  EXPECT_EQ(refusal(R"("plan": {"fit": ["b.csv"]})"),
            "machine: is missing, expected machine.json's name (a case folder has its own)");
  EXPECT_EQ(refusal(R"("machine": "m", "plan": {"tests": ["a"], "travel_deg": {"B": [90, 30]}})"),
            "plan.travel_deg.B: [90,30], expected [min, max] in deg");
  EXPECT_EQ(refusal(R"("plan": {"case": "a", "bar_mm": 100})"), "plan.bar_mm: expected 'tests' with it");
  EXPECT_THAT(refusal(R"("plan": {"cases": "a"})"), HasSubstr("plan: expected one of"));
}

TEST(Scenario, WhatDoesNotFitThePlanIsRefusedWithItsPlace) {
  EXPECT_EQ(
      RunScenario(
          Mt(),
          Read(R"("effects": [{"kind": "thermal", "symbol": "EZT", "rms": 3, "tau_s": 100, "channel": "temp_C"}])"),
          Plan(), Form::kOwn, 1)
          .status()
          .message(),
      "effects[0]: EZT:thermal(temp_C): the plan has no temperature 'temp_C'");
  EXPECT_EQ(RunScenario(Mt(), Read("\"note\": \"\""), {}, Form::kOwn, 1).status().message(),
            "plan: no sessions, expected at least one");
}

}  // namespace
}  // namespace axiscal::synthetic
