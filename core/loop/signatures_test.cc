#include "core/loop/signatures.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/identify/identify.h"
#include "core/identify/testing/scenario.h"
#include "core/instruments/evaluation.h"
#include "core/loop/dictionary.h"

namespace axiscal::loop {
namespace {

using identify::testing::Errors;
using identify::testing::Measure;

const machine::Machine kMachine = machine::testing::MultiTasking();

// Of noise, as identify::Noise has it.
struct Memory {
  double ar1, white_share;
};

identify::Fit FitOf(const machine::ErrorModel& model, const machine::ErrorModel& truth, double sigma_scale) {
  synthetic::NoiseOptions noise;
  noise.sigma_scale = sigma_scale;
  identify::Options options;
  options.model = model;
  options.set_outliers_aside = false;
  return identify::FitRuns(kMachine, *identify::BindSessions(kMachine, Measure(kMachine, truth, noise)), options)
      .value();
}

// The gain that a projected signature promises is what a full refit with the effect added does to chi-square.
TEST(Signatures, ThePromisedGainIsThatOfTheRefit) {
  const machine::ErrorModel declared = machine::DeclaredModel(kMachine);
  const machine::ErrorModel truth =
      Errors(kMachine, R"({"EX0C": 20, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 0.5}]})");
  const identify::Fit before = FitOf(declared, truth, 1.0);
  machine::ErrorModel extended = declared;
  const int x = machine::FindAxis(kMachine, "X");
  extended.terms.push_back({x, machine::Component::kX, shapes::Backlash{x}, {}});
  const identify::Fit after = FitOf(extended, truth, 1.0);
  const auto chi2 = [](const identify::Fit& fit) {
    return fit.result.fit.chi2_per_dof * fit.result.fit.degrees_of_freedom;
  };

  const Signatures signatures(before.problem, before.point, identify::ListParameters(before.point.model, true));
  const Projection projection = signatures.Project({{Family::kBacklash, extended.terms.back(), -1, 0}})[0];
  const double gain = projection.with_residual[0] * projection.with_residual[0] / projection.own(0, 0);
  EXPECT_GT(gain, 50.0);
  EXPECT_NEAR(gain, chi2(before) - chi2(after), 1e-3 * gain);  // second order of errors of 1e-4
  EXPECT_NEAR(signatures.residual_squares(), chi2(before), 1e-6 * chi2(before));
}

// Rows that remember with a white share are whitened across the blocks that signatures come in.
TEST(Signatures, ThePromisedGainIsThatOfTheRefitInNoiseThatWanders) {
  const machine::ErrorModel declared = machine::DeclaredModel(kMachine);
  const machine::ErrorModel truth =
      Errors(kMachine, R"({"EX0C": 20, "terms": [{"symbol": "EXX", "shape": "backlash", "amplitude": 0.5}]})");
  identify::Fit fit = FitOf(declared, truth, 1.0);
  for (identify::Noise& noise : fit.problem.noise) noise = {noise.sigma_mm, 0.8, 0.5};
  identify::Options options;
  options.set_outliers_aside = false;
  const identify::Fit before = identify::FitProblem(fit.problem, declared, options).value();
  machine::ErrorModel extended = declared;
  const int x = machine::FindAxis(kMachine, "X");
  extended.terms.push_back({x, machine::Component::kX, shapes::Backlash{x}, {}});
  const identify::Fit after = identify::FitProblem(fit.problem, extended, options).value();
  const Signatures signatures(before.problem, before.point, identify::ListParameters(before.point.model, true));
  const Projection projection = signatures.Project({{Family::kBacklash, extended.terms.back(), -1, 0}})[0];
  const double gain = projection.with_residual[0] * projection.with_residual[0] / projection.own(0, 0);
  EXPECT_GT(gain, 20.0);
  EXPECT_NEAR(gain,
              before.result.fit.chi2_per_dof * before.result.fit.degrees_of_freedom -
                  after.result.fit.chi2_per_dof * after.result.fit.degrees_of_freedom,
              1e-3 * gain);
}

// A session that does not see one direction of a slip, and one that sees two directions as one.
TEST(Signatures, ColumnsThatShowNothingOfTheirOwnTakeNoPartInTheGain) {
  Projection projection;
  projection.columns = 3;
  projection.own.topLeftCorner<2, 2>() << 4.0, 1.0, 1.0, 2.0;
  projection.with_residual << 3.0, -5.0, 0.0;
  const Eigen::Vector2d solution = projection.own.topLeftCorner<2, 2>().inverse() * Eigen::Vector2d(3.0, -5.0);
  const double gain = solution.dot(Eigen::Vector2d(3.0, -5.0));
  Eigen::Vector3d amplitude;
  EXPECT_NEAR(Gain(projection, &amplitude), gain, 1e-12);
  EXPECT_NEAR((amplitude.head<2>() + solution).norm(), 0.0, 1e-12);
  EXPECT_EQ(amplitude[2], 0.0);
  // The third as half the first.
  projection.own.row(2) = 0.5 * projection.own.row(0);
  projection.own.col(2) = 0.5 * projection.own.col(0);
  projection.with_residual[2] = 0.5 * projection.with_residual[0];
  EXPECT_NEAR(Gain(projection, &amplitude), gain, 1e-12);
  EXPECT_NEAR((projection.own * amplitude + projection.with_residual).norm(), 0.0, 1e-12);
}

TEST(Signatures, WhatTheSetupExplainsIsInvisible) {
  const identify::Fit fit = FitOf(machine::DeclaredModel(kMachine), {}, 1.0);
  const Signatures signatures(fit.problem, fit.point, identify::ListParameters(fit.point.model, true));
  // EX0W, the table ball's place, is what every session refits; only the ball's prior, 60 um, keeps a trace of it.
  const machine::ErrorTerm ball = machine::ConstantTerm(kMachine, *machine::ParseErrorSymbol("EX0W"));
  EXPECT_LT(signatures.Project({{Family::kConstant, ball, -1, 0}})[0].visible, 1e-4);
}

// Moves the ball from each slip's reading on and looks at what is left then.
class SlipSignatures : public testing::TestWithParam<instruments::Carrier> {};

TEST_P(SlipSignatures, AreWhatAMovedBallLeaves) {
  identify::Fit fit = FitOf(machine::DeclaredModel(kMachine), {}, 1.0);
  const std::vector<identify::Parameter> parameters = identify::ListParameters(fit.point.model, true);
  constexpr int kRun = 1;
  instruments::MeasuringRun& run = fit.problem.runs[kRun];
  const Eigen::MatrixXd as_measured_mm = run.measured_mm;
  const Eigen::Vector3d moved_mm(0.01, -0.02, 0.005);
  const std::vector<int> moments = {run.reading_count() / 2, 7, run.reading_count() - 9, 8};
  for (const int bad : {3, 7, 10}) fit.problem.is_used[kRun][bad] = false;
  for (const Memory memory : {Memory{0.0, 0.0}, Memory{0.6, 0.0}, Memory{0.8, 0.5}}) {
    for (identify::Noise& noise : fit.problem.noise) noise = {noise.sigma_mm, memory.ar1, memory.white_share};
    run.measured_mm = as_measured_mm;
    std::vector<Candidate> slips;
    for (const int moment : moments) slips.push_back({Family::kStep, {}, kRun, moment, 0, 0, GetParam()});
    const Signatures before(fit.problem, fit.point, parameters);
    const std::vector<Projection> projections = before.Project(slips);
    for (size_t i = 0; i < slips.size(); ++i) {
      run.measured_mm = as_measured_mm;
      instruments::Evaluation evaluation;
      for (int k = moments[i]; k < run.reading_count(); ++k) {
        const machine::JointErrors<double> errors = machine::ErrorsAt(kMachine, fit.point.model, run.StateOf(k));
        instruments::Evaluate(kMachine, run, k, errors, fit.point.setup[fit.problem.group_of_run[kRun]].data(),
                              &evaluation);
        const Eigen::RowVector3d of_table = evaluation.by_setup.row(0).head<3>();
        const Eigen::RowVector3d of_tool =
            evaluation.by_error.row(0).segment<3>(machine::kComponents * kMachine.tool_joint());
        run.measured_mm(0, k) -= (GetParam() == instruments::Carrier::kTable ? of_table : of_tool) * moved_mm;
      }
      const Signatures after(fit.problem, fit.point, parameters);
      const double more =
          2.0 * moved_mm.dot(projections[i].with_residual) + moved_mm.dot(projections[i].own * moved_mm);
      EXPECT_GT(more, 100.0);
      // A direction of which less than kVisible shows counts as none.
      EXPECT_NEAR(after.residual_squares(), before.residual_squares() + more, 1e-3 * more) << moments[i];
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Carriers, SlipSignatures,
                         testing::Values(instruments::Carrier::kTable, instruments::Carrier::kTool));

TEST(Signatures, TwoNamesOfOneMotionCorrelateFully) {
  const identify::Fit fit = FitOf(machine::DeclaredModel(kMachine), {}, 1.0);
  const Signatures signatures(fit.problem, fit.point, identify::ListParameters(fit.point.model, true));
  const int c = machine::FindAxis(kMachine, "C"), x = machine::FindAxis(kMachine, "X");
  const shapes::Harmonic twice{c, 2.0};
  const Candidate table{Family::kHarmonic, {c, machine::Component::kZ, twice, {}}, -1, 0};
  const Candidate tool{Family::kCross, {kMachine.tool_joint(), machine::Component::kZ, twice, {}}, -1, 0};
  const Candidate other{Family::kBacklash, {x, machine::Component::kX, shapes::Backlash{x}, {}}, -1, 0};
  const std::vector<double> correlations = signatures.CorrelationsWith(table, {table, tool, other});
  EXPECT_NEAR(correlations[0], 1.0, 1e-9);
  EXPECT_GT(correlations[1], 0.999);
  EXPECT_LT(correlations[2], 0.5);
}

// A fine harmonic of an axis that rests in most sessions is mostly a constant there, which declared errors explain:
// screening must look past that part.
TEST(Signatures, NothingThatMattersIsScreenedOut) {
  const machine::ErrorModel truth = Errors(kMachine,
                                           R"({"EX0C": 20,
           "terms": [{"symbol": "EBB", "shape": "harmonic", "order": 45, "amplitude": 4, "phase_deg": 12}]})");
  for (const Memory memory : {Memory{0.0, 0.0}, Memory{0.6, 0.0}, Memory{0.8, 0.5}}) {
    identify::Fit fit = FitOf(machine::DeclaredModel(kMachine), truth, 1.0);
    for (identify::Noise& noise : fit.problem.noise) noise = {noise.sigma_mm, memory.ar1, memory.white_share};
    const Signatures signatures(fit.problem, fit.point, identify::ListParameters(fit.point.model, true));
    const std::vector<Candidate> candidates = MakeDictionary(fit.problem, fit.point.model);
    constexpr double kWorth = 20.0;
    std::map<Family, double> worth;
    for (const Candidate& candidate : candidates) worth[candidate.family] = kWorth;
    const std::vector<Projection> all = signatures.Project(candidates);
    const std::vector<Projection> worthy = signatures.ProjectWorthy(candidates, worth, 0.8);
    double best = 0.0;
    int screened = 0, explain_much = 0;
    Eigen::Vector3d amplitude;
    for (size_t i = 0; i < candidates.size(); ++i) {
      if (all[i].visible > kVisible) best = std::max(best, Gain(all[i], &amplitude));
    }
    for (size_t i = 0; i < candidates.size(); ++i) {
      if (all[i].visible <= kVisible) continue;
      const double gain = Gain(all[i], &amplitude);
      explain_much += gain > 0.8 * best;
      screened += worthy[i].is_screened;
      if (worthy[i].is_screened) {
        EXPECT_LT(gain, 0.8 * best) << machine::NameOf(kMachine, candidates[i].term);
      } else {
        EXPECT_NEAR(Gain(worthy[i], &amplitude), gain, 1e-6 * best);
      }
    }
    EXPECT_GT(explain_much, 1);
    EXPECT_GT(screened, static_cast<int>(candidates.size()) / 3);
  }
}

}  // namespace
}  // namespace axiscal::loop
