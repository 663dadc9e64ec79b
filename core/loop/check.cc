#include "core/loop/check.h"

#include <algorithm>
#include <cmath>

#include "core/base/demand.h"
#include "core/identify/noise.h"
#include "core/identify/reduction.h"
#include "core/instruments/distortion.h"

namespace axiscal::loop {

using instruments::MeasuringRun;

absl::StatusOr<identify::Fit> Check::Under(const identify::Fit& fit) {
  DEMAND(!runs_.empty());
  // A model is asked for when an attempt ends, when its figures are stated and when it is compared.
  const bool is_known = last_model_.has_value() && last_model_->terms == fit.result.model.terms;
  const bool any_fault = std::any_of(fit.problem.runs.begin(), fit.problem.runs.end(),
                                     [](const MeasuringRun& run) { return !run.distortions.empty(); });
  if (is_known && ((!SharesSetup(fit.problem) && !any_fault) || last_setup_ == fit.point.setup))
    return under_last_model_;
  last_model_.reset();
  // An instrument that is at fault is so here, too.
  std::vector<MeasuringRun> runs = runs_;
  instruments::AddDistortionsOf(fit.problem.runs, &runs);
  ASSIGN_OR_RETURN(under_last_model_, identify::CheckRuns(machine_, std::move(runs), fit, options_));
  last_model_ = fit.result.model;
  last_setup_ = fit.point.setup;
  return under_last_model_;
}

bool Check::SharesSetup(const identify::Problem& fit) const {
  return std::any_of(runs_.begin(), runs_.end(), [&](const MeasuringRun& run) {
    return identify::SharedSetup(run, fit) || identify::SharedScale(run, fit);
  });
}

bool Check::Settled::IsUnder(const identify::Fit& fit) const {
  const auto is_same = [](const identify::Noise& a, const identify::Noise& b) {
    return a.sigma_mm == b.sigma_mm && a.ar1 == b.ar1;
  };
  // What is used first: only set-ups of the same runs compare.
  return is_used == fit.problem.is_used && model.terms == fit.result.model.terms && setup == fit.point.setup &&
         std::equal(noise.begin(), noise.end(), fit.problem.noise.begin(), fit.problem.noise.end(), is_same);
}

std::vector<MeasuringRun> Check::After(std::vector<MeasuringRun> runs) const {
  const size_t fitted = runs.size();
  // That no session and no set-up bears already, whatever they are called.
  std::string prefix = "check ";
  const auto bears = [&prefix](const MeasuringRun& run) {
    return run.session.rfind(prefix, 0) == 0 || run.setup_name.rfind(prefix, 0) == 0;
  };
  while (std::any_of(runs.begin(), runs.end(), bears) || std::any_of(runs_.begin(), runs_.end(), bears))
    prefix += "check ";
  for (const MeasuringRun& run : runs_) {
    runs.push_back(run);
    const bool is_known = std::any_of(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(fitted),
                                      [&](const MeasuringRun& other) { return other.session == run.session; });
    if (is_known) runs.back().session = prefix + run.session;
    const bool is_shared =
        run.is_setup_stated &&
        std::any_of(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(fitted), [&](const MeasuringRun& other) {
          return other.setup_name == run.setup_name && other.slips.empty();
        });
    if (!is_shared) runs.back().setup_name = prefix + run.setup_name;
  }
  instruments::AddDistortionsOf(
      std::vector<MeasuringRun>(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(fitted)), &runs);
  return runs;
}

absl::Status Check::Settle(const identify::Fit& best) {
  if (settled_.IsUnder(best)) return absl::OkStatus();
  ASSIGN_OR_RETURN(identify::Fit fit, Under(best));
  settled_ = {best.result.model,
              best.point.setup,
              best.problem.noise,
              best.problem.is_used,
              std::move(fit.problem),
              std::move(fit.point),
              0.0,
              nullptr};
  identify::Problem& problem = settled_.problem;
  problem.noise = EstimateNoise(problem, fit.residuals_mm);
  for (const std::vector<bool>& used : best.problem.is_used)
    settled_.noise_readings += static_cast<double>(std::count(used.begin(), used.end(), true));
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const MeasuringRun& run = problem.runs[i];
    double factor = 0.0, ar1 = 0.0, white_share = 0.0;
    int count = 0;
    for (size_t k = 0; k < best.problem.runs.size(); ++k) {
      if (best.problem.runs[k].kind != run.kind) continue;
      factor += best.problem.noise[k].sigma_mm / best.problem.runs[k].sigma_mm;
      ar1 += best.problem.noise[k].ar1;
      white_share += best.problem.noise[k].white_share;
      ++count;
    }
    if (count > 0) problem.noise[i] = {factor / count * run.sigma_mm, ar1 / count, white_share / count};
  }
  return absl::OkStatus();
}

double Check::UsedOf(size_t run) const {
  return static_cast<double>(
      std::count(settled_.problem.is_used[run].begin(), settled_.problem.is_used[run].end(), true));
}

bool Check::IsChance(double squares, double count) const {
  constexpr double kBeyondChance = 6.0;  // standard deviations
  return squares < count + kBeyondChance * std::sqrt(2.0 * count + 2.0 * count * count / settled_.noise_readings);
}

absl::StatusOr<std::shared_ptr<const identify::Fit>> Check::Joint(const identify::Fit& best) {
  DEMAND(settled_.problem.runs.size() == runs_.size());
  const bool is_settled_under = settled_.IsUnder(best);
  if (is_settled_under && settled_.joint != nullptr) return settled_.joint;
  const size_t fitted = best.problem.runs.size();
  ASSIGN_OR_RETURN(identify::Problem joint, identify::MakeProblem(machine_, After(best.problem.runs)));
  for (size_t i = 0; i < joint.runs.size(); ++i) {
    const identify::Problem& own = i < fitted ? best.problem : settled_.problem;
    joint.noise[i] = own.noise[i < fitted ? i : i - fitted];
    joint.is_used[i] = own.is_used[i < fitted ? i : i - fitted];
  }
  identify::Options options = options_;
  options.set_outliers_aside = false;
  options.raise_noise = false;
  // Balls that the check sessions alone pulled far across the bar come back in short steps.
  options.max_iterations *= 5;
  identify::Point start = identify::StartingPoint(joint, best.result.model);
  for (size_t i = joint.runs.size(); i-- > 0;) {  // an offset that is shared: the fit's, whose sessions come first
    start.setup[static_cast<size_t>(joint.group_of_run[i])](joint.offsets_of_run[i]) =
        i < fitted ? identify::SetupOf(best.problem, best.point, i)
                   : identify::SetupOf(settled_.problem, settled_.point, i - fitted);
  }
  ASSIGN_OR_RETURN(identify::Fit fit, identify::FitProblem(std::move(joint), best.result.model, options, start.setup));
  auto kept = std::make_shared<const identify::Fit>(std::move(fit));
  if (is_settled_under) settled_.joint = kept;
  return kept;
}

double Check::SquaresAlone() const {
  return identify::WhitenedSquares(settled_.problem, ResidualsOf(settled_.problem, settled_.point));
}

double Check::SquaresIn(const identify::Fit& joint, size_t fitted) const {
  double squares = 0.0;
  for (size_t i = fitted; i < joint.problem.runs.size(); ++i)
    squares += identify::WhitenedSquaresOf(joint.problem, i, joint.residuals_mm[i]);
  return squares;
}

bool Check::IsExplained(const identify::Fit& joint, const identify::Fit& best) const {
  double count = 0.0;
  for (size_t i = 0; i < settled_.problem.runs.size(); ++i) count += UsedOf(i);
  return IsChance(identify::WhitenedSquares(joint.problem, joint.residuals_mm) -
                      identify::WhitenedSquares(best.problem, best.residuals_mm),
                  count);
}

bool Check::IsForetold(const identify::Fit& joint, const identify::Fit& best) {
  constexpr double kBeyondChance = 3.0;  // standard deviations of the ratio: one time in a thousand by chance
  const double own = best.result.fit.degrees_of_freedom, added = joint.result.fit.degrees_of_freedom - own;
  if (!(own > 0.0 && added > 0.0)) return false;
  const double left = identify::WhitenedSquares(best.problem, best.residuals_mm);
  const double beyond = identify::WhitenedSquares(joint.problem, joint.residuals_mm) - left;
  return beyond / added <= left / own * (1.0 + kBeyondChance * std::sqrt(2.0 / added + 2.0 / own));
}

Unexplained Check::ExcessOf(size_t run, double squares) const {
  const double excess = std::max(0.0, squares / UsedOf(run) - 1.0);
  return {Unexplained::kCheckSession, "t",
          runs_[run].time_s.front(),  runs_[run].time_s.back(),
          runs_[run].session,         settled_.problem.noise[run].sigma_mm * std::sqrt(excess)};
}

std::vector<Unexplained> Check::UnexplainedWhereFitted() const {
  const std::vector<Eigen::MatrixXd> residuals_mm = ResidualsOf(settled_.problem, settled_.point);
  std::vector<Unexplained> sessions;
  for (size_t i = 0; i < runs_.size(); ++i) {
    const double squares = identify::WhitenedSquaresOf(settled_.problem, i, residuals_mm[i]);
    if (UsedOf(i) > 0.0 && !IsChance(squares, UsedOf(i))) sessions.push_back(ExcessOf(i, squares));
  }
  return sessions;
}

absl::StatusOr<std::vector<Unexplained>> Check::UnexplainedSessions(const identify::Fit& best) {
  const absl::StatusOr<std::shared_ptr<const identify::Fit>> joint = Joint(best);
  if (absl::IsCancelled(joint.status())) return joint.status();
  // Where all together cannot be fitted each is judged under the errors of the fit sessions.
  if (!joint.ok()) return UnexplainedWhereFitted();
  std::vector<Unexplained> sessions;
  if (IsExplained(**joint, best)) return sessions;
  Unexplained worst;
  double most = -INFINITY;
  for (size_t i = 0; i < runs_.size(); ++i) {
    if (UsedOf(i) == 0.0) continue;
    const size_t at = best.problem.runs.size() + i;
    const double squares = identify::WhitenedSquaresOf((*joint)->problem, at, (*joint)->residuals_mm[at]);
    if (!IsChance(squares, UsedOf(i))) sessions.push_back(ExcessOf(i, squares));
    if (squares / UsedOf(i) > most) worst = ExcessOf(i, squares);
    most = std::max(most, squares / UsedOf(i));
  }
  if (sessions.empty()) sessions.push_back(worst);  // the errors bent to it: it shows in all of them together
  return sessions;
}

}  // namespace axiscal::loop
