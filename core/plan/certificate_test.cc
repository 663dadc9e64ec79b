#include "core/plan/certificate.h"

#include <gmock/gmock.h>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/machine/testing/machines.h"
#include "core/plan/state_setups.h"
#include "core/plan/survey.h"
#include "core/predict/tool_point.h"
#include "core/synthetic/simulate.h"

namespace axiscal::plan {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

Situation Situated(const machine::Machine& machine) {
  Mounted mounted;
  mounted.tips_mm = {{0, 0, -350}};
  mounted.balls_mm = {{50, 0, 65}};
  return SituationOfMachine(machine, mounted);
}

predict::Workspace Over(const machine::Machine& machine) {
  predict::Workspace workspace;
  workspace.tip_mm = {0, 0, -350};
  for (const machine::Axis& axis : machine.axes) {
    const double half = axis.kind == machine::AxisKind::kLinear ? 200.0 : 1.0;
    workspace.box.low.push_back(-half);
    workspace.box.high.push_back(half);
  }
  return workspace;
}

std::vector<session::Session> Planned(const Situation& situation, const std::vector<std::string>& names) {
  std::vector<session::Session> sessions;
  for (const std::string& name : names) sessions.push_back(FindPlanned(situation, name).value().session);
  return sessions;
}

// What is certified is what happens: of many measured runs, standard deviations as certified, and the tool point's
// error that is left stays within the certified one in 95 of 100.
TEST(Certificate, IsWhatManyMeasuredRunsScatterBy) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Situation situation = Situated(machine);
  const auto model = ErrorsToJudge(machine, {"EX0C", "EY0C", "EA0C", "EB0C"}).value();
  const std::vector<session::Session> plan = Planned(situation, {"nest-table", "nest-table-out"});
  const predict::Workspace workspace = Over(machine);
  const auto certificate = Certify(machine, model, plan, workspace);
  ASSERT_TRUE(certificate.ok()) << certificate.status();
  ASSERT_EQ(certificate->errors.size(), 4u);
  EXPECT_THAT(certificate->unseen, ::testing::IsEmpty());
  machine::ErrorModel truth = model;
  for (size_t i = 0; i < truth.terms.size(); ++i)
    truth.terms[i].amplitude[0] = (i % 2 == 0 ? 30.0 : -20.0) * certificate->errors[i].factor;
  identify::Options options;
  options.model = model;
  options.scale_uncertainties = false;
  constexpr int kRuns = 300;
  Eigen::Vector4d squares = Eigen::Vector4d::Zero();
  int within = 0;
  const predict::BoxPoses poses(workspace);
  for (int run = 0; run < kRuns; ++run) {
    std::vector<session::Session> measured;
    for (size_t k = 0; k < plan.size(); ++k) {
      synthetic::NoiseOptions noise;
      noise.seed = 1000 + 10 * run + k;
      measured.push_back(synthetic::Simulate(machine, truth, plan[k], noise).value());
    }
    const auto fit = identify::FitSessions(machine, measured, options);
    ASSERT_TRUE(fit.ok()) << fit.status();
    machine::ErrorModel off = model;
    for (int i = 0; i < 4; ++i) {
      off.terms[i].amplitude[0] = fit->result.estimates[i].value - truth.terms[i].amplitude[0];
      squares[i] += std::pow(off.terms[i].amplitude[0] / certificate->errors[i].sigma, 2);
    }
    const machine::KnownErrors left{off, {}};
    predict::ToolPoint tool(machine, left, workspace.tip_mm);
    double longest_mm = 0.0;
    for (int k = 0; k < poses.count(); ++k)
      longest_mm = std::max(longest_mm, tool.ErrorAt(poses.At(k)).head<3>().norm());
    within += longest_mm <= certificate->as_programmed.chance.max_mm ? 1 : 0;
  }
  // The scatter of a standard deviation from 300 runs is 4 %; of a share of 0.95, 1.3 %.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(std::sqrt(squares[i] / kRuns), 1.0, 0.13) << certificate->errors[i].name;
  EXPECT_NEAR(static_cast<double>(within) / kRuns, 0.95, 0.04);
  EXPECT_LT(certificate->set_anew.chance.rms_mm, certificate->as_programmed.chance.rms_mm);
  EXPECT_FALSE(certificate->as_programmed.by.empty());
}

// A ball whose place nobody knows, at one place of the table: where C stands goes with it.
TEST(Certificate, NamesWhatStaysUnseenAndWhatItDoes) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Situation situation = Situated(machine);
  const auto model = ErrorsToJudge(machine, {"EX0C", "EX0T"}).value();
  const auto certificate = Certify(machine, model, Planned(situation, {"ballbar-circle"}), Over(machine));
  ASSERT_TRUE(certificate.ok()) << certificate.status();
  ASSERT_EQ(certificate->unseen.size(), 2u);
  for (const identify::Estimate& error : certificate->errors) EXPECT_FALSE(error.identifiable) << error.name;
  // C's place turns with the table, and no offset takes up more than a part; a shift of the tool is set anew.
  const bool is_first = certificate->unseen[0].of == "EX0C";
  const Unseen &of_c = certificate->unseen[is_first ? 0 : 1], &of_tool = certificate->unseen[is_first ? 1 : 0];
  EXPECT_EQ(of_c.of, "EX0C");
  EXPECT_EQ(of_tool.of, "EX0T");
  EXPECT_NEAR(of_c.as_programmed_mm, 1e-3, 1e-6);
  EXPECT_GT(of_c.set_anew_mm, 0.1e-3);
  EXPECT_NEAR(of_tool.as_programmed_mm, 1e-3, 1e-6);
  EXPECT_EQ(of_tool.set_anew_mm, 0.0);
  EXPECT_EQ(certificate->as_programmed.chance.max_mm, 0.0);
}

TEST(Certificate, WhatIsStatedOfASetUpIsKnowledge) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Situation situation = Situated(machine);
  const auto model = ErrorsToJudge(machine, {"EX0T", "EZ0T"}).value();
  std::vector<session::Session> plan = Planned(situation, {"nest-table"});
  EXPECT_FALSE(Certify(machine, model, plan, Over(machine))->errors[1].identifiable);
  ASSERT_TRUE(StateSetups(machine, {"ball_z 2"}, {&plan[0]}).ok());
  EXPECT_EQ(session::FindHeader(plan[0], "ball_z_sigma_um"), "2");
  const auto stated = Certify(machine, model, plan, Over(machine));
  ASSERT_TRUE(stated->errors[1].identifiable);
  EXPECT_NEAR(stated->errors[1].sigma, 2e-3, 0.1e-3);
  ASSERT_TRUE(StateSetups(machine, {"ball_z 3"}, {&plan[0]}).ok());
  EXPECT_NEAR(Certify(machine, model, plan, Over(machine))->errors[1].sigma, 3e-3, 0.1e-3);
  EXPECT_THAT(
      StateSetups(machine, {"bar_length 2"}, {&plan[0]}).message(),
      HasSubstr("no session of the plan has a set-up offset bar_length, expected one of ball_x, ball_y, ball_z"));
  for (const char* wrong : {"ball_z", "ball_z -1", "ball_z 0", "ball_z 1 2", "ball_z x"})
    EXPECT_THAT(StateSetups(machine, {wrong}, {&plan[0]}).message(), HasSubstr("expected \"OFFSET SIGMA\"")) << wrong;
}

// A certificate holds what is not known of the artefact: faces that are touched in the same way at every pose show how
// they stand out, so that the errors are hardly worse known; they are no better known in any case.
TEST(Certificate, WhatIsStatedOfAnArtefactsFeatures) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Situation situation = Situated(machine);
  const auto model = ErrorsToJudge(machine, {"EX0C", "EY0C", "EA0C", "EB0C"}).value();
  std::vector<session::Session> plan = Planned(situation, {"touch-columns"});
  const auto exact = Certify(machine, model, plan, Over(machine));
  ASSERT_TRUE(exact.ok()) << exact.status();
  ASSERT_TRUE(StateSetups(machine, {"feature 5"}, {&plan[0]}).ok());
  EXPECT_EQ(session::FindHeader(plan[0], "feature_sigma_um"), "5");
  const auto known = Certify(machine, model, plan, Over(machine));
  ASSERT_TRUE(known.ok()) << known.status();
  ASSERT_EQ(known->errors.size(), 4u);
  for (size_t i = 0; i < known->errors.size(); ++i) {
    ASSERT_TRUE(known->errors[i].identifiable) << i;
    EXPECT_GE(known->errors[i].sigma, exact->errors[i].sigma * (1.0 - 1e-9)) << i;
  }
  ASSERT_TRUE(StateSetups(machine, {"feature 2"}, {&plan[0]}).ok());  // in its place
  EXPECT_EQ(session::FindHeader(plan[0], "feature_sigma_um"), "2");
}

// The fewest minutes: a smaller uncertainty takes longer, and what no test reaches is said.
TEST(Certificate, FewestMinutesForAWantedUncertainty) {
  const machine::Machine machine = machine::testing::MultiTasking();
  const Situation situation = Situated(machine);
  Survey survey = SurveyTests(situation, ErrorsToJudge(machine, {"EX0C", "EY0C", "EA0C", "EB0C"}).value()).value();
  std::erase_if(survey.tests, [](const SurveyedTest& test) { return test.test != "rtest-grid"; });
  const std::vector<int> asked = {0, 3};
  const Proposal any = ProposeTests(survey, asked);
  ASSERT_TRUE(AddPasses(situation, &survey).ok());
  ASSERT_THAT(any.undetermined, ::testing::IsEmpty());
  const std::vector<double> wanted = {0.7 * any.sigma[0], 0.7 * any.sigma[1]};
  const Proposal better = ProposeTests(survey, asked, wanted);
  ASSERT_THAT(better.undetermined, ::testing::IsEmpty());
  EXPECT_LE(better.sigma[0], wanted[0]);
  EXPECT_LE(better.sigma[1], wanted[1]);
  EXPECT_GT(better.seconds, any.seconds);
  const Proposal never = ProposeTests(survey, asked, {1e-9, INFINITY});
  EXPECT_THAT(never.undetermined, ElementsAre(0));
  EXPECT_GT(never.best[0], 1e-9);
  EXPECT_LE(never.best[0], better.sigma[0]);
}

}  // namespace
}  // namespace axiscal::plan
