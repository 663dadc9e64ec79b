#include "core/identify/fit_warnings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "absl/time/time.h"
#include "core/base/units.h"
#include "core/identify/plausible_errors.h"
#include "core/instruments/clock.h"
#include "core/instruments/resolution.h"
#include "core/instruments/tracker/tracker_model.h"
#include "core/shapes/depends_on.h"

namespace axiscal::identify {

std::vector<reports::WarningFacts> WarningsOf(const Result& result, const std::vector<Parameter>& parameters,
                                              const std::vector<bool>& without_interval,
                                              const std::vector<bool>& unsupported) {
  std::vector<reports::WarningFacts> warnings;
  if (result.fit.chi2_per_dof > reports::kPoorFitChi2PerDof)
    warnings.push_back(reports::Scatter{.times_sigma = std::sqrt(result.fit.chi2_per_dof)});
  const auto set_aside = std::count_if(result.outliers.begin(), result.outliers.end(),
                                       [](const Outlier& outlier) { return !outlier.gate.has_value(); });
  constexpr double kChips = 0.05;  // of all readings: dirty sessions have one or two in a hundred
  constexpr int kFew = 3;
  if (set_aside > std::max<double>(kFew, kChips * result.fit.readings))
    warnings.push_back(reports::SetAside{static_cast<int>(set_aside), result.fit.readings});
  reports::NoInterval no_interval;
  for (size_t i = 0; i < without_interval.size(); ++i) {
    if (without_interval[i]) no_interval.errors.push_back(result.estimates[i].name);
  }
  if (!no_interval.errors.empty()) warnings.push_back(std::move(no_interval));
  reports::NoNumber without_number;
  for (size_t i = 0; i < unsupported.size(); ++i) {
    const Estimate& estimate = result.estimates[i];
    const double size = ValueOf(result.model, parameters[i]) / estimate.factor;
    if (!unsupported[i] || parameters[i].is_nonlinear || !(std::abs(size) > kPlausible)) continue;
    without_number.errors.push_back({estimate.name, size, estimate.unit});
  }
  if (!without_number.errors.empty()) warnings.push_back(std::move(without_number));
  return warnings;
}

std::vector<reports::WarningFacts> FindCoarseReadings(const Problem& problem) {
  std::vector<reports::WarningFacts> warnings;
  for (const instruments::MeasuringRun& run : problem.runs) {
    const double resolution_mm = instruments::CoarseResolutionOf(run);
    if (resolution_mm == 0.0) continue;
    warnings.push_back(reports::CoarseReadings{.session = run.session,
                                               .step_um = resolution_mm * base::kUmPerMm,
                                               .sigma_um = run.sigma_mm * base::kUmPerMm,
                                               .rounding_sigma_um = instruments::RoundingSigma(run) * base::kUmPerMm,
                                               .most_sigmas = instruments::kCoarse});
  }
  return warnings;
}

std::vector<reports::WarningFacts> FindExpired(const Problem& problem) {
  std::vector<reports::WarningFacts> warnings;
  for (const instruments::MeasuringRun& run : problem.runs) {
    for (const session::Certificate& certificate : run.certificates) {
      if (run.started && *run.started < certificate.valid_until) continue;
      warnings.push_back(reports::Expired{
          run.session, certificate.of, certificate.number, certificate.due,
          run.started
              ? absl::FormatTime("%Y-%m-%d", absl::FromUnixMicros(base::ToUtcUs(*run.started)), absl::UTCTimeZone())
              : std::string()});
    }
  }
  return warnings;
}

std::vector<reports::WarningFacts> FindTwoClocks(const Problem& problem, const Result& result) {
  const auto overlap = instruments::FindOverlap(problem.runs);
  if (!overlap) return {};
  std::vector<std::string> errors;
  for (const machine::ErrorTerm& term : result.model.terms) {
    if (shapes::NeedsOneClock(term.shape)) errors.push_back(machine::NameOf(*problem.machine, term));
  }
  if (errors.empty()) return {};
  return {reports::TwoClocks{overlap->first, overlap->second, std::move(errors)}};
}

namespace {

// a x b = CrossMatrix(a) b.
Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return matrix;
}

}  // namespace

std::vector<reports::WarningFacts> FindMoved(const Problem& problem, const Point& point, const Covariance& covariance) {
  constexpr double kSurely = 4.0;
  std::vector<reports::WarningFacts> warnings;
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const instruments::MeasuringRun& run = problem.runs[i];
    const auto g = static_cast<size_t>(problem.group_of_run[i]);
    const Eigen::Index first = tracker::FirstMove(run.targets);
    if (run.targets.Moves() == 0) continue;
    reports::TrackerMoved most;
    const Eigen::Vector3d middle_mm = run.measured_mm.rowwise().mean();
    for (int move = 0; move < run.targets.Moves(); ++move) {
      const Eigen::Index at = first + tracker::kPoseOffsets * Eigen::Index{move};
      const Eigen::VectorXd& setup = point.setup[g];
      const Eigen::Matrix<double, 6, 1> moved = setup.segment<6>(at);
      const Eigen::Vector3d turned_rad = moved.tail<3>();
      // The pose turns what stands where it is read less the pose's own shift. Readings may tell nothing of that shift
      // along a direction (where a target stands on the tool is unknown, too): how far it went comes with both.
      const Eigen::Vector3d lever_mm = middle_mm - setup.head<3>();
      const Eigen::Vector3d went_mm = moved.head<3>() + turned_rad.cross(lever_mm);
      Eigen::Matrix<double, 3, 9> by_pose;  // the frame's shift, the move
      by_pose << -CrossMatrix(turned_rad), Eigen::Matrix3d::Identity(), -CrossMatrix(lever_mm);
      const Eigen::Matrix<Eigen::Index, 9, 1> offsets{0, 1, 2, at, at + 1, at + 2, at + 3, at + 4, at + 5};
      const Eigen::Matrix<double, 9, 9> spread = covariance.setup[g](offsets, offsets);
      const Eigen::Matrix3d spread_mm2 = by_pose * spread * by_pose.transpose();
      // Along the way that it went.
      const auto along = [](const Eigen::Vector3d& way, const Eigen::Matrix3d& of) {
        return way.norm() > 0.0 ? std::sqrt(std::max(0.0, way.normalized().dot(of * way.normalized()))) : 0.0;
      };
      const double sigma_mm = along(went_mm, spread_mm2);
      if (!(went_mm.norm() > kSurely * sigma_mm) || !(went_mm.norm() * base::kUmPerMm > most.moved_um)) continue;
      most = {.session = run.session,
              .references = static_cast<int>(run.targets.references.size()),
              .looks = run.targets.Moves() + 1,
              .moved_um = went_mm.norm() * base::kUmPerMm,
              .sigma_um = sigma_mm * base::kUmPerMm,
              .turned_urad = turned_rad.norm() * base::kUradPerRad,
              .turn_sigma_urad = along(turned_rad, spread.bottomRightCorner<3, 3>()) * base::kUradPerRad,
              .at_s = run.targets.looks_s[static_cast<size_t>(move) + 1]};
    }
    if (most.moved_um > 0.0) warnings.push_back(std::move(most));
  }
  return warnings;
}

namespace {

// What is about as far apart as the machine is large: points on its rotary axes, tool points and artefacts, and the
// paths of its linear axes, as stated or as measured.
double SizeMm(const Problem& problem) {
  const machine::Machine& machine = *problem.machine;
  std::vector<Eigen::Vector3d> points_mm;
  for (const machine::Axis& axis : machine.axes) {
    if (axis.kind == machine::AxisKind::kRotary) points_mm.push_back(axis.point_mm);
  }
  for (const instruments::MeasuringRun& run : problem.runs) {
    points_mm.push_back(run.tip_mm);
    points_mm.push_back(run.ball_mm);
  }
  double apart_mm = 0.0, path2_mm2 = 0.0;
  for (const Eigen::Vector3d& one : points_mm) {
    for (const Eigen::Vector3d& other : points_mm) apart_mm = std::max(apart_mm, (one - other).norm());
  }
  for (size_t axis = 0; axis < machine.axes.size(); ++axis) {
    const machine::Axis& a = machine.axes[axis];
    if (a.kind != machine::AxisKind::kLinear) continue;
    double low = INFINITY, high = -INFINITY;
    for (const instruments::MeasuringRun& run : problem.runs) {
      for (int k = 0; k < run.reading_count(); ++k) {
        low = std::min(low, run.PositionsOf(k)[axis]);
        high = std::max(high, run.PositionsOf(k)[axis]);
      }
    }
    const double path_mm = a.min_position && a.max_position ? *a.max_position - *a.min_position
                           : high > low                     ? high - low
                                                            : 0.0;
    path2_mm2 += path_mm * path_mm;
  }
  return std::max(apart_mm, std::sqrt(path2_mm2));
}

// Lengths that the files state and that somebody may have forgotten or counted twice, where they are within a tenth of
// `length_mm`.
void AddNear(const Problem& problem, double length_mm, std::vector<reports::BeyondSize::Radius>* near) {
  constexpr double kAbout = 0.1;
  const auto add = [&](const reports::BeyondSize::Radius& one) {
    if (!(std::abs(std::abs(length_mm) - one.mm) < kAbout * one.mm)) return;
    if (std::find(near->begin(), near->end(), one) == near->end()) near->push_back(one);
  };
  for (const instruments::MeasuringRun& run : problem.runs) {
    if (run.kind != instruments::Kind::kTouch) continue;
    add({run.touches.stylus_radius_mm});
    for (const touch::Feature& feature : run.touches.features) {
      if (feature.is_sphere) add({feature.radius_mm, feature.name});
    }
  }
}

}  // namespace

std::vector<reports::WarningFacts> FindBeyondSize(const Problem& problem, const Result& result) {
  // Castings and assembly are good to a tenth of this; what is beyond makes a machine that could not be handed over. A
  // small machine is not better than some 500 mm.
  constexpr double kShare = 2e-3, kSmallMm = 500.0;
  constexpr double kSurely = 2.0;  // standard uncertainties
  // A set-up is off its stated place by a few sigmas of mounting by hand, never by so many.
  constexpr double kMountings = 10.0;
  std::vector<Parameter> parameters = ListParameters(result.model, true);
  if (parameters.size() != result.estimates.size()) parameters = ListParameters(result.model, false);
  const auto is_angle = [&](size_t i) {
    return machine::IsAngle(result.model.terms[static_cast<size_t>(parameters[i].term)].component);
  };
  const auto is_beyond = [&](size_t i, double limit_mm) {
    const Estimate& estimate = result.estimates[i];
    if (!estimate.identifiable || parameters[i].is_nonlinear) return false;
    return std::abs(estimate.value) - kSurely * estimate.sigma > (is_angle(i) ? kShare : limit_mm);
  };
  std::vector<size_t> candidates;
  for (size_t i = 0; i < parameters.size(); ++i) {
    if (is_beyond(i, kShare * kSmallMm)) candidates.push_back(i);
  }
  reports::BeyondSize beyond;
  if (!candidates.empty()) beyond.size_mm = SizeMm(problem);
  const double limit_mm = kShare * std::max(beyond.size_mm, kSmallMm);
  beyond.limit_um = limit_mm * base::kUmPerMm;
  beyond.limit_urad = kShare * base::kUradPerRad;
  for (const size_t i : candidates) {
    if (!is_beyond(i, limit_mm)) continue;
    const Estimate& estimate = result.estimates[i];
    beyond.errors.push_back({estimate.name, estimate.value / estimate.factor, estimate.unit});
    if (!is_angle(i)) AddNear(problem, estimate.value, &beyond.near);
  }
  for (size_t i = 0; i < result.sessions.size() && i < problem.runs.size(); ++i) {
    if (FirstOfSetup(problem, i) != i) continue;  // a shared set-up once
    const std::vector<instruments::SetupParameter>& setup = problem.runs[i].setup;
    for (size_t k = 0; k < setup.size() && k < result.sessions[i].setup.size(); ++k) {
      const SetupOffset& offset = result.sessions[i].setup[k];
      const double at_least = std::abs(offset.value) - kSurely * offset.sigma;
      if (!setup[k].is_placed) continue;
      if (!std::isfinite(setup[k].prior_sigma) || !(at_least > kMountings * setup[k].prior_sigma)) continue;
      const double per_unit = offset.is_angle ? base::kUradPerRad : base::kUmPerMm;
      beyond.offsets.push_back(
          {offset.name, offset.value * per_unit, offset.is_angle ? "urad" : "um", problem.runs[i].setup_name});
      if (!offset.is_angle) AddNear(problem, offset.value, &beyond.near);
    }
  }
  if (beyond.errors.empty() && beyond.offsets.empty()) return {};
  return {std::move(beyond)};
}

std::vector<reports::WarningFacts> FindQuiet(const Problem& problem, const Result& result,
                                             const std::vector<Eigen::MatrixXd>& residuals_mm) {
  // An inch in place of a mm leaves 0.04 of the scatter, a metre 0.001; who states a sigma on the safe side states
  // twice or three times as much.
  constexpr double kFarBelow = 0.1;
  constexpr double kFewest = 10.0;  // degrees of freedom: chance leaves a tenth of sigma in one of 1e9 such sessions
  reports::Quiet quiet;
  double all_squares = 0.0, all_used = 0.0, unknowns = static_cast<double>(result.estimates.size());
  for (const SetupGroup& group : problem.groups) unknowns += static_cast<double>(group.parameters.size());
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const instruments::MeasuringRun& run = problem.runs[i];
    const double sigma_mm = instruments::SigmaWithRounding(run);
    double squares = 0.0, used = 0.0;
    for (Eigen::Index k = 0; k < residuals_mm[i].size(); ++k) {
      if (!problem.is_used[i][static_cast<size_t>(k)]) continue;
      squares += std::pow(residuals_mm[i].data()[k] / sigma_mm, 2);
      ++used;
    }
    all_squares += squares;
    all_used += used;
    // A session that has hardly more readings than there are unknowns may be fitted exactly.
    const double freedom = used - unknowns;
    if (freedom < kFewest || squares > kFarBelow * kFarBelow * freedom) continue;
    quiet.sessions.push_back(run.session);
    quiet.share = std::max(quiet.share, std::sqrt(squares / freedom));
  }
  const double freedom = all_used - unknowns;
  if (quiet.sessions.empty() && freedom >= kFewest && all_squares <= kFarBelow * kFarBelow * freedom) {
    for (const instruments::MeasuringRun& run : problem.runs) quiet.sessions.push_back(run.session);
    quiet.share = std::sqrt(all_squares / freedom);
  }
  if (quiet.sessions.empty()) return {};
  return {std::move(quiet)};
}

std::vector<reports::WarningFacts> SharedWithHeld(const Problem& problem, const Covariance& covariance,
                                                  const std::vector<MeasuredIn>& held_from) {
  reports::SharedStages shared;
  const auto is_shared = [&](std::string MeasuredIn::*what, const std::string& name) {
    return std::any_of(held_from.begin(), held_from.end(), [&](const MeasuredIn& from) { return from.*what == name; });
  };
  for (const instruments::MeasuringRun& run : problem.runs) {
    if (is_shared(&MeasuredIn::session, run.session)) shared.sessions.push_back(run.session);
  }
  // By how much of its sigma an error moves with the offset's stated one.
  constexpr double kRests = 0.3;  // less: the stages' errors correlate by less than a tenth
  for (size_t i = 0; i < problem.runs.size(); ++i) {
    const instruments::MeasuringRun& run = problem.runs[i];
    if (FirstOfSetup(problem, i) != i || !is_shared(&MeasuredIn::setup, run.setup_name)) continue;
    const Eigen::MatrixXd& with_setup = covariance.with_setup[static_cast<size_t>(problem.group_of_run[i])];
    for (size_t k = 0; k < run.setup.size(); ++k) {
      const instruments::SetupParameter& parameter = run.setup[k];
      if (parameter.is_weak || !std::isfinite(parameter.prior_sigma)) continue;
      const Eigen::ArrayXd moved = with_setup.col(problem.offsets_of_run[i][k]) / parameter.prior_sigma;
      const Eigen::ArrayXd sigma = covariance.errors.diagonal().array().max(0.0).sqrt();
      if ((moved.abs() > kRests * sigma && sigma > 0.0).any())
        shared.offsets.push_back({parameter.name, run.setup_name});
    }
  }
  if (shared.sessions.empty() && shared.offsets.empty()) return {};
  return {std::move(shared)};
}

}  // namespace axiscal::identify
