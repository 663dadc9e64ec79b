#include "core/decide/decide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/identify/testing/scenario.h"
#include "core/instruments/evaluation.h"

namespace axiscal::decide {
namespace {

using ballbar::Pattern;
using identify::testing::Errors;
using identify::testing::Measure;
using identify::testing::Measured;
using instruments::MeasuringRun;
using loop::Report;
using loop::Verdict;

const machine::Machine kMachine = machine::testing::MultiTasking();
constexpr char kDeclared[] =
    R"("EA0B": 40, "EC0B": -61, "EB0B": 20.5, "EX0C": -22.2, "EY0C": 15.3, "EA0C": -42.9, "EB0C": 45.6, "EZ0T": 29.9)";
const std::vector<Measured> kCheckPatterns = {{"BZ", Pattern::kBZ, 380.0}, {"CT", Pattern::kCT, 380.0}};

struct Sessions {
  std::vector<MeasuringRun> fit, check;
};

Sessions MeasureWith(const std::string& effects, uint64_t seed = 1, double step_deg = 2.0) {
  const machine::ErrorModel truth = Errors(kMachine, "{" + std::string(kDeclared) + ", \"terms\": [" + effects + "]}");
  synthetic::NoiseOptions noise;
  noise.seed = seed;
  ballbar::PatternOptions options;
  options.step_deg = step_deg;
  Sessions sessions;
  const auto fit = Measure(kMachine, truth, noise, identify::testing::FivePatterns(), options);
  sessions.fit = *identify::BindSessions(kMachine, fit);
  noise.seed += 1000;
  options.start_s += 7200.0;
  const auto check = Measure(kMachine, truth, noise, kCheckPatterns, options);
  sessions.check = *identify::BindSessions(kMachine, check);
  return sessions;
}

Report Close(const Sessions& sessions) { return Decide(kMachine, sessions.fit, sessions.check).value(); }

std::string NamesOf(const Report& report) {
  std::string names;
  for (const loop::Effect& effect : report.effects) names += machine::NameOf(kMachine, effect.term) + "; ";
  for (const loop::Unexplained& part : report.unexplained) names += part.session + " " + part.variable + "; ";
  return names;
}

bool Names(const loop::Effect& effect, const std::string& name) {
  if (machine::NameOf(kMachine, effect.term) == name) return true;
  for (const machine::ErrorTerm& other : effect.equivalent)
    if (machine::NameOf(kMachine, other) == name) return true;
  return false;
}

TEST(Decide, AMachineThatLacksNothingIsLeftAlone) {
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    const Report report = Close(MeasureWith("", seed));
    EXPECT_EQ(report.verdict, Verdict::kAdequate) << NamesOf(report);
    EXPECT_GT(report.candidates, 1000);
    EXPECT_TRUE(report.has_check);
  }
}

TEST(Decide, EffectsAreNamedWithTheirAmplitudesAndNothingBeside) {
  const Report report = Close(MeasureWith(R"({"symbol": "EXX", "shape": "backlash", "amplitude": -2.9},
      {"symbol": "EYY", "shape": "reversal", "amplitude": 5, "length_mm": 5.5})"));
  ASSERT_EQ(report.effects.size(), 2u) << NamesOf(report);
  const bool is_first = Names(report.effects[0], "EXX:backlash");
  const loop::Effect &backlash = report.effects[is_first ? 0 : 1], &reversal = report.effects[is_first ? 1 : 0];
  EXPECT_TRUE(Names(backlash, "EXX:backlash")) << NamesOf(report);
  EXPECT_TRUE(Names(reversal, "EYY:reversal")) << NamesOf(report);
  EXPECT_NEAR(backlash.amplitude, -2.9e-3, 3.0 * backlash.amplitude_sigma);
  EXPECT_NEAR(*shapes::NonlinearParameter(reversal.term.shape), 5.5, 1.0);
  EXPECT_EQ(report.verdict, Verdict::kExtended);
  EXPECT_FALSE(report.is_check_fitted);
  constexpr double kSigmaMm = 0.3e-3;
  EXPECT_NEAR(report.fit_after.rms_mm, kSigmaMm, 0.05 * kSigmaMm);
  EXPECT_NEAR(report.check_after.rms_mm, kSigmaMm, 0.07 * kSigmaMm);
  EXPECT_LT(report.check_after.rms_mm, report.check_before.rms_mm);
  EXPECT_GE(report.steps.size(), 2u);
}

// Dense readings are searched in sums of neighbours: what these do not tell is looked for in the readings themselves.
TEST(Decide, DenseReadingsShowWhatIsFinerThanTheirSums) {
  const machine::ErrorModel truth = Errors(kMachine, "{" + std::string(kDeclared) + R"(, "terms": [
      {"symbol": "EXX", "shape": "backlash", "amplitude": -2.9},
      {"symbol": "EXC", "shape": "harmonic", "order": 250, "amplitude": 0.4, "phase_deg": 30}]})");
  ballbar::PatternOptions options;
  options.step_deg = 0.1;
  Sessions sessions;
  sessions.fit = *identify::BindSessions(
      kMachine, Measure(kMachine, truth, synthetic::NoiseOptions(), identify::testing::FivePatterns(), options));
  const Report report = Close(sessions);
  ASSERT_EQ(report.effects.size(), 2u) << NamesOf(report);
  EXPECT_TRUE(Names(report.effects[0], "EXX:backlash") || Names(report.effects[1], "EXX:backlash")) << NamesOf(report);
  EXPECT_TRUE(Names(report.effects[0], "EXC:harmonic(250)") || Names(report.effects[1], "EXC:harmonic(250)"))
      << NamesOf(report);
}

// Without the column a session has 20 degrees in its place: an error is not told from that, whoever lacks it.
TEST(Decide, NoErrorFollowsATemperatureThatASessionDidNotRecord) {
  Sessions sessions = MeasureWith(R"({"symbol": "EZT", "shape": "drift", "amplitude": 40})");
  for (std::vector<MeasuringRun>* part : {&sessions.fit, &sessions.check}) {
    for (MeasuringRun& run : *part) {
      run.has_temperature = true;
      for (int k = 0; k < run.reading_count(); ++k) run.temperature_celsius[k] = 22.0 + 1e-3 * run.time_s[k];
    }
  }
  const auto follows = [](const Report& report) {
    bool any = false;
    for (const loop::Effect& effect : report.effects) {
      any |= machine::NameOf(kMachine, effect.term).find("thermal") != std::string::npos;
      for (const machine::ErrorTerm& term : effect.equivalent)
        any |= machine::NameOf(kMachine, term).find("thermal") != std::string::npos;
    }
    return any;
  };
  EXPECT_TRUE(follows(Close(sessions)));
  for (MeasuringRun* const lacks : {&sessions.fit[1], &sessions.check[0]}) {
    const MeasuringRun whole = *lacks;
    lacks->has_temperature = false;
    std::fill(lacks->temperature_celsius.begin(), lacks->temperature_celsius.end(), 20.0);
    const Report report = Close(sessions);
    ASSERT_FALSE(report.effects.empty());
    EXPECT_FALSE(follows(report)) << NamesOf(report);
    *lacks = whole;
  }
}

// The tool grows by 3 um per K of a body that follows the recorded temperature with 1500 s. Neither a drift nor the
// temperature itself does so. Sessions last up to twelve minutes: what stays the same through a session is set-up.
TEST(Decide, ALateWarmthIsNamedWithItsChannelAndItsTimeConstant) {
  Sessions sessions = MeasureWith("");
  for (std::vector<MeasuringRun>* part : {&sessions.fit, &sessions.check}) {
    for (MeasuringRun& run : *part) {
      run.has_temperature = true;
      constexpr double kSlower = 7.5;
      const double start_s = run.time_s.front();
      for (int k = 0; k < run.reading_count(); ++k) {
        run.time_s[k] = start_s + kSlower * (run.time_s[k] - start_s);
        run.temperature_celsius[k] =
            20.0 + 8.0 * (1.0 - std::exp(-run.time_s[k] / 1200.0)) + 3.0 * std::sin(run.time_s[k] / 300.0);
      }
      instruments::DeriveMotion(&run);
    }
  }
  instruments::ShareTemperatures({&sessions.fit, &sessions.check});
  constexpr double kTauS = 1500.0, kPerKelvinMm = 3e-3;
  const shapes::ThermalLag late{"temp_C", kTauS};
  const int along_z = machine::kComponents * kMachine.tool_joint() + static_cast<int>(machine::Component::kZ);
  for (std::vector<MeasuringRun>* part : {&sessions.fit, &sessions.check}) {
    for (MeasuringRun& run : *part) {
      const std::vector<double> setup(run.setup.size(), 0.0);
      instruments::Evaluation evaluation;
      for (int k = 0; k < run.reading_count(); ++k) {
        instruments::Evaluate(kMachine, run, k, {}, setup.data(), &evaluation);
        run.measured_mm.col(k) +=
            kPerKelvinMm * (late.LateAt(run.StateOf(k), kTauS).celsius - 20.0) * evaluation.by_error.col(along_z);
      }
    }
  }
  const Report report = Close(sessions);
  ASSERT_EQ(report.effects.size(), 1u) << NamesOf(report);
  const loop::Effect& effect = report.effects[0];
  EXPECT_TRUE(Names(effect, "EZT:thermal-lag(temp_C)")) << NamesOf(report);
  const auto* found = std::get_if<shapes::ThermalLag>(&effect.term.shape);
  ASSERT_NE(found, nullptr) << NamesOf(report);
  EXPECT_NEAR(found->tau_s, kTauS, 0.15 * kTauS);
  EXPECT_NEAR(std::abs(effect.amplitude), kPerKelvinMm, std::max(4.0 * effect.amplitude_sigma, 0.05 * kPerKelvinMm));
  EXPECT_GT(found->from_celsius, 19.0);
  EXPECT_LT(found->to_celsius, 32.0);
  // These sessions do not tell it from others well enough: to correct it could do harm.
  ASSERT_EQ(report.held_back.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<shapes::ThermalLag>(report.held_back[0].term.shape));
  EXPECT_GT(report.held_back[0].harm, 0.05);
  EXPECT_EQ(report.fitted.model.terms.size(), report.declared.terms.size());
  EXPECT_LT(report.check_after.rms_mm, 0.33e-3);
}

// The ripple of a drive that is no whole number per turn of the table; readings every 2 deg tell it from all others
// that are likely.
TEST(Decide, ARippleOfBrokenOrderIsNamedWithIt) {
  constexpr double kOrder = 13.3;
  const Report report =
      Close(MeasureWith(R"({"symbol": "EXC", "shape": "harmonic", "order": 13.3, "amplitude": 3, "phase_deg": 40})"));
  ASSERT_EQ(report.effects.size(), 1u) << NamesOf(report);
  const auto* found = std::get_if<shapes::Harmonic>(&report.effects[0].term.shape);
  ASSERT_NE(found, nullptr) << NamesOf(report);
  EXPECT_NEAR(found->frequency, kOrder, 0.02);
  EXPECT_EQ(machine::SymbolOf(kMachine, report.effects[0].term), "EXC");
  EXPECT_TRUE(report.held_back.empty());
  EXPECT_TRUE(report.volumetric->is_gain_held);
}

// Readings every 10 deg do not tell 31.2 per turn from 4.8: both stand in the class, and neither is corrected.
TEST(Decide, ARippleThatThePositionsDoNotTellFromAnotherIsHeldBack) {
  const Report report = Close(MeasureWith(
      R"({"symbol": "EXC", "shape": "harmonic", "order": 31.2, "amplitude": 9, "phase_deg": 40})", 1, 10.0));
  const loop::Effect* ripple = nullptr;
  for (const loop::Effect& effect : report.effects)
    if (std::holds_alternative<shapes::Harmonic>(effect.term.shape)) ripple = &effect;
  ASSERT_NE(ripple, nullptr) << NamesOf(report);
  bool has_truth = false;
  for (const machine::ErrorTerm& other : ripple->equivalent) {
    const auto* image = std::get_if<shapes::Harmonic>(&other.shape);
    has_truth |= image != nullptr && std::abs(image->frequency - 31.2) < 0.1;
  }
  EXPECT_TRUE(has_truth) << NamesOf(report);
  ASSERT_FALSE(report.held_back.empty()) << NamesOf(report);
  EXPECT_FALSE(report.volumetric->is_gain_held);
}

// A smooth straightness that no harmonic or power is: one curve, and what it is beyond its numbers.
TEST(Decide, ASmoothErrorOfNoNamedShapeIsOneCurve) {
  std::string nodes, values;
  for (int i = 0; i <= 40; ++i) {
    const double x = -200.0 + 10.0 * i,
                 value = 6.0 * std::tanh(x / 25.0) - 3.0 * std::exp(-(x - 60) * (x - 60) / 900.0);
    absl::StrAppend(&nodes, i == 0 ? "" : ", ", x);
    absl::StrAppend(&values, i == 0 ? "" : ", ", value);
  }
  const std::string map = absl::StrCat(R"({"symbol": "EYX", "shape": "tabulated", "nodes_mm": [)", nodes,
                                       R"(], "values": [)", values, "]}");
  const Report report = Close(MeasureWith(map));
  ASSERT_FALSE(report.effects.empty()) << NamesOf(report);
  ASSERT_EQ(report.effects.size(), 1u) << NamesOf(report);
  EXPECT_TRUE(report.unexplained.empty()) << NamesOf(report);
  const loop::Effect& curve = report.effects.front();
  EXPECT_EQ(machine::NameOf(kMachine, curve.term), "EYX:curve") << NamesOf(report);
  EXPECT_GT(curve.term.prior_sigma, 0.3e-3);
  EXPECT_LT(curve.term.prior_sigma, 0.1);
  EXPECT_GT(curve.evidence, 100.0);  // its line is a squareness, too: the amplitude is not known as well as the shape
  // The fit sessions hardly tell that line from the squareness, and the check sessions see the two in other ways.
  EXPECT_LT(report.check_after.rms_mm, 0.5 * report.check_before.rms_mm);
  EXPECT_TRUE(report.volumetric->is_gain_held);
}

// The ball on the table moved by 2 um in a part of one session, in which two readings are bad, too.
TEST(Decide, ASlipIsToldWithItsSessionAndMomentAndBadReadingsAreListed) {
  Sessions sessions = MeasureWith("");
  MeasuringRun& run = sessions.fit[2];
  constexpr int kMoment = 80, kBad = 30;
  for (int k = kMoment; k < run.reading_count(); ++k) run.measured_mm(0, k) += 2e-3;
  run.measured_mm(0, kBad) += 30e-3;
  run.measured_mm(0, kBad + 1) += 30e-3;
  const Report report = Close(sessions);
  EXPECT_EQ(report.verdict, Verdict::kUnexplained);
  ASSERT_EQ(report.unexplained.size(), 1u) << NamesOf(report);
  const loop::Unexplained& slip = report.unexplained[0];
  EXPECT_EQ(slip.kind, loop::Unexplained::kSlip);
  EXPECT_EQ(slip.session, run.session);
  EXPECT_LE(slip.from, run.time_s[kMoment]);
  EXPECT_GE(slip.to, run.time_s[kMoment - 1]);
  ASSERT_TRUE(slip.slip.has_value());
  EXPECT_EQ(slip.slip->carrier, instruments::Carrier::kTable);
  EXPECT_TRUE(report.effects.empty()) << NamesOf(report);
  EXPECT_EQ(report.fitted.outliers.size(), 2u);
}

// A ball that moves six times in one session, to and fro: a session holds three slips, the others stay as what the
// model does not explain.
TEST(Decide, ASessionInWhichTheBallSlipsAgainAndAgainIsUnexplained) {
  Sessions sessions = MeasureWith("");
  MeasuringRun& run = sessions.fit[2];
  const double steps_mm[] = {4e-3, -7e-3, 9e-3, -8e-3, 6e-3, -9e-3};
  const int part = run.reading_count() / 7;
  for (int i = 0; i < 6; ++i)
    for (int k = (i + 1) * part; k < run.reading_count(); ++k) run.measured_mm(0, k) += steps_mm[i];
  const Report report = Close(sessions);
  EXPECT_EQ(report.verdict, Verdict::kUnexplained);
  int slips = 0;
  for (const loop::Unexplained& one : report.unexplained) slips += one.kind == loop::Unexplained::kSlip;
  EXPECT_LE(slips, instruments::kMaxSlips);
}

// What is read late, or too long as it warms up, is told as a fault of the ball bar; no error of the machine stands for
// it, and the report of it says so.
TEST(Decide, AnInstrumentAtFaultIsNotBlamedOnTheMachine) {
  Sessions sessions = MeasureWith("");
  for (std::vector<MeasuringRun>* runs : {&sessions.fit, &sessions.check}) {
    for (MeasuringRun& run : *runs) {
      for (int k = 0; k < run.reading_count(); ++k)
        run.measured_mm(0, k) -= 3e-3 * std::expm1(-(run.time_s[k] - run.time_s[0]) / 20.0);
    }
  }
  const Report report = Close(sessions);
  EXPECT_TRUE(report.effects.empty()) << NamesOf(report);
  ASSERT_EQ(report.causes.size(), 1u) << NamesOf(report);
  const loop::Cause& cause = report.causes[0];
  EXPECT_EQ(cause.kind, loop::Cause::kInstrument);
  EXPECT_EQ(cause.subject.find("ballbar: its growth after each session's start, within "), 0u) << cause.subject;
  EXPECT_NE(cause.subject.find(sessions.fit[0].session), std::string::npos) << cause.subject;
  EXPECT_EQ(cause.correction.find("let the instrument warm up; it grows by: +"), 0u) << cause.correction;
  EXPECT_GT(cause.evidence, 100.0);
  EXPECT_EQ(report.verdict, Verdict::kAdequate);
  const reports::Loop written = loop::ReportOf(kMachine, report);
  const auto read = reports::ReadLoop(reports::ToJson(written));
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->causes.size(), 1u);
  EXPECT_EQ(read->causes[0].subject, cause.subject);
  EXPECT_EQ(read->causes[0].kind, reports::CauseKind::kInstrument);
}

// An axis that machine.json has turn the other way, and columns that have each other's numbers in one session, are told
// with their correction before any error is looked for.
TEST(Decide, WrongNominalDataAreToldBeforeAnyErrorIsLookedFor) {
  const Sessions sessions = MeasureWith("");
  machine::Machine described = kMachine;
  const int b = machine::FindAxis(described, "B");
  described.axes[b].direction = -described.axes[b].direction;
  const auto flipped = Decide(described, sessions.fit, sessions.check);
  ASSERT_TRUE(flipped.ok()) << flipped.status();
  ASSERT_EQ(flipped->causes.size(), 1u) << flipped->fit_before.rms_mm << " mm; " << NamesOf(*flipped);
  EXPECT_EQ(flipped->causes[0].kind, loop::Cause::kNominal);
  EXPECT_EQ(flipped->causes[0].subject, "machine.json: axis B turns the other way");
  EXPECT_EQ(flipped->causes[0].correction, "axis B: \"direction\": [0, 1, 0], or turn the sign of column B");
  EXPECT_TRUE(flipped->effects.empty());
  EXPECT_TRUE(flipped->steps.empty());
  EXPECT_EQ(flipped->verdict, Verdict::kUnexplained);
  EXPECT_FALSE(flipped->volumetric) << "the box of a machine that is described wrongly";

  Sessions swapped = sessions;
  MeasuringRun& run = swapped.fit[3];
  const int x = machine::FindAxis(kMachine, "X"), y = machine::FindAxis(kMachine, "Y");
  for (int k = 0; k < run.reading_count(); ++k)
    std::swap(run.positions[static_cast<size_t>(k * run.axis_count + x)],
              run.positions[static_cast<size_t>(k * run.axis_count + y)]);
  instruments::DeriveMotion(&run);
  const auto exchanged = Decide(kMachine, swapped.fit, swapped.check);
  ASSERT_TRUE(exchanged.ok()) << exchanged.status();
  ASSERT_EQ(exchanged->causes.size(), 1u) << NamesOf(*exchanged);
  EXPECT_EQ(exchanged->causes[0].subject, "session '" + run.session + "': columns Y and X have each other's numbers");
  EXPECT_TRUE(exchanged->effects.empty());
}

// A tool that is shorter than its session states is an error like others, and a cause.
TEST(Decide, AConstantThatIsLargerThanAnyErrorIsANominalOne) {
  Sessions sessions = MeasureWith("");
  for (std::vector<MeasuringRun>* runs : {&sessions.fit, &sessions.check})
    for (MeasuringRun& run : *runs) run.tip_mm.z() -= 0.8;
  const auto report = Decide(kMachine, sessions.fit, sessions.check);
  ASSERT_TRUE(report.ok()) << report.status();
  ASSERT_EQ(report->causes.size(), 1u) << NamesOf(*report);
  EXPECT_EQ(report->causes[0].subject, "the sessions' headers: the tool point along the tool");
  // By 0.8 mm and the tool's own error of 0.0299 mm.
  EXPECT_EQ(report->causes[0].correction.find("add 0.82"), 0u) << report->causes[0].correction;
  EXPECT_NE(report->causes[0].correction.find("to coordinate Z of \"tool_tip_mm\""), std::string::npos);
  EXPECT_TRUE(report->effects.empty()) << NamesOf(*report);
}

TEST(Decide, ASearchThatIsCancelledSaysSo) {
  const Sessions sessions = MeasureWith(R"({"symbol": "EXX", "shape": "backlash", "amplitude": -2.9})");
  Options options;
  int asked = 0;
  options.cancelled = [&asked] { return ++asked > 25; };
  EXPECT_EQ(Decide(kMachine, sessions.fit, sessions.check, options).status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace axiscal::decide
