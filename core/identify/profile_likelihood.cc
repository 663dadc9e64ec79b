#include "core/identify/profile_likelihood.h"

#include <algorithm>
#include <cmath>

namespace axiscal::identify {
namespace {

// Whether another minimum puts a parameter more than a standard uncertainty away, or a turn of an artefact that
// chi-square hardly refuses farther than linear propagation lets it.
std::vector<bool> FindElsewhere(const SolvedProblem& solved, const Eigen::MatrixXd& stated, double sigma_scale) {
  const std::vector<Parameter>& parameters = solved.parameters;
  const Solution& best = solved.minima[0];
  std::vector<bool> is_elsewhere(parameters.size(), false);
  for (const Solution& other : solved.minima) {
    if (other.cost - best.cost > kRefused * sigma_scale * sigma_scale) break;
    for (size_t i = 0; i < parameters.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const double apart = ValueOf(other.point.model, parameters[i]) - ValueOf(best.point.model, parameters[i]);
      if (std::abs(apart) > sigma_scale * std::sqrt(stated(at, at))) is_elsewhere[i] = true;
    }
  }
  // Of a linear problem no error moves by more than the root of the rise, in standard uncertainties.
  for (const Solution& other : solved.along_turns) {
    constexpr double kBeyond = 1.5;
    const double rise = std::max(sigma_scale * sigma_scale, other.cost - best.cost);
    for (size_t i = 0; i < parameters.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const double apart = ValueOf(other.point.model, parameters[i]) - ValueOf(best.point.model, parameters[i]);
      if (std::abs(apart) > kBeyond * std::sqrt(rise * stated(at, at))) is_elsewhere[i] = true;
    }
  }
  return is_elsewhere;
}

// Whether the profile of a parameter is no parabola: moved by two standard uncertainties either way, all others
// refitted, it must raise chi-square by about four.
absl::StatusOr<std::vector<bool>> FindNotParabolic(const SolvedProblem& solved, const Eigen::MatrixXd& linear,
                                                   const Options& options) {
  const std::vector<Parameter>& parameters = solved.parameters;
  const NullSpace holding = solved.Holding();
  const int p = static_cast<int>(parameters.size());
  std::vector<bool> is_not(p, false);
  Options quiet = options;
  quiet.progress = nullptr;
  for (int i = 0; i < p; ++i) {
    const double variance = linear(i, i);
    if (holding.involved[i] || parameters[i].is_nonlinear || solved.IsHeld(i) || !(variance > 0.0)) continue;
    NullSpace beside = holding;
    beside.fixed.push_back(i);
    constexpr double kMoved = 2.0, kLeast = 0.5, kMost = 2.0;  // standard uncertainties; of the rise expected
    for (const double sign : {-1.0, 1.0}) {
      // The others start where linear propagation has them move to.
      Point moved = solved.solution.point;
      for (int j = 0; j < p; ++j) {
        const double share = sign * kMoved * linear(j, i) / std::sqrt(variance);
        SetValue(parameters[j], ValueOf(moved.model, parameters[j]) + share, &moved.model);
      }
      const absl::StatusOr<Solution> profile = Solve(solved.problem, moved, beside, quiet);
      if (absl::IsCancelled(profile.status())) return profile.status();
      const bool is_profile = profile.ok() && profile->has_converged;
      const double rise = is_profile ? (profile->cost - solved.solution.cost) / (kMoved * kMoved) : NAN;
      if (!(rise >= kLeast && rise <= kMost)) is_not[i] = true;
    }
  }
  return is_not;
}

}  // namespace

absl::StatusOr<std::vector<bool>> FindWithoutInterval(const SolvedProblem& solved, const Eigen::MatrixXd& linear,
                                                      const Eigen::MatrixXd& curved, double sigma_scale,
                                                      const Options& options) {
  std::vector<bool> without(solved.parameters.size(), false);
  if (!solved.is_curved) return without;
  std::vector<bool> not_parabolic(without.size(), false);
  if (solved.is_way_curved) {
    ASSIGN_OR_RETURN(not_parabolic, FindNotParabolic(solved, linear, options));
  }
  const std::vector<bool> elsewhere = FindElsewhere(solved, linear + curved, sigma_scale);
  for (size_t i = 0; i < without.size(); ++i)
    without[i] = (not_parabolic[i] || elsewhere[i]) && !solved.null_space.involved[i];
  return without;
}

}  // namespace axiscal::identify
