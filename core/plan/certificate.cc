#include "core/plan/certificate.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/units.h"
#include "core/identify/gauge.h"
#include "core/identify/identify.h"
#include "core/identify/naming.h"
#include "core/plan/planned_run.h"
#include "core/plan/survey.h"

namespace axiscal::plan {
namespace {

constexpr size_t kMostNamed = 3;      // errors that are named where the tool point is least certain
constexpr double kWorthNaming = 0.1;  // of the variance there
constexpr double kNoticedMm = 1e-9;   // of one um or urad along a direction; less is rounding

// What a machine without errors would read, set-ups in their nominal places.
absl::Status FillReadings(const machine::Machine& machine, std::vector<instruments::MeasuringRun>* runs) {
  ASSIGN_OR_RETURN(const identify::Problem problem, identify::MakeProblem(machine, *runs));
  const std::vector<Eigen::MatrixXd> off_mm =
      identify::ResidualsOf(problem, identify::StartingPoint(problem, machine::ErrorModel()));
  for (size_t i = 0; i < runs->size(); ++i) (*runs)[i].measured_mm += off_mm[i];
  return absl::OkStatus();
}

int LeastCertain(const Eigen::MatrixXd& spread) {
  int at = 0;
  for (int k = 1; k < spread.rows() / 3; ++k)
    if (spread.middleRows<3>(3 * k).squaredNorm() > spread.middleRows<3>(3 * at).squaredNorm()) at = k;
  return at;
}

LeftOver LeftOverOf(const machine::Machine& machine, const machine::KnownErrors& errors,
                    const Eigen::MatrixXd& by_number, const predict::BoxPoses& poses) {
  const Eigen::MatrixXd spread = by_number * errors.covariance.root;
  LeftOver out;
  out.chance = predict::ChanceOf(spread);
  const int at = LeastCertain(spread);
  out.positions.assign(poses.PositionsOf(at), poses.PositionsOf(at) + machine.axis_count());
  out.sigma_mm = spread.middleRows<3>(3 * at).rowwise().norm();
  // The variance is the sum over the numbers j of B_j . (B root) root_j.
  std::vector<std::pair<double, std::string>> shares;
  for (Eigen::Index j = 0; j < by_number.cols(); ++j) {
    const machine::ErrorCovariance::Number& number = errors.covariance.of[static_cast<size_t>(j)];
    const Eigen::Vector3d with = spread.middleRows<3>(3 * at) * errors.covariance.root.row(j).transpose();
    const double share = by_number.col(j).segment<3>(3 * at).dot(with);
    if (share > kWorthNaming * out.sigma_mm.squaredNorm())
      shares.emplace_back(
          -share, machine::NameNumber(machine, errors.model, number.term, number.basis, number.is_nonlinear).name);
  }
  std::sort(shares.begin(), shares.end());
  for (size_t i = 0; i < std::min(shares.size(), kMostNamed); ++i) out.by.push_back(shares[i].second);
  return out;
}

double LongestOf(const Eigen::VectorXd& mm) {
  return mm.segment<3>(3 * static_cast<Eigen::Index>(predict::LongestAt(mm))).norm();
}

}  // namespace

absl::StatusOr<Certificate> Certify(const machine::Machine& machine, const machine::ErrorModel& model,
                                    const std::vector<session::Session>& plan, const predict::Workspace& workspace) {
  Certificate out;
  std::vector<instruments::MeasuringRun> runs;
  std::set<std::string> mountings;
  for (const session::Session& session : plan) {
    ASSIGN_OR_RETURN(instruments::MeasuringRun run, PlannedRun(machine, session));
    if (run.has_time) out.seconds += run.time_s.back() - run.time_s.front();
    if (mountings.insert(run.setup_name).second) out.seconds += kMountingSeconds;
    out.readings += run.reading_count();
    runs.push_back(std::move(run));
  }
  out.sessions = static_cast<int>(runs.size());
  RETURN_IF_ERROR(FillReadings(machine, &runs));
  identify::Options options;
  options.model = model;
  options.set_outliers_aside = options.scale_uncertainties = options.judge_correlation = options.profile_intervals =
      false;
  ASSIGN_OR_RETURN(const identify::Fit fit, identify::FitRuns(machine, std::move(runs), options));
  out.errors = fit.result.estimates;
  out.stated = fit.result.stated;

  machine::KnownErrors errors{model, {}};
  ASSIGN_OR_RETURN(errors.covariance, machine::CovarianceOf(fit.result.covariance, machine, model));
  const predict::BoxPoses poses(workspace);
  out.poses = poses.count();
  const predict::OverPoses over(machine, poses, workspace.tip_mm);
  const auto by = [&](std::vector<machine::ErrorCovariance::Number> of) {
    return over.ByNumber({model, {std::move(of), {}}});
  };
  const Eigen::MatrixXd by_number = by(errors.covariance.of);
  out.as_programmed = LeftOverOf(machine, errors, by_number, poses);
  out.set_anew = LeftOverOf(machine, errors, over.Left(by_number), poses);

  const std::vector<identify::Parameter> parameters = identify::ListParameters(model, false);
  std::vector<machine::ErrorCovariance::Number> amplitudes;
  std::vector<identify::Estimate> names;
  for (const identify::Parameter& parameter : parameters) {
    amplitudes.push_back({parameter.term, parameter.basis, false});
    names.push_back(identify::NamedEstimate(machine, model, parameter));
  }
  const Eigen::MatrixXd by_amplitude = by(amplitudes);
  const information::NullSpace space = identify::AtNominal(fit.problem, model).null_space;
  for (Eigen::Index row = 0; row < space.directions.rows(); ++row) {
    const Eigen::VectorXd direction = space.directions.row(row).transpose();
    Eigen::Index first = 0;
    while (direction[first] == 0.0) ++first;
    const identify::Estimate& of = names[static_cast<size_t>(first)];
    const Eigen::VectorXd moved = by_amplitude * (direction * (of.factor / direction[first]));
    Unseen unseen{identify::CombinationName(names, direction), of.name, of.unit, LongestOf(moved),
                  LongestOf(over.Left(moved))};
    if (unseen.set_anew_mm < kNoticedMm) unseen.set_anew_mm = 0.0;
    if (unseen.as_programmed_mm < kNoticedMm) unseen.as_programmed_mm = 0.0;
    out.unseen.push_back(std::move(unseen));
  }
  return out;
}

}  // namespace axiscal::plan
