#include "core/identify/monte_carlo.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <string>

#include "core/base/demand.h"
#include "core/base/random.h"
#include "core/identify/rows.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// The draws that stand for now.
class Draws {
 public:
  Draws(const Budget& budget, base::Random* random) : budget_(budget), random_(*random) {
    for (const Source& source : budget.sources) drawn_.push_back(source.term);
  }

  void Draw(DrawnPer drawn_per) {
    for (size_t i = 0; i < drawn_.size(); ++i) {
      const Source& source = budget_.sources[i];
      if (source.drawn_per != drawn_per) continue;
      for (double& amplitude : drawn_[i].amplitude) amplitude = source.scale * Standard(source.distribution);
    }
  }
  // What the sources add to the machine's errors at a state.
  void AddErrors(const std::vector<bool>& acts, const shapes::State& state,
                 machine::JointErrors<double>* errors) const {
    for (size_t i = 0; i < drawn_.size(); ++i) {
      if (acts[i] && !budget_.sources[i].is_reading) machine::AddErrors(drawn_[i], state, errors);
    }
  }
  // What they add to one row of a reading. Those of readings are drawn anew for each row.
  double OnRow(const std::vector<bool>& acts) {
    double sum_mm = 0.0;
    for (size_t i = 0; i < drawn_.size(); ++i) {
      const Source& source = budget_.sources[i];
      if (!acts[i] || !source.is_reading) continue;
      sum_mm += source.drawn_per == DrawnPer::kReading ? source.scale * Standard(source.distribution)
                                                       : drawn_[i].amplitude[0];
    }
    return sum_mm;
  }

 private:
  double Standard(Distribution distribution) {
    return distribution == Distribution::kUniform ? 2.0 * random_.Uniform() - 1.0 : random_.Normal();
  }

  const Budget& budget_;
  base::Random& random_;
  std::vector<machine::ErrorTerm> drawn_;  // the sources' terms with the amplitudes that stand
};

// One set of sessions as it might have been measured.
class Simulator {
 public:
  Simulator(const Fit& fit, const Budget& budget) : fit_(fit), budget_(budget) {
    // Uncertainties were scaled where the readings scatter more than stated: so is the noise.
    noise_scale_ = std::sqrt(std::max(1.0, fit.result.fit.chi2_per_dof));
    if (const Eigen::MatrixXd& held = fit.problem.fixed_covariance; held.size() > 0) {
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(held);
      held_spread_ = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal();
    }
    for (const MeasuringRun& run : fit.problem.runs) {
      std::vector<bool>& acts = acts_.emplace_back();
      for (const Source& source : budget.sources) acts.push_back(source.ActsIn(run.session));
    }
  }

  Problem Simulate(base::Random* random) const {
    Problem problem = fit_.problem;
    DrawFixedErrors(random, &problem);
    const Point truth = DrawSetups(random);
    Draws draws(budget_, random);
    draws.Draw(DrawnPer::kRun);
    std::map<std::string, double> stated;  // facts are off by so many standard uncertainties
    for (size_t i = 0; i < problem.runs.size(); ++i) {
      draws.Draw(DrawnPer::kSession);
      SimulateRun(problem, i, truth, &draws, random, &problem.runs[i]);
      for (const instruments::StatedEffect& effect : problem.runs[i].stated) {
        if (effect.is_workpiece) continue;
        const auto [off, is_new] = stated.try_emplace(effect.of, 0.0);
        if (is_new) off->second = random->Normal();
        problem.runs[i].measured_mm += off->second * effect.by_sigma_mm;
      }
    }
    problem.fixed_model = fit_.problem.fixed_model;  // what the fit takes them for
    return problem;
  }

 private:
  // What is known of an offset beforehand (the length of the bar, a calibrated place) is known within its sigma; where
  // nothing is known, it stays where it was found.
  Point DrawSetups(base::Random* random) const {
    Point truth = fit_.point;
    for (size_t g = 0; g < truth.setup.size(); ++g) {
      const std::vector<instruments::SetupParameter>& parameters = fit_.problem.groups[g].parameters;
      for (size_t i = 0; i < parameters.size(); ++i) {
        const bool is_known = !parameters[i].is_weak && !parameters[i].held;
        if (is_known) truth.setup[g][i] = parameters[i].prior_sigma * random->Normal();
      }
    }
    return truth;
  }

  // Errors that the fit holds are what they are held for within their uncertainty.
  void DrawFixedErrors(base::Random* random, Problem* problem) const {
    if (held_spread_.size() == 0) return;
    Eigen::VectorXd draws(held_spread_.cols());
    for (double& draw : draws) draw = random->Normal();
    const Eigen::VectorXd off = held_spread_ * draws;
    const std::vector<Parameter> parameters = ListParameters(problem->fixed_model, true);
    for (size_t i = 0; i < parameters.size(); ++i) {
      SetValue(parameters[i], ValueOf(problem->fixed_model, parameters[i]) + off[i], &problem->fixed_model);
    }
  }

  void SimulateRun(const Problem& problem, size_t index, const Point& truth, Draws* draws, base::Random* random,
                   MeasuringRun* run) const {
    const Noise& noise = fit_.problem.noise[index];
    const double sigma_mm = budget_.with_reading_noise ? noise_scale_ * noise.sigma_mm : 0.0;
    std::vector<base::RippleNoise> ripple(run->row_count, base::RippleNoise(noise.ar1, noise.white_share));
    const Eigen::VectorXd setup = SetupOf(fit_.problem, truth, index);
    ErrorsOfRun errors_of_run(problem, truth);
    for (int k = 0; k < run->reading_count(); ++k) {
      draws->Draw(DrawnPer::kReading);
      machine::JointErrors<double> errors;
      const auto errors_at = [&](const shapes::State& state) -> const machine::JointErrors<double>& {
        errors = errors_of_run.At(state);
        draws->AddErrors(acts_[index], state, &errors);
        return errors;
      };
      double predicted_mm[instruments::kMaxRows];
      instruments::PredictWith(*fit_.problem.machine, *run, k, errors_at, setup.data(), predicted_mm);
      for (int row = 0; row < run->row_count; ++row) {
        run->measured_mm(row, k) =
            predicted_mm[row] + sigma_mm * ripple[row].Next(*random) + draws->OnRow(acts_[index]);
      }
    }
  }

  const Fit& fit_;
  const Budget& budget_;
  double noise_scale_;
  Eigen::MatrixXd held_spread_;          // times its transpose: covariance of held errors
  std::vector<std::vector<bool>> acts_;  // per run and source
};

// The fit of the measured sessions, without judging noise and bad readings again: that was done, and nothing here is
// bad.
Options RefitOptions(const MonteCarloOptions& options) {
  Options refit;
  refit.set_outliers_aside = false;
  refit.scale_uncertainties = false;
  refit.judge_correlation = false;
  refit.profile_intervals = false;
  refit.raise_noise = false;
  refit.cancelled = options.cancelled;
  return refit;
}

double Quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const size_t below = static_cast<size_t>(at), above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

std::vector<Eigen::Index> Identifiable(const Fit& fit) {
  std::vector<Eigen::Index> shown;
  for (size_t j = 0; j < fit.result.estimates.size(); ++j) {
    if (fit.result.estimates[j].identifiable) shown.push_back(static_cast<Eigen::Index>(j));
  }
  return shown;
}

// Runs that gave every number.
std::vector<Eigen::Index> Converged(const Eigen::MatrixXd& sample, const std::vector<Eigen::Index>& shown) {
  std::vector<Eigen::Index> good;
  for (Eigen::Index i = 0; i < sample.rows(); ++i) {
    if (sample(i, shown).allFinite()) good.push_back(i);
  }
  return good;
}

// `values`: runs that converged x identifiable errors.
void Summarise(const Fit& fit, const std::vector<Eigen::Index>& shown, const Eigen::MatrixXd& values,
               MonteCarloResult* result) {
  const double count = static_cast<double>(values.rows());
  const Eigen::RowVectorXd mean = values.colwise().mean();
  const Eigen::MatrixXd centred = values.rowwise() - mean;
  const Eigen::MatrixXd covariance = centred.transpose() * centred / std::max(1.0, count - 1.0);
  for (size_t j = 0; j < shown.size(); ++j) {
    const Estimate& estimate = fit.result.estimates[shown[j]];
    std::vector<double> sorted(values.col(j).begin(), values.col(j).end());
    std::sort(sorted.begin(), sorted.end());
    result->spreads.push_back({estimate.name, estimate.unit, estimate.factor, estimate.value, estimate.sigma, mean[j],
                               std::sqrt(covariance(j, j)), Quantile(sorted, 0.025), Quantile(sorted, 0.975)});
  }
  const Eigen::VectorXd sigma = covariance.diagonal().cwiseSqrt();
  result->correlation = sigma.cwiseInverse().asDiagonal() * covariance * sigma.cwiseInverse().asDiagonal();
}

absl::Status Validate(const Fit& fit, const MonteCarloOptions& options) {
  if (options.runs < 1 || options.runs > kMaxMonteCarloRuns) {
    return absl::InvalidArgumentError(
        absl::StrCat("monte_carlo runs = ", options.runs, ", must be 1 to ", kMaxMonteCarloRuns));
  }
  std::vector<std::string> sessions;
  for (const MeasuringRun& run : fit.problem.runs) sessions.push_back(run.session);
  RETURN_IF_ERROR(CheckSessions(options.budget, sessions));
  if (Identifiable(fit).empty()) {
    return absl::FailedPreconditionError("Monte Carlo: these sessions identify no error whose spread could be told");
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MonteCarloResult> MonteCarlo(const Fit& fit, const MonteCarloOptions& options) {
  RETURN_IF_ERROR(Validate(fit, options));
  const Simulator simulator(fit, options.budget);
  const Options refit = RefitOptions(options);
  Eigen::MatrixXd sample =
      Eigen::MatrixXd::Constant(options.runs, static_cast<Eigen::Index>(fit.result.estimates.size()), NAN);
  std::atomic<bool> is_cancelled = false;
  std::atomic<int> done = 0;
  const auto run = [&](int index) {
    if (is_cancelled || (options.cancelled && options.cancelled())) {
      is_cancelled = true;
      return;
    }
    base::Random random(base::StreamSeed(options.seed, static_cast<uint64_t>(index)));
    const absl::StatusOr<Fit> simulated =
        FitProblem(simulator.Simulate(&random), fit.point.model, refit, fit.point.setup);
    if (simulated.ok()) {
      for (size_t j = 0; j < simulated->result.estimates.size(); ++j) {
        sample(index, static_cast<Eigen::Index>(j)) = simulated->result.estimates[j].value;
      }
    }
    if (options.progress) options.progress(static_cast<double>(++done) / options.runs);
  };
  if (options.for_each) {
    options.for_each(options.runs, run);
  } else {
    for (int index = 0; index < options.runs; ++index) run(index);
  }
  if (is_cancelled) return absl::CancelledError("the Monte Carlo simulation was cancelled");
  const std::vector<Eigen::Index> shown = Identifiable(fit), good = Converged(sample, shown);
  MonteCarloResult result;
  result.runs = options.runs;
  result.seed = options.seed;
  result.failed = options.runs - static_cast<int>(good.size());
  if (10 * result.failed > options.runs) {
    return absl::FailedPreconditionError(
        absl::StrCat("Monte Carlo: ", result.failed, " of ", options.runs, " simulated fits did not converge"));
  }
  Summarise(fit, shown, sample(good, shown), &result);
  return result;
}

}  // namespace axiscal::identify
