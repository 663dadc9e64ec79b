#include "core/identify/honesty.h"

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "core/base/units.h"
#include "core/instruments/resolution.h"
#include "core/machine/error_json.h"

namespace axiscal::identify {
namespace {

constexpr double kTold = 1.0 / 3.0;  // of a plausible size: left uncertain by more, an error is not told

// What counts as plausible, mm or rad per the shape's reference.
Eigen::VectorXd PlausibleSizes(const Solution& solution, const std::vector<Parameter>& parameters) {
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(parameters.size()));
  for (size_t i = 0; i < parameters.size(); ++i) {
    const machine::ErrorTerm& term = solution.point.model.terms[parameters[i].term];
    sizes[static_cast<Eigen::Index>(i)] = kPlausible * machine::AmplitudeFactor(term);
  }
  return sizes;
}

// Of the errors, p x p, by the readings' noise as stated: neither scaled nor with what held errors add.
Eigen::MatrixXd LinearCovariance(const Problem& problem, const Solution& solution, const std::vector<int>& held) {
  return InverseBeside(Reduce(problem, solution.point, solution.normal, Priors::kAll), held);
}

// Touches bend the problem: a turn of a face that was touched in its middle shows by its square, and two turns alike.
bool MayBend(const Problem& problem) {
  return std::any_of(problem.runs.begin(), problem.runs.end(),
                     [](const instruments::MeasuringRun& run) { return run.kind == instruments::Kind::kTouch; });
}

bool Contains(const std::vector<int>& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

std::vector<int> StillHeld(const Problem& problem, const Solution& solution, const std::vector<Parameter>& parameters,
                           const NullSpace& null_space) {
  if (null_space.fixed.empty()) return {};
  const Reduced reduced = Reduce(problem, solution.point, solution.normal, Priors::kInformative);
  const Eigen::VectorXd sizes = PlausibleSizes(solution, parameters)(null_space.fixed);
  Eigen::MatrixXd shows = sizes.asDiagonal() * InformationBeside(reduced, null_space.fixed) * sizes.asDiagonal();
  std::vector<int> held = null_space.fixed;
  // The best-seen first, each time in what the others leave: chi-square by which a plausible size of it shows, of
  // readings that may scatter by more than stated. What shows less bends the others by less than their uncertainty.
  const double least = std::max(1.0, solution.cost / std::max(1, solution.normal.row_count));
  Eigen::Index best = 0;
  while (shows.diagonal().maxCoeff(&best) > least) {
    held.erase(std::find(held.begin(), held.end(), null_space.fixed[best]));
    shows -= (shows.col(best) * shows.row(best) / shows(best, best)).eval();
    shows.row(best).setZero();
    shows.col(best).setZero();
  }
  return held;
}

// The errors that are held but the one which bends the others most, if any. One that no reading shows without the weak
// priors may well show with them (three readings leave it to the set-up, but not to a run-out of a tenth): held at zero
// it is a misfit, and where errors that are identified take it up, their numbers are wrong.
std::vector<int> HeldUnlessItBends(const Problem& problem, const Solution& solution,
                                   const std::vector<Parameter>& parameters, const NullSpace& null_space,
                                   std::vector<int> held) {
  if (held.empty()) return held;
  constexpr double kAsks = 4.0;   // chi-square: two standard uncertainties, or it is chance
  constexpr double kBends = 0.5;  // standard uncertainties of an error that is identified
  // Readings may scatter by more than stated.
  const double scale = std::max(1.0, solution.cost / std::max(1, solution.normal.row_count));
  const Reduced reduced = Reduce(problem, solution.point, solution.normal, Priors::kAll);
  const Eigen::VectorXd information = InformationBeside(reduced, held).diagonal(), gradient = reduced.gradient(held);
  const Eigen::VectorXd sizes = PlausibleSizes(solution, parameters)(held);
  const Eigen::MatrixXd covariance = InverseBeside(reduced, held);
  // One at a time, as the gradient is that of this solution, and no further than is plausible: what hardly shows
  // promises anything at sizes that no machine has.
  Eigen::Index worst = -1;
  double most = kBends * std::sqrt(scale);
  for (Eigen::Index k = 0; k < information.size(); ++k) {
    const double slope = std::abs(gradient[k]);
    const double move = slope < information[k] * sizes[k] ? slope / information[k] : sizes[k];
    const double gain = 2.0 * slope * move - std::max(0.0, information[k]) * move * move;
    if (!(gain > kAsks * scale)) continue;
    const Eigen::VectorXd shift = move * (covariance * reduced.information.col(held[static_cast<size_t>(k)]));
    for (Eigen::Index i = 0; i < shift.size(); ++i) {
      if (null_space.involved[static_cast<size_t>(i)] || !(covariance(i, i) > 0.0)) continue;
      const double bend = std::abs(shift[i]) / std::sqrt(covariance(i, i));
      if (bend <= most) continue;
      most = bend;
      worst = k;
    }
  }
  if (worst >= 0) held.erase(held.begin() + worst);
  return held;
}

absl::StatusOr<std::vector<Solution>> SolveTwins(const Problem& problem, Solution solution, const NullSpace& holding,
                                                 const Options& options) {
  Options quiet = options;
  quiet.progress = nullptr;
  std::vector<Point> starts;
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    std::vector<int> turns;
    for (size_t k = 0; k < problem.groups[g].parameters.size(); ++k) {
      if (problem.groups[g].parameters[k].is_angle) turns.push_back(static_cast<int>(k));
    }
    for (unsigned reversed = 1; reversed < 1u << turns.size(); ++reversed) {
      Point start = solution.point;
      for (size_t k = 0; k < turns.size(); ++k) {
        if (reversed >> k & 1u) start.setup[g][turns[k]] *= -1.0;
      }
      starts.push_back(std::move(start));
    }
  }
  std::vector<Solution> twins = {std::move(solution)};
  for (const Point& start : starts) {
    absl::StatusOr<Solution> twin = Solve(problem, start, holding, quiet);
    if (twin.status().code() == absl::StatusCode::kCancelled) return twin.status();
    if (twin.ok() && twin->has_converged) twins.push_back(*std::move(twin));
  }
  std::stable_sort(twins.begin(), twins.end(), [](const Solution& a, const Solution& b) { return a.cost < b.cost; });
  return twins;
}

std::vector<bool> FindAmbiguous(const std::vector<Solution>& best_first, const std::vector<Parameter>& parameters,
                                const Eigen::MatrixXd& linear, double scale) {
  std::vector<bool> is_ambiguous(parameters.size(), false);
  for (const Solution& other : best_first) {
    constexpr double kRefused = 16.0;  // four standard uncertainties
    if (other.cost - best_first[0].cost > kRefused * scale * scale) break;
    for (size_t i = 0; i < parameters.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const double apart =
          ValueOf(other.point.model, parameters[i]) - ValueOf(best_first[0].point.model, parameters[i]);
      if (std::abs(apart) > scale * std::sqrt(linear(at, at))) is_ambiguous[i] = true;
    }
  }
  return is_ambiguous;
}

absl::StatusOr<std::vector<bool>> FindBent(const Problem& problem, const Solution& solution,
                                           const std::vector<Parameter>& parameters, const NullSpace& holding,
                                           const Eigen::MatrixXd& linear, const Options& options) {
  const int p = static_cast<int>(parameters.size());
  std::vector<bool> is_bent(p, false);
  Options quiet = options;
  quiet.progress = nullptr;
  for (int i = 0; i < p; ++i) {
    const double variance = linear(i, i);
    if (holding.involved[i] || parameters[i].is_nonlinear || Contains(holding.fixed, i) || !(variance > 0.0)) continue;
    NullSpace beside = holding;
    beside.fixed.push_back(i);
    constexpr double kMoved = 2.0, kLeast = 0.5, kMost = 2.0;  // standard uncertainties; of the chi-square expected
    for (const double sign : {-1.0, 1.0}) {
      Point moved = solution.point;
      for (int j = 0; j < p; ++j) {
        const double share = sign * kMoved * linear(j, i) / std::sqrt(variance);
        SetValue(parameters[j], ValueOf(moved.model, parameters[j]) + share, &moved.model);
      }
      const absl::StatusOr<Solution> profile = Solve(problem, moved, beside, quiet);
      if (profile.status().code() == absl::StatusCode::kCancelled) return profile.status();
      const double rise = profile.ok() ? (profile->cost - solution.cost) / (kMoved * kMoved) : NAN;
      if (!(rise >= kLeast && rise <= kMost)) is_bent[i] = true;
    }
  }
  return is_bent;
}

}  // namespace

absl::StatusOr<Stand> StandOf(const Problem& problem, Solution solution, const std::vector<Parameter>& parameters,
                              const NullSpace& null_space, const Options& options) {
  Stand stand{null_space, {}, solution.is_bent};
  stand.holding.fixed = StillHeld(problem, solution, parameters, null_space);
  if (stand.holding.fixed != null_space.fixed) {
    ASSIGN_OR_RETURN(Solution freed, Solve(problem, solution.point, stand.holding, options));
    stand.is_bent |= freed.is_bent;
    if (freed.has_converged) {
      solution = std::move(freed);
    } else {
      stand.holding.fixed = null_space.fixed;
    }
  }
  for (bool has_changed = options.judge_bends; has_changed;) {
    const std::vector<int> held = HeldUnlessItBends(problem, solution, parameters, null_space, stand.holding.fixed);
    has_changed = held != stand.holding.fixed;
    if (!has_changed) break;
    NullSpace fewer = stand.holding;
    fewer.fixed = held;
    ASSIGN_OR_RETURN(Solution freed, Solve(problem, solution.point, fewer, options));
    if (!freed.has_converged) break;
    stand.is_bent |= freed.is_bent;
    stand.holding = std::move(fewer);
    solution = std::move(freed);
  }
  stand.is_bent &= options.judge_bends && MayBend(problem);
  if (!stand.is_bent) {
    stand.best_first.push_back(std::move(solution));
    return stand;
  }
  ASSIGN_OR_RETURN(stand.best_first, SolveTwins(problem, std::move(solution), stand.holding, options));
  return stand;
}

absl::StatusOr<std::vector<bool>> FindWithoutInterval(const Problem& problem, const Solution& solution,
                                                      const Stand& stand, const std::vector<Parameter>& parameters,
                                                      double scale, const Options& options) {
  std::vector<bool> open(parameters.size(), false);
  if (!stand.is_bent) return open;
  const Eigen::MatrixXd linear = LinearCovariance(problem, solution, stand.holding.fixed);
  ASSIGN_OR_RETURN(const std::vector<bool> bent,
                   FindBent(problem, solution, parameters, stand.holding, linear, options));
  const std::vector<bool> ambiguous = FindAmbiguous(stand.best_first, parameters, linear, scale);
  for (size_t i = 0; i < open.size(); ++i) open[i] = (bent[i] || ambiguous[i]) && !stand.holding.involved[i];
  return open;
}

OwedToPriors FindOwedToPriors(const Problem& problem, const Solution& solution,
                              const std::vector<Parameter>& parameters, const NullSpace& null_space,
                              const std::vector<int>& held) {
  const int p = static_cast<int>(parameters.size());
  OwedToPriors owed;
  owed.involved.assign(p, false);
  const Eigen::MatrixXd linear = LinearCovariance(problem, solution, held);
  const Eigen::MatrixXd alone =
      InverseBeside(Reduce(problem, solution.point, solution.normal, Priors::kInformative), held);
  const Eigen::VectorXd sizes = PlausibleSizes(solution, parameters);
  for (int i = 0; i < p; ++i) {
    if (null_space.involved[i] || parameters[i].is_nonlinear || Contains(held, i)) continue;
    constexpr double kHalf = 0.5;
    owed.involved[i] = std::sqrt(linear(i, i)) > kTold * sizes[i] && !(linear(i, i) >= kHalf * alone(i, i));
  }
  // Named together where readings alone would move them together.
  constexpr double kTogether = 0.9;
  std::vector<bool> is_named(p, false);
  for (int i = 0; i < p; ++i) {
    if (!owed.involved[i] || is_named[i]) continue;
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(p);
    for (int j = 0; j < p; ++j) {
      if (!owed.involved[j] || !(std::abs(alone(i, j)) >= kTogether * std::sqrt(alone(i, i) * alone(j, j)))) continue;
      direction[j] = alone(i, j) / alone(i, i);
      is_named[j] = true;
    }
    direction[i] = 1.0;
    owed.directions.push_back(std::move(direction));
  }
  return owed;
}

std::vector<bool> FindUnsupported(const Solution& solution, const std::vector<Parameter>& parameters,
                                  const OwedToPriors& owed, const NullSpace& null_space, const std::vector<int>& held,
                                  const Covariance& covariance) {
  std::vector<bool> unsupported = owed.involved;
  const Eigen::VectorXd sizes = PlausibleSizes(solution, parameters);
  for (Eigen::Index i = 0; i < sizes.size(); ++i) {
    const auto at = static_cast<size_t>(i);
    if (null_space.involved[at] && std::sqrt(covariance.errors(i, i)) > kTold * sizes[i]) unsupported[at] = true;
    for (size_t k = 0; k < null_space.fixed.size(); ++k) {
      const bool is_freed = !Contains(held, null_space.fixed[k]);
      if (is_freed && null_space.directions(static_cast<Eigen::Index>(k), i) != 0.0) unsupported[at] = true;
    }
  }
  return unsupported;
}

double CoverageFactor(bool is_estimated, int degrees_of_freedom) {
  constexpr double kNormal = 1.959964, kUpper = 0.975;
  if (!is_estimated || degrees_of_freedom < 1) return kNormal;
  return boost::math::quantile(boost::math::students_t(static_cast<double>(degrees_of_freedom)), kUpper);
}

std::vector<Warning> WarningsOf(const Result& result, const std::vector<Parameter>& parameters,
                                const std::vector<bool>& open, const std::vector<bool>& unsupported) {
  std::vector<Warning> warnings;
  constexpr double kPoorFit = 4.0;  // twice the stated sigma
  if (result.fit.chi2_per_dof > kPoorFit) {
    warnings.push_back({"scatter", absl::StrFormat("the readings scatter by %.1f times their stated sigma about this "
                                                   "model: it lacks something, or a session is bad",
                                                   std::sqrt(result.fit.chi2_per_dof))});
  }
  const auto set_aside = std::count_if(result.outliers.begin(), result.outliers.end(),
                                       [](const Outlier& outlier) { return !outlier.gate.has_value(); });
  constexpr double kChips = 0.05;  // of all readings: dirty sessions have one or two in a hundred
  constexpr int kFew = 3;
  if (set_aside > std::max<double>(kFew, kChips * result.fit.readings)) {
    warnings.push_back({"set-aside", absl::StrFormat("%d of %d readings stand out and were set aside, too many for "
                                                     "chips: the model lacks something that they show",
                                                     set_aside, result.fit.readings)});
  }
  std::string names;
  for (size_t i = 0; i < open.size(); ++i) {
    if (open[i]) absl::StrAppend(&names, names.empty() ? "" : ", ", result.estimates[i].name);
  }
  if (!names.empty()) {
    warnings.push_back(
        {"interval", names + ": the readings leave the set-up so open that no interval can be stated (another set-up "
                             "with other errors explains them as well)"});
  }
  names.clear();
  for (size_t i = 0; i < unsupported.size(); ++i) {
    const Estimate& estimate = result.estimates[i];
    const double size = ValueOf(result.model, parameters[i]) / estimate.factor;
    if (!unsupported[i] || parameters[i].is_nonlinear || !(std::abs(size) > kPlausible)) continue;
    absl::StrAppend(&names, names.empty() ? "" : ", ",
                    absl::StrFormat("%s at %.0f %s", estimate.name, size, estimate.unit));
  }
  if (!names.empty()) {
    warnings.push_back({"no-number", names + ": the fit ended there because something had to take up what the readings "
                                             "show, but no reading supports such a size; do not compensate with this "
                                             "model away from the measured poses"});
  }
  return warnings;
}

std::vector<Warning> CoarseReadings(const Problem& problem) {
  std::vector<Warning> warnings;
  for (const instruments::MeasuringRun& run : problem.runs) {
    const double resolution_mm = instruments::CoarseResolutionOf(run);
    if (resolution_mm == 0.0) continue;
    warnings.push_back(
        {"resolution",
         absl::StrFormat(
             "session '%s': readings stand in steps of %.4g um, expected at most %g times the stated sigma of "
             "%.4g um: what rounding hides is counted as noise of %.4g um",
             run.session, resolution_mm * base::kUmPerMm, instruments::kCoarse, run.sigma_mm * base::kUmPerMm,
             instruments::RoundingSigma(run) * base::kUmPerMm)});
  }
  return warnings;
}

std::vector<Warning> SharedWithHeld(const Problem& problem, const Covariance& covariance,
                                    const std::vector<MeasuredIn>& held_from) {
  std::string readings, offsets;
  const auto append = [](const std::string& text, std::string* to) {
    absl::StrAppend(to, to->empty() ? "" : ", ", text);
  };
  const auto is_shared = [&](std::string MeasuredIn::*what, const std::string& name) {
    return std::any_of(held_from.begin(), held_from.end(), [&](const MeasuredIn& from) { return from.*what == name; });
  };
  for (const instruments::MeasuringRun& run : problem.runs) {
    if (is_shared(&MeasuredIn::session, run.session)) append(run.session, &readings);
  }
  // By how much of its sigma an error moves with the offset's stated one.
  constexpr double kRests = 0.3;  // less: the stages' errors correlate by less than a tenth
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    const SetupGroup& group = problem.groups[g];
    if (!is_shared(&MeasuredIn::setup, group.name)) continue;
    for (size_t k = 0; k < group.parameters.size(); ++k) {
      const instruments::SetupParameter& parameter = group.parameters[k];
      if (parameter.is_weak || !std::isfinite(parameter.prior_sigma)) continue;
      const Eigen::ArrayXd moved = covariance.with_setup[g].col(static_cast<Eigen::Index>(k)) / parameter.prior_sigma;
      const Eigen::ArrayXd sigma = covariance.errors.diagonal().array().max(0.0).sqrt();
      if ((moved.abs() > kRests * sigma && sigma > 0.0).any())
        append(absl::StrCat(parameter.name, " of set-up ", group.name), &offsets);
    }
  }
  constexpr char kAdvice[] =
      ": the stated sigmas take both stages for independent; identify from all sessions together";
  std::vector<Warning> warnings;
  if (!readings.empty()) {
    warnings.push_back(
        {"held", absl::StrCat("the held errors come from sessions that are used again (", readings, ")", kAdvice)});
  } else if (!offsets.empty()) {
    warnings.push_back(
        {"held", absl::StrCat("the held errors rest on the same stated sigma as this fit (", offsets, ")", kAdvice)});
  }
  return warnings;
}

}  // namespace axiscal::identify
