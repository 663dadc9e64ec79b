#include "core/figures/eccentricities.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/units.h"
#include "core/instruments/evaluation.h"
#include "core/machine/error_json.h"
#include "core/machine/testing/machines.h"
#include "core/plan/test.h"
#include "core/session/read_session.h"
#include "core/session/write_session.h"
#include "core/synthetic/simulate.h"

namespace axiscal::figures {
namespace {

using ::testing::HasSubstr;

machine::Machine TracedMachine() { return machine::testing::MultiTasking(); }

session::Session Traced(const std::string& pattern, const machine::ErrorModel& truth) {
  plan::Mounted mounted;
  mounted.tips_mm = {{0, 0, -350}};
  mounted.balls_mm = {{50, 0, 65}};
  static const machine::Machine machine = TracedMachine();
  const auto planned = plan::FindPlanned(plan::SituationOfMachine(machine, mounted), pattern);
  EXPECT_TRUE(planned.has_value()) << pattern;
  synthetic::NoiseOptions exact;
  exact.sigma_scale = 0.0;
  exact.draw_setup = false;
  return synthetic::Simulate(machine, truth, planned->session, exact).value();
}

// The file's eccentricities are those that the instrument `eccentricity` predicts of the same machine, per run and
// sense: backlash parts the senses.
TEST(Eccentricities, TheFileHoldsWhatTheInstrumentPredicts) {
  const machine::ErrorModel truth =
      machine::ReadErrors(R"({"EX0C": 30, "EY0C": -20, "EB0B": 40, "EA0C": 25, "EB0C": -35,
          "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 8}]})",
                          TracedMachine())
          .value();
  std::vector<session::Session> traces;
  for (const char* const pattern : {"BX-350", "CR-350", "CA-350"}) traces.push_back(Traced(pattern, truth));
  // One mounting each, as planned; those of one are put together.
  int held = 0;
  for (const session::Session& trace : traces) {
    const auto made = EccentricitySession(TracedMachine(), {trace}, "ecc");
    ASSERT_TRUE(made.ok()) << made.status();
    const auto text = session::WriteSession(*made);
    ASSERT_TRUE(text.ok()) << text.status();
    const auto read = session::ReadSessionText(*text, "ecc.csv");
    ASSERT_TRUE(read.ok()) << read.status();
    const auto run = instruments::BindSession(*read, TracedMachine());
    ASSERT_TRUE(run.ok()) << run.status();
    EXPECT_GE(run->reading_count(), 4) << "two components there and back";
    for (int k = 0; k < run->reading_count(); ++k) {
      double predicted_mm = NAN;
      const double no_setup[instruments::kMaxSetupParameters] = {};
      instruments::Evaluation evaluation;
      instruments::EvaluateAlongPath(
          TracedMachine(), *run, k,
          [&](const shapes::State& state) { return machine::ErrorsAt(TracedMachine(), truth, state); }, no_setup,
          &evaluation, [](const shapes::State&, const instruments::Evaluation&, double) {});
      predicted_mm = evaluation.predicted_mm[0];
      constexpr double kToleranceUm = 0.3;  // steps of the plan against a degree, the turnaround of backlash
      EXPECT_NEAR(run->measured_mm(0, k) * base::kUmPerMm, predicted_mm * base::kUmPerMm, kToleranceUm) << k;
      ++held;
    }
  }
  EXPECT_GE(held, 12);
}

TEST(Eccentricities, FiguresAndRefusals) {
  const machine::ErrorModel truth = machine::ReadErrors(R"({"EX0C": 30})", TracedMachine()).value();
  const session::Session trace = Traced("CR-350", truth);
  const auto run = instruments::BindSession(trace, TracedMachine()).value();
  const Figures figures = FiguresOf(TracedMachine(), {run});
  ASSERT_EQ(figures.tests.size(), 1u);
  EXPECT_EQ(figures.tests[0].kind, "eccentricity");
  EXPECT_THAT(figures.tests[0].what, HasSubstr("eccentricity, C "));
  EXPECT_EQ(figures.tests[0].figures[0].symbol, "ex(up)");
  EXPECT_NEAR(std::abs(figures.tests[0].figures[0].value_mm), 30e-3, 0.5e-3);  // the table of Yao 2022: dxCZ
  session::Session other = trace;
  for (session::HeaderEntry& entry : other.header)
    if (entry.key == "bar_length_mm") entry.value = "101";
  EXPECT_THAT(EccentricitySession(TracedMachine(), {trace, other}, "e").status().message(),
              HasSubstr("expected one mounting"));
  const session::Session circle = Traced("ballbar-circle", truth);
  EXPECT_THAT(EccentricitySession(TracedMachine(), {circle}, "e").status().message(),
              HasSubstr("not one rotary axis turns"));
}

}  // namespace
}  // namespace axiscal::figures
