#include "core/identify/judge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/base/units.h"
#include "core/identify/curved_setup.h"
#include "core/identify/plausible_errors.h"
#include "core/identify/profile_likelihood.h"
#include "core/identify/unseen.h"
#include "core/information/coverage_factor.h"

namespace axiscal::identify {
namespace {

// Uncertainties of the fitted errors and set-ups; behind the fitted errors those that are held.
Covariance UncertaintyOf(const SolvedProblem& solved, double sigma_scale) {
  const Problem& problem = solved.problem;
  const Solution& solution = solved.solution;
  if (problem.fixed_covariance.size() == 0)
    return CovarianceOf(problem, solution.point, solution.normal, solved.held, sigma_scale);
  Problem all_free = problem;
  all_free.fixed_model = {};
  Point point = solution.point;
  std::vector<Parameter> all = solved.parameters;
  const int fitted = static_cast<int>(point.model.terms.size());
  for (Parameter fixed : ListParameters(problem.fixed_model, true)) {
    fixed.term += fitted;
    all.push_back(fixed);
  }
  point.model.terms.insert(point.model.terms.end(), problem.fixed_model.terms.begin(), problem.fixed_model.terms.end());
  return CovarianceOf(all_free, point, Assemble(all_free, point, all), solved.held, sigma_scale,
                      problem.fixed_covariance);
}

// The scale of an instrument whose serial number is stated is a fact that is fitted: `covariance` has it in all
// sessions at once, and the errors move with it as its own sigma moves it.
std::vector<StatedPart> ScalesOf(const SolvedProblem& solved, const Covariance& covariance) {
  const Problem& problem = solved.problem;
  std::vector<StatedPart> parts;
  std::set<std::string> known;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const instruments::MeasuringRun& run = problem.runs[i];
    if (run.scale_of.empty() || !known.insert(run.scale_of).second) continue;
    const instruments::SetupParameter& scale = run.setup[ScaleAt(run)];
    if (scale.held) continue;
    const Eigen::MatrixXd& with_setup = covariance.with_setup[static_cast<size_t>(problem.group_of_run[i])];
    parts.push_back(
        {absl::StrFormat("scale of instrument %s, +- %g um/m", run.scale_of, scale.prior_sigma * base::kUmPerMm),
         with_setup.col(problem.offsets_of_run[i][ScaleAt(run)])
                 .head(static_cast<Eigen::Index>(solved.parameters.size())) /
             scale.prior_sigma});
  }
  return parts;
}

// What stated facts leave uncertain. A fact that is off by one standard uncertainty moves all that is fitted by the
// Gauss-Newton step which the readings then ask for, in all sessions that rest on it at once; facts are independent.
// Nothing is fitted of them: readings do not make a coefficient better known.
std::vector<StatedPart> AddStated(const SolvedProblem& solved, Covariance* covariance) {
  const Problem& problem = solved.problem;
  const Solution& solution = solved.solution;
  std::map<std::string, std::vector<std::pair<size_t, const instruments::StatedEffect*>>> facts;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    for (const instruments::StatedEffect& effect : problem.runs[i].stated) {
      if (!effect.is_workpiece) facts[effect.of].push_back({i, &effect});
    }
  }
  std::vector<StatedPart> parts = ScalesOf(solved, *covariance);
  if (facts.empty()) return parts;
  const Point& at = solution.linearised;
  const GaussNewtonStep as_it_is = SolveStep(problem, at, solution.normal, solved.held);
  for (const auto& [of, effects] : facts) {
    Problem off = problem;
    for (const auto& [run, effect] : effects) off.runs[run].measured_mm -= effect->by_sigma_mm;
    const GaussNewtonStep moved = SolveStep(off, at, Assemble(off, at, solved.parameters), solved.held);
    StatedPart& part = parts.emplace_back(StatedPart{of, moved.errors - as_it_is.errors});
    const Eigen::Index p = part.moved.size();
    covariance->errors.topLeftCorner(p, p) += part.moved * part.moved.transpose();
    std::vector<Eigen::VectorXd> by_setup;
    for (size_t g = 0; g < moved.setup.size(); ++g) by_setup.push_back(moved.setup[g] - as_it_is.setup[g]);
    for (const auto& [run, effect] : effects) {
      const auto group = static_cast<size_t>(problem.group_of_run[run]);
      for (size_t k = 0; k < problem.groups[group].parameters.size(); ++k) {
        if (problem.groups[group].parameters[k].name == effect->setup_offset)
          by_setup[group][static_cast<Eigen::Index>(k)] = effect->setup_sigma_mm;
      }
    }
    for (size_t g = 0; g < by_setup.size(); ++g)
      covariance->setup_sigma[g] = (covariance->setup_sigma[g].array().square() + by_setup[g].array().square()).sqrt();
  }
  return parts;
}

// `linear`: covariance of the errors by the readings' noise as stated, with all priors; `curved`: what offsets that
// rest on weak priors do by curvature.
PriorDominated FindPriorDominated(const SolvedProblem& solved, const Eigen::MatrixXd& linear,
                                  const Eigen::MatrixXd& curved) {
  const std::vector<Parameter>& parameters = solved.parameters;
  const int p = static_cast<int>(parameters.size());
  PriorDominated out;
  out.involved.assign(p, false);
  const Eigen::MatrixXd alone = InverseBeside(
      Reduce(solved.problem, solved.solution.linearised, solved.solution.normal, Priors::kInformative), solved.held);
  const Eigen::VectorXd sizes = PlausibleSizes(solved.solution.point.model, parameters);
  std::vector<bool> is_by_curvature(p, false);
  for (int i = 0; i < p; ++i) {
    if (solved.null_space.involved[i] || parameters[i].is_nonlinear || solved.IsHeld(i)) continue;
    constexpr double kHalf = 0.5;
    const double variance = linear(i, i) + curved(i, i);
    is_by_curvature[i] = curved(i, i) > kHalf * variance;
    out.involved[i] = std::sqrt(variance) > kMeasuredWithin * sizes[i] &&
                      (is_by_curvature[i] || !(linear(i, i) >= kHalf * alone(i, i)));
  }
  // Named together where readings alone would move them together.
  constexpr double kTogether = 0.9;  // correlation
  std::vector<bool> is_named(p, false);
  for (int i = 0; i < p; ++i) {
    if (!out.involved[i] || is_named[i]) continue;
    const Eigen::MatrixXd& moved = is_by_curvature[i] ? curved : alone;
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(p);
    for (int j = 0; j < p; ++j) {
      if (!out.involved[j] || !(std::abs(moved(i, j)) >= kTogether * std::sqrt(moved(i, i) * moved(j, j)))) continue;
      direction[j] = moved(i, j) / moved(i, i);
      is_named[j] = true;
    }
    direction[i] = 1.0;
    out.directions.push_back(std::move(direction));
  }
  return out;
}

std::vector<bool> FindUnsupported(const SolvedProblem& solved, const Judgement& judgement) {
  const NullSpace& null_space = solved.null_space;
  const Eigen::VectorXd sizes = PlausibleSizes(solved.solution.point.model, solved.parameters);
  std::vector<bool> unsupported(solved.parameters.size());
  for (size_t i = 0; i < unsupported.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    unsupported[i] = judgement.HasNoNumber(i);
    const double sigma = std::sqrt(judgement.covariance.errors(at, at));
    if (null_space.involved[i] && sigma > kMeasuredWithin * sizes[at]) unsupported[i] = true;
    for (size_t k = 0; k < null_space.fixed.size(); ++k) {
      const bool is_freed = !solved.IsHeld(null_space.fixed[k]);
      if (is_freed && null_space.directions(static_cast<Eigen::Index>(k), at) != 0.0) unsupported[i] = true;
    }
  }
  return unsupported;
}

}  // namespace

absl::StatusOr<Judgement> Judge(const SolvedProblem& solved, const Options& options) {
  const Solution& solution = solved.solution;
  Judgement judgement;
  judgement.statistics = StatisticsOf(solved.problem, solution.point, solution.residuals_mm,
                                      static_cast<int>(std::lround(solved.Unknowns(solution))));
  if (options.scale_uncertainties) judgement.sigma_scale = std::sqrt(std::max(1.0, judgement.statistics.chi2_per_dof));
  judgement.coverage_factor =
      information::CoverageFactor(judgement.sigma_scale > 1.0, judgement.statistics.degrees_of_freedom);
  judgement.covariance = UncertaintyOf(solved, judgement.sigma_scale);
  const auto p = static_cast<Eigen::Index>(solved.parameters.size());
  Eigen::MatrixXd curved = Eigen::MatrixXd::Zero(p, p);
  if (options.profile_intervals) {
    curved = CurvedSetupCovariance(solved, judgement.covariance);
    judgement.covariance.errors.topLeftCorner(p, p) += UnseenCovariance(solved, judgement.covariance) + curved;
  }
  judgement.stated = AddStated(solved, &judgement.covariance);
  const Eigen::MatrixXd linear =
      InverseBeside(Reduce(solved.problem, solution.linearised, solution.normal, Priors::kAll), solved.held);
  judgement.prior_dominated = FindPriorDominated(solved, linear, curved);
  ASSIGN_OR_RETURN(judgement.without_interval,
                   FindWithoutInterval(solved, linear, curved, judgement.sigma_scale, options));
  judgement.unsupported = FindUnsupported(solved, judgement);
  return judgement;
}

}  // namespace axiscal::identify
