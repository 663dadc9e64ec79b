#include "core/identify/datum.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "core/base/units.h"
#include "core/identify/reduction.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

// The problem with the constants of every linear axis as further offsets of each set-up, linearised at the solution.
struct Extended {
  Problem problem;
  Point point;
  NormalEquations normal;
  std::vector<int> own;  // per group: offsets that it had
  struct Constant {
    int axis = 0;
    size_t first = 0;  // run of the set-up
  };
  std::vector<std::vector<Constant>> constants;  // per group: those that were added
};

bool MayBeFreed(const MeasuringRun& one) {
  return one.path_readings == nullptr && one.free_datum.empty() && one.distortions.empty() && one.slips.empty();
}

// What was fitted, in the order of the estimates.
std::vector<Parameter> FittedParameters(const Fit& fit) {
  std::vector<Parameter> parameters = ListParameters(fit.point.model, true);
  if (parameters.size() != fit.result.estimates.size()) parameters = ListParameters(fit.point.model, false);
  return parameters;
}

Extended Extend(const Fit& fit) {
  Extended out{fit.problem, fit.point, {}, {}, {}};
  const machine::Machine& machine = *fit.problem.machine;
  std::vector<int> axes;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    if (machine.axes[axis].kind == machine::AxisKind::kLinear && axes.size() < instruments::kMaxDatumAxes)
      axes.push_back(axis);
  }
  for (size_t g = 0; g < out.problem.groups.size(); ++g) {
    SetupGroup& group = out.problem.groups[g];
    out.own.push_back(static_cast<int>(group.parameters.size()));
    out.constants.emplace_back();
    for (const int number : group.runs) {
      const auto run = static_cast<size_t>(number), first = FirstOfSetup(fit.problem, run);
      if (!MayBeFreed(fit.problem.runs[run])) continue;
      std::vector<Eigen::Index>& offsets = out.problem.offsets_of_run[run];
      for (const int axis : axes) {
        AddDatum(machine, axis, &out.problem.runs[run]);
        if (first != run) continue;
        offsets.push_back(static_cast<Eigen::Index>(group.parameters.size()));
        group.parameters.push_back(out.problem.runs[run].setup.back());
        out.constants[g].push_back({axis, run});
      }
      if (first != run) offsets = out.problem.offsets_of_run[first];
    }
    Eigen::VectorXd setup = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(group.parameters.size()));
    setup.head(out.own[g]) = out.point.setup[g];
    out.point.setup[g] = std::move(setup);
  }
  out.normal = Assemble(out.problem, out.point, FittedParameters(fit));
  return out;
}

// Only the constants that `is_free` says, per group and added axis.
struct Reduction {
  Problem problem;  // groups alone
  Point point;
  NormalEquations normal;
};
using Freed = std::vector<std::vector<bool>>;

Reduction With(const Extended& extended, const Freed& is_free) {
  Reduction out;
  out.problem.machine = extended.problem.machine;
  out.point.model = extended.point.model;
  for (size_t g = 0; g < extended.problem.groups.size(); ++g) {
    const SetupGroup& group = extended.problem.groups[g];
    const GroupNormal& all = extended.normal.groups[g];
    std::vector<int> kept;
    SetupGroup smaller{{}, group.runs};
    for (int k = 0; k < all.setup_count; ++k) {
      if (k >= extended.own[g] && !is_free[g][static_cast<size_t>(k - extended.own[g])]) continue;
      kept.push_back(k);
      smaller.parameters.push_back(group.parameters[static_cast<size_t>(k)]);
    }
    GroupNormal normal;
    normal.setup_count = static_cast<int>(kept.size());
    out.point.setup.push_back(extended.point.setup[g](kept));
    for (Eigen::Index k = all.setup_count; k < all.gram.cols(); ++k) kept.push_back(static_cast<int>(k));
    normal.gram = all.gram(kept, kept);
    out.normal.groups.push_back(std::move(normal));
    out.problem.groups.push_back(std::move(smaller));
  }
  out.normal.parameters = extended.normal.parameters;
  out.normal.row_count = extended.normal.row_count;
  return out;
}

// Errors of the gauge, which stand at zero, are held, as in the fit.
std::vector<int> HeldIn(const Fit& fit) {
  const std::vector<Parameter> parameters = FittedParameters(fit);
  std::vector<int> held;
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (!fit.result.estimates[i].identifiable && ValueOf(fit.point.model, parameters[i]) == 0.0)
      held.push_back(static_cast<int>(i));
  }
  return held;
}

double GainOf(const Extended& extended, const Freed& is_free, const std::vector<int>& held) {
  const Reduction reduction = With(extended, is_free);
  return SolveStep(reduction.problem, reduction.point, reduction.normal, held).decrement;
}

}  // namespace

std::vector<reports::WarningFacts> FindMovedDatum(const Fit& fit, double least_share) {
  const size_t groups = fit.problem.groups.size();
  const auto freedom = static_cast<double>(fit.result.fit.degrees_of_freedom);
  constexpr double kChance = 5.0;  // standard deviations of chi-square
  // What chi-square is of readings that scatter as stated, also where the fit took a larger sigma to converge.
  const double expected = freedom / (fit.result.noise_scale * fit.result.noise_scale);
  const double chi2 = fit.result.fit.chi2_per_dof * freedom, excess = chi2 - expected;
  if (CountSetups(fit.problem) < 2 || freedom < 1.0 || fit.result.model.terms.empty()) return {};
  // What sessions disagree by may go into set-ups before it shows in the readings: balls and run-outs then stand
  // farther from their places than mounting leaves them.
  double priors = 0.0;
  for (const SetupGroup& group : fit.problem.groups) {
    priors += static_cast<double>(std::count_if(
        group.parameters.begin(), group.parameters.end(),
        [](const instruments::SetupParameter& one) { return one.is_placed && std::isfinite(one.prior_sigma); }));
  }
  const double pulled = JudgingPriorSquares(fit.problem, fit.point) - priors;
  if (excess < kChance * std::sqrt(2.0 / freedom) * expected && pulled <= kChance * std::sqrt(2.0 * priors)) return {};
  const Extended extended = Extend(fit);
  const std::vector<int> held = HeldIn(fit);
  Freed is_free(groups);
  for (size_t g = 0; g < groups; ++g) is_free[g].assign(extended.constants[g].size(), false);
  // As many gains must not be chance by the scatter that they leave: five standard uncertainties per constant.
  constexpr double kLeastGain = 25.0;
  const double without = GainOf(extended, is_free, held);  // of the solution itself: nearly zero
  double gain = 0.0;
  while (true) {
    Freed best;
    double most = gain;
    for (size_t g = 0; g < groups; ++g) {
      for (size_t k = 0; k < is_free[g].size(); ++k) {
        if (is_free[g][k]) continue;
        Freed tried = is_free;
        tried[g][k] = true;
        const double total = GainOf(extended, tried, held) - without;
        if (total <= most) continue;
        most = total;
        best = std::move(tried);
      }
    }
    const double left = std::max(expected, chi2 - most) / freedom;
    if (best.empty() || most - gain < kLeastGain * left) break;
    is_free = std::move(best);
    gain = most;
  }
  if (!(gain > least_share * std::max(excess, pulled))) return {};
  const Reduction reduction = With(extended, is_free);
  const GaussNewtonStep step = SolveStep(reduction.problem, reduction.point, reduction.normal, held);
  const Covariance covariance = CovarianceOf(reduction.problem, reduction.point, reduction.normal, held,
                                             std::sqrt(std::max(expected, chi2 - gain) / freedom));
  reports::DatumMoved moved;
  for (size_t g = 0; g < groups; ++g) {
    std::map<size_t, reports::DatumMoved::Group> by_setup;
    Eigen::Index at = extended.own[g];
    for (size_t k = 0; k < is_free[g].size(); ++k) {
      if (!is_free[g][k]) continue;
      const Extended::Constant& one = extended.constants[g][k];
      by_setup[one.first].axes.push_back({extended.problem.machine->axes[one.axis].name,
                                          step.setup[g][at] * base::kUmPerMm,
                                          covariance.setup_sigma[g][at] * base::kUmPerMm});
      ++at;
    }
    for (const int run : extended.problem.groups[g].runs) {
      const auto of = by_setup.find(FirstOfSetup(extended.problem, static_cast<size_t>(run)));
      if (of != by_setup.end()) of->second.sessions.push_back(extended.problem.runs[static_cast<size_t>(run)].session);
    }
    for (auto& [first, group] : by_setup) moved.groups.push_back(std::move(group));
  }
  return {std::move(moved)};
}

}  // namespace axiscal::identify
