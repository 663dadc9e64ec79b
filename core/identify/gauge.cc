#include "core/identify/gauge.h"

#include <algorithm>
#include <cmath>

#include "core/identify/plausible_errors.h"

namespace axiscal::identify {
namespace {

// Chi-square per reading of the solution, at least 1: readings may scatter by more than stated.
double ScatterOf(const Solution& solution) {
  return std::max(1.0, solution.cost / std::max(1, solution.normal.row_count));
}

}  // namespace

Nominal AtNominal(const Problem& problem, const machine::ErrorModel& model) {
  machine::ErrorModel zero = model;
  for (machine::ErrorTerm& term : zero.terms) term.amplitude.fill(0.0);
  Nominal nominal;
  nominal.point = StartingPoint(problem, zero);
  nominal.normal = Assemble(problem, nominal.point, ListParameters(zero, false));
  if (problem.fixed_model.terms.empty() || model.terms.empty()) {
    nominal.null_space = FindNullSpace(ReduceVisible(problem, nominal.point, nominal.normal));
    return nominal;
  }
  Problem free_of_errors = problem;
  free_of_errors.fixed_model = {};
  const NormalEquations normal = Assemble(free_of_errors, nominal.point, ListParameters(zero, false));
  nominal.null_space = FindNullSpace(ReduceVisible(free_of_errors, nominal.point, normal));
  return nominal;
}

NullSpace WithNonlinearColumns(const NullSpace& space, const machine::ErrorModel& model) {
  const std::vector<Parameter> all = ListParameters(model, true);
  NullSpace out = space;
  out.involved.assign(all.size(), false);
  out.directions = Eigen::MatrixXd::Zero(space.directions.rows(), static_cast<Eigen::Index>(all.size()));
  std::vector<int> at;
  for (size_t i = 0; i < all.size(); ++i) {
    if (all[i].is_nonlinear) {
      ++out.rank;
      continue;
    }
    const size_t amplitude = at.size();
    out.involved[i] = space.involved[amplitude];
    out.directions.col(i) = space.directions.col(amplitude);
    at.push_back(static_cast<int>(i));
  }
  for (int& column : out.fixed) column = at[column];
  return out;
}

std::vector<int> HeldAtSolution(const Problem& problem, const Solution& solution,
                                const std::vector<Parameter>& parameters, const NullSpace& null_space) {
  if (null_space.fixed.empty()) return {};
  const Reduced reduced = Reduce(problem, solution.linearised, solution.normal, Priors::kInformative);
  const Eigen::VectorXd sizes = PlausibleSizes(solution.point.model, parameters)(null_space.fixed);
  // Diagonal: the change of chi-square by a plausible size of each.
  Eigen::MatrixXd shows = sizes.asDiagonal() * InformationBeside(reduced, null_space.fixed) * sizes.asDiagonal();
  std::vector<int> held = null_space.fixed;
  // What shows by less biases the others by less than their uncertainty.
  const double least = ScatterOf(solution);
  Eigen::Index best = 0;
  while (shows.diagonal().maxCoeff(&best) > least) {
    held.erase(std::find(held.begin(), held.end(), null_space.fixed[best]));
    shows -= (shows.col(best) * shows.row(best) / shows(best, best)).eval();
    shows.row(best).setZero();
    shows.col(best).setZero();
  }
  return held;
}

std::optional<int> BiasesMost(const Problem& problem, const Solution& solution,
                              const std::vector<Parameter>& parameters, const NullSpace& null_space,
                              const std::vector<int>& held) {
  if (held.empty()) return std::nullopt;
  constexpr double kLeastGain = 4.0;  // chi-square: two standard uncertainties, or it is chance
  constexpr double kLeastBias = 0.5;  // standard uncertainties of an identified error
  const double scatter = ScatterOf(solution);
  // With the weak priors: an error that no reading shows without them may well show with them (three readings leave it
  // to the set-up, but not to a run-out of a tenth).
  const Reduced reduced = Reduce(problem, solution.linearised, solution.normal, Priors::kAll);
  const Eigen::MatrixXd covariance = InverseBeside(reduced, held);
  // Once the others have gone the last step.
  const Eigen::VectorXd gradient =
      (reduced.gradient - reduced.information * (covariance * reduced.gradient)).eval()(held);
  const Eigen::VectorXd information = InformationBeside(reduced, held).diagonal();
  const Eigen::VectorXd sizes = PlausibleSizes(solution.point.model, parameters)(held);
  // One at a time, as the gradient is that of this solution; no further than a plausible size, as what hardly shows
  // promises any gain at sizes that no machine has.
  std::optional<int> worst;
  double most = kLeastBias * std::sqrt(scatter);
  for (Eigen::Index k = 0; k < information.size(); ++k) {
    const double slope = std::abs(gradient[k]);
    const double move = slope < information[k] * sizes[k] ? slope / information[k] : sizes[k];
    const double gain = 2.0 * slope * move - std::max(0.0, information[k]) * move * move;
    if (!(gain > kLeastGain * scatter)) continue;
    const int error = held[static_cast<size_t>(k)];
    const Eigen::VectorXd shift = move * (covariance * reduced.information.col(error));
    for (Eigen::Index i = 0; i < shift.size(); ++i) {
      if (null_space.involved[static_cast<size_t>(i)] || !(covariance(i, i) > 0.0)) continue;
      const double bias = std::abs(shift[i]) / std::sqrt(covariance(i, i));
      if (bias <= most) continue;
      most = bias;
      worst = error;
    }
  }
  return worst;
}

}  // namespace axiscal::identify
