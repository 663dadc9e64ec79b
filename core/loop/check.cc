#include "core/loop/check.h"

#include <algorithm>
#include <cmath>

#include "core/base/demand.h"
#include "core/identify/reduction.h"
#include "core/loop/noise.h"

namespace axiscal::loop {

absl::StatusOr<identify::Fit> Check::Under(const machine::ErrorModel& model) const {
  DEMAND(!runs_.empty());
  return identify::CheckRuns(machine_, runs_, model, options_);
}

absl::Status Check::Settle(const identify::Fit& best) {
  ASSIGN_OR_RETURN(identify::Fit fit, Under(best.result.model));
  problem_ = std::move(fit.problem);
  point_ = std::move(fit.point);
  problem_.noise = EstimateNoise(problem_, fit.residuals_mm);
  for (size_t i = 0; i < problem_.runs.size(); ++i) {
    const instruments::MeasuringRun& run = problem_.runs[i];
    double factor = 0.0, ar1 = 0.0;
    int count = 0;
    for (size_t k = 0; k < best.problem.runs.size(); ++k) {
      if (best.problem.runs[k].kind != run.kind) continue;
      factor += best.problem.noise[k].sigma_mm / best.problem.runs[k].sigma_mm;
      ar1 += best.problem.noise[k].ar1;
      ++count;
    }
    if (count > 0) problem_.noise[i] = {factor / count * run.sigma_mm, ar1 / count};
  }
  return absl::OkStatus();
}

bool Check::IsAdequate(double squares) const {
  double count = 0.0;
  for (const std::vector<bool>& used : problem_.is_used)
    count += static_cast<double>(std::count(used.begin(), used.end(), true));
  constexpr double kBeyondChance = 6.0;  // standard deviations of chi-square
  return squares < count + kBeyondChance * std::sqrt(2.0 * count);
}

absl::StatusOr<double> Check::Squares(const machine::ErrorModel& model) const {
  identify::Problem problem = problem_;
  problem.fixed_model = model;
  identify::Options options = options_;
  options.set_outliers_aside = false;
  options.raise_noise = false;
  options.max_iterations = 8;  // under a model that holds three do
  const absl::StatusOr<identify::Fit> fit = identify::FitProblem(std::move(problem), {}, options);
  if (absl::IsCancelled(fit.status())) return fit.status();
  if (!fit.ok()) return INFINITY;
  return identify::WhitenedSquares(fit->problem, fit->residuals_mm) + identify::PriorSquares(fit->problem, fit->point);
}

}  // namespace axiscal::loop
