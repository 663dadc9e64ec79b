// The slow obvious twin of core/identify: the same least squares given to Ceres residual by residual, derivatives taken
// automatically through the instruments' templated Predict, uncertainties from ceres::Covariance.
#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include "core/identify/identify.h"
#include "core/instruments/ballbar/ballbar_model.h"
#include "core/instruments/ballbar/ballbar_plan.h"
#include "core/instruments/rtest/rtest_model.h"
#include "core/synthetic/simulate.h"
#include "tests/known_answers/yao_machine.h"

namespace axiscal::known_answers {
namespace {

using instruments::MeasuringRun;

constexpr int kMaxErrors = 16;

// (predicted - measured) / sigma of one reading; blocks: error amplitudes, the session's setup offsets.
class ReadingResidual {
 public:
  ReadingResidual(const machine::Machine& machine, const machine::ErrorModel& model, const MeasuringRun& run,
                  int reading)
      : machine_(machine), model_(model), run_(run), reading_(reading) {}

  template <typename T>
  bool operator()(T const* const* blocks, T* residual) const {
    machine::JointErrors<T> errors;
    for (size_t i = 0; i < model_.terms.size(); ++i) {
      errors[model_.terms[i].joint][static_cast<int>(model_.terms[i].component)] += blocks[0][i];
    }
    const double* commands = run_.PositionsOf(reading_);
    const std::vector<T> positions(commands, commands + run_.axis_count);
    if (run_.kind == instruments::Kind::kBallbar) {
      ballbar::Predict<T>(machine_, run_, positions.data(), errors, blocks[1], residual);
    } else {
      rtest::Predict<T>(machine_, run_, positions.data(), errors, blocks[1], residual);
    }
    for (int row = 0; row < run_.row_count; ++row) {
      residual[row] = (residual[row] - run_.measured_mm(row, reading_)) / run_.sigma_mm;
    }
    return true;
  }

 private:
  const machine::Machine& machine_;
  const machine::ErrorModel& model_;
  const MeasuringRun& run_;
  const int reading_;
};

struct PriorResidual {
  double sigma;
  int at;
  template <typename T>
  bool operator()(T const* const* blocks, T* residual) const {
    residual[0] = blocks[0][at] / sigma;
    return true;
  }
};

struct Twin {
  std::vector<double> errors, sigmas;
};

Twin SolveWithCeres(const machine::Machine& machine, const machine::ErrorModel& model,
                    const std::vector<MeasuringRun>& runs) {
  ceres::Problem problem;
  Twin twin;
  twin.errors.assign(model.terms.size(), 0.0);
  std::vector<std::vector<double>> setups;
  for (const MeasuringRun& run : runs) setups.emplace_back(run.setup.size(), 0.0);
  for (size_t i = 0; i < runs.size(); ++i) {
    const int setup_count = static_cast<int>(setups[i].size());
    for (int k = 0; k < runs[i].reading_count(); ++k) {
      auto* cost = new ceres::DynamicAutoDiffCostFunction<ReadingResidual, kMaxErrors>(
          new ReadingResidual(machine, model, runs[i], k));
      cost->AddParameterBlock(static_cast<int>(twin.errors.size()));
      cost->AddParameterBlock(setup_count);
      cost->SetNumResiduals(runs[i].row_count);
      problem.AddResidualBlock(cost, nullptr, {twin.errors.data(), setups[i].data()});
    }
    for (int p = 0; p < setup_count; ++p) {
      auto* cost =
          new ceres::DynamicAutoDiffCostFunction<PriorResidual>(new PriorResidual{runs[i].setup[p].prior_sigma, p});
      cost->AddParameterBlock(setup_count);
      cost->SetNumResiduals(1);
      problem.AddResidualBlock(cost, nullptr, {setups[i].data()});
    }
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = options.parameter_tolerance = options.gradient_tolerance = 1e-16;
  options.max_num_iterations = 50;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  EXPECT_TRUE(summary.IsSolutionUsable()) << summary.message;

  ceres::Covariance::Options covariance_options;
  covariance_options.algorithm_type = ceres::DENSE_SVD;
  covariance_options.min_reciprocal_condition_number = 1e-20;
  ceres::Covariance covariance(covariance_options);
  const std::vector<std::pair<const double*, const double*>> wanted = {{twin.errors.data(), twin.errors.data()}};
  EXPECT_TRUE(covariance.Compute(wanted, &problem));
  const int count = static_cast<int>(twin.errors.size());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> block(count, count);
  covariance.GetCovarianceBlock(twin.errors.data(), twin.errors.data(), block.data());
  for (int i = 0; i < count; ++i) twin.sigmas.push_back(std::sqrt(block(i, i)));
  return twin;
}

// Nest positions over both rotary axes: every reading has three displacements.
session::Session PlannedRtest(const machine::Machine& machine, double tool_length_mm) {
  session::Session session;
  session.header = {
      {"machine", machine.id}, {"session", absl::StrCat("nest", tool_length_mm)},      {"instrument", "rtest"},
      {"sigma_um", "0.5"},     {"tool_tip_mm", absl::StrCat("0 0 ", -tool_length_mm)}, {"table_ball_mm", "80 0 60"}};
  for (const char* column : {"t_s", "X_mm", "Y_mm", "Z_mm", "B_deg", "C_deg"})
    session.columns.push_back({column, {}, {}});
  for (int k = 0; k < 48; ++k) {
    const double b_deg = 15.0 * (k % 7), c_deg = 30.0 * (k % 12);
    const double s = std::sin(b_deg * base::kRadPerDeg), c = std::cos(b_deg * base::kRadPerDeg);
    const double row[] = {static_cast<double>(k),
                          80.0 * std::cos(c_deg * base::kRadPerDeg) + tool_length_mm * s,
                          80.0 * std::sin(c_deg * base::kRadPerDeg),
                          60.0 + tool_length_mm * c,
                          b_deg,
                          c_deg};
    for (size_t i = 0; i < session.columns.size(); ++i) session.columns[i].values.push_back(row[i]);
  }
  return session;
}

std::vector<MeasuringRun> BallbarAndRtest(const machine::Machine& machine, const machine::ErrorModel& truth) {
  std::vector<session::Session> planned;
  for (const double tool_length_mm : {356.4, 406.4}) {
    for (const auto& [name, pattern] : ballbar::Patterns()) {
      ballbar::PatternOptions options;
      options.tool_length_mm = tool_length_mm;
      options.step_deg = 10.0;
      planned.push_back(ballbar::PlanPattern(machine, absl::StrCat(name, tool_length_mm), pattern, options).value());
    }
    planned.push_back(PlannedRtest(machine, tool_length_mm));
  }
  std::vector<session::Session> sessions;
  for (const session::Session& plan : planned) {
    synthetic::NoiseOptions noise;
    noise.seed = 100 + sessions.size();
    sessions.push_back(synthetic::Simulate(machine, truth, plan, noise).value());
  }
  return identify::BindSessions(machine, sessions).value();
}

TEST(CeresTwin, TwelveErrorsAndTwentySixSetups) {
  const machine::Machine machine = YaoMachine();
  machine::ErrorModel truth = ModelOf(machine, {.aBT = 4e-5,
                                                .dxBT = -0.012,
                                                .dzBT = 0.030,
                                                .aXB = 8e-5,
                                                .bXB = 4e-5,
                                                .gXB = -6e-5,
                                                .gXY = 3e-5,
                                                .aYZ = 0.0,
                                                .bYZ = 5e-5,
                                                .aCZ = -4e-5,
                                                .bCZ = 5e-5,
                                                .dxCZ = 0.022,
                                                .dyCZ = -0.015});
  // Of the four angles about X that only move together one is left out, so that the problem has a single answer.
  std::erase_if(truth.terms,
                [&](const machine::ErrorTerm& term) { return machine::SymbolOf(machine, term) == "EA0Y"; });
  const std::vector<MeasuringRun> runs = BallbarAndRtest(machine, truth);

  identify::Options options;
  options.model = truth;
  for (machine::ErrorTerm& term : options.model->terms) term.amplitude.fill(0.0);
  options.set_outliers_aside = false;
  options.scale_uncertainties = false;
  const auto ours = identify::FitRuns(machine, runs, options);
  ASSERT_TRUE(ours.ok()) << ours.status();
  ASSERT_EQ(ours->result.rank, static_cast<int>(truth.terms.size()));
  const Twin twin = SolveWithCeres(machine, *options.model, runs);

  // Both stop where no step would show: here within 1e-6 sigma of each other, uncertainties (taken one step apart) to
  // 2e-7.
  constexpr double kSigmas = 1e-5, kRelative = 1e-6;
  for (size_t i = 0; i < truth.terms.size(); ++i) {
    const identify::Estimate& estimate = ours->result.estimates[i];
    EXPECT_NEAR(estimate.value, twin.errors[i], kSigmas * twin.sigmas[i]) << estimate.name;
    EXPECT_NEAR(estimate.sigma, twin.sigmas[i], kRelative * twin.sigmas[i]) << estimate.name;
    EXPECT_NEAR(estimate.value, truth.terms[i].amplitude[0], 4.0 * estimate.sigma) << estimate.name;
  }
}

}  // namespace
}  // namespace axiscal::known_answers
