#include "core/toolsetter/reference.h"

#include <Eigen/Cholesky>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/base/units.h"
#include "core/information/choice.h"
#include "core/information/coverage_factor.h"

namespace axiscal::toolsetter {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Directions that move all readouts less than this share of what their parameters alone would are unseen.
constexpr double kSeen = 1e-7;
// Angles that run to the limit of a beam are not told by the rods.
constexpr double kLimitRad = kMaxBeamTiltDeg * (1.0 - 1e-9) * base::kRadPerDeg;

struct Fit {
  std::vector<Trigger> triggers;
  Eigen::Vector3d at;                   // Z, yaw, pitch
  MatrixXd covariance;                  // of the free parameters
  std::vector<Eigen::VectorXd> unseen;  // in the free parameters
  double chi2 = 0.0;
  int rank = 0;
};

class Fitter {
 public:
  Fitter(const RodSession& session, const ReferenceOptions& options) : session_(session) {
    for (const MeasuredRod& rod : session.rods) {
      if (!rod.readouts_mm.empty()) rods_.push_back(&rod);
    }
    free_ = {kReferenceZ};
    const double sigma[] = {session.beam_sigma.yaw_rad, session.beam_sigma.pitch_rad};
    const bool asked[] = {options.fit_yaw, options.fit_pitch};
    for (int i = 0; i < 2; ++i) {
      if (!asked[i] && sigma[i] == 0.0) continue;
      free_.push_back(kReferenceYaw + i);
      if (!asked[i]) priors_.push_back({static_cast<int>(free_.size()) - 1, sigma[i]});
    }
  }

  // Of the free parameters, without a component between rods.
  absl::StatusOr<information::Information> InformationAt(const Eigen::Vector3d& at) const {
    Fit fit;
    fit.at = at;
    ASSIGN_OR_RETURN(fit.triggers, Triggers(at));
    return information::OfRows(Whitened(fit, 0.0).first);
  }

  const std::vector<const MeasuredRod*>& rods() const { return rods_; }
  const std::vector<int>& free() const { return free_; }
  int rows() const { return static_cast<int>(rods_.size() + priors_.size()); }

  // Columns of the free parameters that the readouts determine although every rod (body) is off by an amount of its
  // own; and how many rows are left then.
  struct WithinRods {
    std::vector<bool> is_determined;
    int degrees_of_freedom = 0;
  };
  WithinRods Within(const Fit& fit) const {
    std::vector<std::string> bodies;
    for (const MeasuredRod* rod : rods_) {
      if (std::find(bodies.begin(), bodies.end(), rod->body()) == bodies.end()) bodies.push_back(rod->body());
    }
    const Eigen::Index free = static_cast<Eigen::Index>(free_.size());
    MatrixXd jacobian = MatrixXd::Zero(rows(), free + static_cast<Eigen::Index>(bodies.size()));
    const Eigen::LLT<MatrixXd> root(Covariance(fit.triggers, 0.0));
    MatrixXd offsets =
        MatrixXd::Zero(static_cast<Eigen::Index>(rods_.size()), static_cast<Eigen::Index>(bodies.size()));
    for (size_t i = 0; i < rods_.size(); ++i)
      offsets(i, std::find(bodies.begin(), bodies.end(), rods_[i]->body()) - bodies.begin()) = 1.0;
    jacobian.leftCols(free) = Whitened(fit, 0.0).first;
    jacobian.topRightCorner(offsets.rows(), offsets.cols()) = root.matrixL().solve(offsets);
    for (Eigen::Index c = 0; c < jacobian.cols(); ++c) {
      const double norm = jacobian.col(c).norm();
      if (norm > 0.0) jacobian.col(c) /= norm;
    }
    const Eigen::JacobiSVD<MatrixXd> svd(jacobian, Eigen::ComputeThinU | Eigen::ComputeFullV);
    WithinRods within;
    within.is_determined.assign(free_.size(), true);
    int rank = 0;
    for (Eigen::Index k = 0; k < jacobian.cols(); ++k) {
      const double value = k < svd.singularValues().size() ? svd.singularValues()[k] : 0.0;
      rank += value > kSeen ? 1 : 0;
      for (Eigen::Index c = 0; c < free && !(value > kSeen); ++c)
        within.is_determined[c] = within.is_determined[c] && std::abs(svd.matrixV()(c, k)) < 1e-6;
    }
    within.degrees_of_freedom = rows() - rank;
    return within;
  }

  // Whether it was stated how well the length of every measured rod is known.
  bool AreLengthsStated() const {
    return std::all_of(rods_.begin(), rods_.end(), [](const MeasuredRod* rod) { return rod->sigma.length_mm > 0.0; });
  }

  // Least squares from `start` with the given component between rods.
  absl::StatusOr<Fit> Solve(const Eigen::Vector3d& start, double between_mm) const {
    Fit fit;
    fit.at = start;
    for (int iteration = 0; iteration < 50; ++iteration) {
      ASSIGN_OR_RETURN(fit.triggers, Triggers(fit.at));
      const auto [jacobian, residual] = Whitened(fit, between_mm);
      fit.chi2 = residual.squaredNorm();
      const VectorXd step = Step(jacobian, residual, &fit);
      double largest = 0.0;
      for (size_t i = 0; i < free_.size(); ++i) {
        // An angle may be far off while its derivative has a kink at A = 0: a degree at a time.
        constexpr double kLargestRad = base::kRadPerDeg;
        const double bounded = free_[i] == kReferenceZ ? step[i] : std::clamp(step[i], -kLargestRad, kLargestRad);
        fit.at[free_[i]] += bounded;
        if (free_[i] != kReferenceZ) fit.at[free_[i]] = std::clamp(fit.at[free_[i]], -kLimitRad, kLimitRad);
        largest = std::max(largest, std::abs(bounded));
      }
      if (largest < 1e-12) break;
    }
    return fit;
  }

  // The rod's own answer.
  double AnswerMm(size_t rod, const Fit& fit) const {
    return MeanMm(rod) + session_.spindle_at_home_mm - rods_[rod]->rod.length_mm - fit.triggers[rod].height_mm;
  }
  double MeanMm(size_t rod) const {
    double sum = 0.0;
    for (const double readout_mm : rods_[rod]->readouts_mm) sum += readout_mm;
    return sum / static_cast<double>(rods_[rod]->readouts_mm.size());
  }

  MatrixXd Covariance(const std::vector<Trigger>& triggers, double between_mm) const {
    const size_t count = rods_.size();
    MatrixXd covariance(count, count);
    for (size_t i = 0; i < count; ++i) {
      for (size_t j = 0; j < count; ++j) {
        const auto &gi = triggers[i].by_input, &gj = triggers[j].by_input;
        double sum = gi[kBeamRadius] * gj[kBeamRadius] * std::pow(session_.beam_sigma.radius_mm, 2);
        if (rods_[i]->body() == rods_[j]->body()) {
          const RodSigma& sigma = rods_[i]->sigma;
          sum += gi[kRodRadius] * gj[kRodRadius] * std::pow(sigma.radius_mm, 2) +
                 gi[kFillet] * gj[kFillet] * std::pow(sigma.fillet_mm, 2) +
                 gi[kFace] * gj[kFace] * std::pow(sigma.face_rad, 2) +
                 gi[kAzimuth] * gj[kAzimuth] * std::pow(sigma.azimuth_rad, 2) + std::pow(sigma.length_mm, 2) +
                 std::pow(between_mm, 2);
        }
        if (i == j) sum += std::pow(session_.sigma_mm, 2) / static_cast<double>(rods_[i]->readouts_mm.size());
        covariance(i, j) = sum;
      }
    }
    return covariance;
  }

 private:
  struct Prior {
    int column = 0;  // in free_
    double sigma_rad = 0.0;
  };

  absl::StatusOr<std::vector<Trigger>> Triggers(const Eigen::Vector3d& at) const {
    Beam beam = session_.beam;
    beam.yaw_rad = at[kReferenceYaw];
    beam.pitch_rad = at[kReferencePitch];
    std::vector<Trigger> triggers;
    for (const MeasuredRod* rod : rods_) {
      auto trigger = TriggerOf(rod->rod, beam);
      if (!trigger.ok()) return base::Within(rod->name, trigger.status());
      triggers.push_back(*trigger);
    }
    return triggers;
  }

  // Of unit variance: measured - predicted per rod, then the priors; d(predicted) per free parameter.
  std::pair<MatrixXd, VectorXd> Whitened(const Fit& fit, double between_mm) const {
    const size_t count = rods_.size();
    MatrixXd jacobian = MatrixXd::Zero(rows(), free_.size());
    VectorXd residual = VectorXd::Zero(rows());
    for (size_t i = 0; i < count; ++i) {
      residual[i] = AnswerMm(i, fit) - fit.at[kReferenceZ];
      const double by[] = {1.0, fit.triggers[i].by_input[kYaw], fit.triggers[i].by_input[kPitch]};
      for (size_t c = 0; c < free_.size(); ++c) jacobian(i, c) = by[free_[c]];
    }
    const Eigen::LLT<MatrixXd> root(Covariance(fit.triggers, between_mm));
    const MatrixXd white = root.matrixL().solve(jacobian.topRows(count));
    const VectorXd white_residual = root.matrixL().solve(residual.head(count));
    jacobian.topRows(count) = white;
    residual.head(count) = white_residual;
    const double stated[] = {0.0, session_.beam.yaw_rad, session_.beam.pitch_rad};
    for (size_t i = 0; i < priors_.size(); ++i) {
      jacobian(count + i, priors_[i].column) = 1.0 / priors_[i].sigma_rad;
      const int parameter = free_[priors_[i].column];
      residual[count + i] = (stated[parameter] - fit.at[parameter]) / priors_[i].sigma_rad;
    }
    return {jacobian, residual};
  }

  // The least step, none along unseen directions; also covariance, rank and those directions.
  VectorXd Step(const MatrixXd& jacobian, const VectorXd& residual, Fit* fit) const {
    // An angle that no rod feels (yaw, when all faces are square) has a column of rounding at most.
    constexpr double kFeltMmPerRad = 1e-9;
    VectorXd scale(jacobian.cols());
    for (Eigen::Index c = 0; c < jacobian.cols(); ++c) {
      const double norm = jacobian.col(c).norm();
      scale[c] = norm > kFeltMmPerRad * jacobian.col(0).norm() ? 1.0 / norm : 0.0;
    }
    const Eigen::JacobiSVD<MatrixXd> svd(jacobian * scale.asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeFullV);
    fit->unseen.clear();
    fit->rank = 0;
    fit->covariance = MatrixXd::Zero(jacobian.cols(), jacobian.cols());
    VectorXd step = VectorXd::Zero(jacobian.cols());
    for (Eigen::Index k = 0; k < jacobian.cols(); ++k) {
      VectorXd direction = svd.matrixV().col(k);
      const double value = k < svd.singularValues().size() ? svd.singularValues()[k] : 0.0;
      if (!(value > kSeen)) {
        for (Eigen::Index c = 0; c < direction.size(); ++c) direction[c] *= scale[c] > 0.0 ? scale[c] : 1.0;
        fit->unseen.push_back(direction.normalized());
        continue;
      }
      ++fit->rank;
      direction = scale.asDiagonal() * direction;
      step += direction * (svd.matrixU().col(k).dot(residual) / value);
      fit->covariance += direction * direction.transpose() / (value * value);
    }
    return step;
  }

  const RodSession& session_;
  std::vector<const MeasuredRod*> rods_;
  std::vector<int> free_;  // ReferenceParameter
  std::vector<Prior> priors_;
};

// Pitch has a local minimum on either side of a square face's kink.
absl::StatusOr<Fit> BestFit(const Fitter& fitter, const RodSession& session, const ReferenceOptions& options) {
  std::vector<Eigen::Vector3d> starts = {{0.0, session.beam.yaw_rad, session.beam.pitch_rad}};
  if (options.fit_pitch || options.fit_yaw) {
    constexpr double kOtherRad = 0.3 * base::kRadPerDeg;
    const double yaw = session.beam.yaw_rad;
    for (const double pitch : {kOtherRad, -kOtherRad}) {
      if (options.fit_pitch) starts.push_back({0.0, yaw, pitch});
      if (options.fit_pitch && options.fit_yaw) starts.push_back({0.0, -yaw, pitch});
    }
  }
  absl::StatusOr<Fit> best;
  for (const Eigen::Vector3d& start : starts) {
    absl::StatusOr<Fit> fit = fitter.Solve(start, 0.0);
    if (!best.ok() || (fit.ok() && fit->chi2 < best->chi2 * (1.0 - 1e-9) - 1e-12)) best = std::move(fit);
  }
  return best;
}

// The component between rods that makes chi-square what it should be; 0 where it is not too large without. Nothing when
// no such component explains it: the readouts of one rod scatter more than is stated.
absl::StatusOr<std::optional<double>> BetweenRods(const Fitter& fitter, const Fit& fit, int degrees_of_freedom) {
  if (degrees_of_freedom <= 0 || fit.chi2 <= degrees_of_freedom) return std::optional(0.0);
  const auto chi2 = [&](double between_mm) -> absl::StatusOr<double> {
    ASSIGN_OR_RETURN(const Fit wider, fitter.Solve(fit.at, between_mm));
    return wider.chi2;
  };
  constexpr double kLargestMm = 1.0;
  ASSIGN_OR_RETURN(const double least, chi2(kLargestMm));
  if (least > degrees_of_freedom) return std::optional<double>();
  double low_mm = 0.0, high_mm = kLargestMm;
  while (high_mm - low_mm > 1e-8 + 1e-4 * low_mm) {
    const double middle_mm = 0.5 * (low_mm + high_mm);
    ASSIGN_OR_RETURN(const double now, chi2(middle_mm));
    (now > degrees_of_freedom ? low_mm : high_mm) = middle_mm;
  }
  return std::optional(high_mm);
}

// A rod at twelve angles of the spindle, one readout each, in the fitted beam. Without the rod's own errors, which all
// angles share. INVALID_ARGUMENT where it does not shade the beam.
absl::StatusOr<RodSession> Turned(const RodSession& session, const MeasuredRod& rod, const Fit& fit) {
  RodSession turned = session;
  turned.rods.clear();
  turned.beam.yaw_rad = fit.at[kReferenceYaw];
  turned.beam.pitch_rad = fit.at[kReferencePitch];
  for (int i = 0; i < 12; ++i) {
    MeasuredRod position = rod;
    position.rod.holder_rad = 30.0 * i * base::kRadPerDeg;
    position.name = absl::StrCat(rod.body(), "@", 30 * i);
    position.sigma = {};
    ASSIGN_OR_RETURN(const Trigger trigger, TriggerOf(position.rod, turned.beam));
    position.readouts_mm = {rod.rod.length_mm + trigger.height_mm - session.spindle_at_home_mm};
    turned.rods.push_back(std::move(position));
  }
  return turned;
}

// Of the tilted rods the one that tells most when it is turned, as tests are chosen everywhere (information/choice.h).
std::optional<RodProposal> Propose(const RodSession& session, const Fit& fit) {
  constexpr double kTiltedRad = 0.2 * base::kRadPerDeg;
  std::vector<RodSession> turned;
  std::vector<information::TestInformation> tests;
  std::set<std::string> bodies;
  for (const MeasuredRod& rod : session.rods) {
    if (0.5 * std::numbers::pi - rod.rod.face_rad < kTiltedRad || !bodies.insert(rod.body()).second) continue;
    absl::StatusOr<RodSession> one = Turned(session, rod, fit);
    if (!one.ok()) continue;
    const auto tells = InformationOf(*one);
    if (!tells.ok()) continue;
    tests.push_back({*tells, *tells});
    turned.push_back(*std::move(one));
  }
  const information::Choice choice =
      information::ChooseTests(tests, {kReferenceZ, kReferenceYaw, kReferencePitch});
  if (choice.tests.size() != 1 || choice.told.determined_count < kReferenceParameters) return std::nullopt;
  const RodSession& chosen = turned[choice.tests[0]];
  // Stated as the evaluation of those readouts will state it.
  const auto expected =
      Fitter(chosen, {true, true}).Solve({0.0, chosen.beam.yaw_rad, chosen.beam.pitch_rad}, 0.0);
  if (!expected.ok() || expected->rank < kReferenceParameters) return std::nullopt;
  RodProposal proposal;
  proposal.rod = chosen.rods[0].body();
  for (const MeasuredRod& rod : chosen.rods) proposal.holder_rad.push_back(rod.rod.holder_rad);
  for (int i = 0; i < kReferenceParameters; ++i) proposal.sigma[i] = std::sqrt(expected->covariance(i, i));
  return proposal;
}

absl::Status CheckMeasured(const RodSession& session, const Fitter& fitter) {
  if (!fitter.rods().empty()) return absl::OkStatus();
  return absl::InvalidArgumentError("session " + session.session + ": no rod has a readout, expected at least one");
}

// A chip moves a readout by micrometres; another rod's, or one in another unit, stands elsewhere.
absl::Status CheckReadouts(const std::string& session, const MeasuredRod& rod) {
  constexpr double kApartMm = 0.1;
  const auto [least, most] = std::minmax_element(rod.readouts_mm.begin(), rod.readouts_mm.end());
  if (*most - *least <= kApartMm) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("session %s: %s: readouts from %.4f to %.4f mm, expected within %g mm of each other: is one of "
                      "another rod, or in "
                      "another unit?",
                      session, rod.name, *least, *most, kApartMm));
}

double MedianOf(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

// Rods that no beam and no stated error reconciles.
absl::Status CheckRods(const RodSession& session, const Fitter& fitter, const Fit& fit) {
  constexpr double kApartMm = 2.0;  // a beam that is 20 deg out of line moves a rod's trigger by less
  const size_t count = fitter.rods().size();
  size_t worst = 0;
  double worst_mm = 0.0;
  for (size_t i = 0; count > 1 && i < count; ++i) {
    std::vector<double> others_mm;
    for (size_t j = 0; j < count; ++j) {
      if (j != i) others_mm.push_back(fitter.AnswerMm(j, fit));
    }
    const double off_mm = std::abs(fitter.AnswerMm(i, fit) - MedianOf(others_mm));
    if (off_mm > worst_mm) worst_mm = off_mm, worst = i;
  }
  if (worst_mm <= kApartMm) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "session %s: %s puts the reference point %.3f mm off where the other rods do, expected rods that agree to %g mm: "
      "is its length of %g mm right, are its readouts of another rod or in another unit?",
      session.session, fitter.rods()[worst]->name, worst_mm, kApartMm, fitter.rods()[worst]->rod.length_mm));
}

}  // namespace

const char* ParameterName(ReferenceParameter parameter) {
  constexpr const char* kNames[] = {"Z", "yaw", "pitch"};
  return kNames[parameter];
}

absl::StatusOr<information::Information> InformationOf(const RodSession& session) {
  RETURN_IF_ERROR(Validate(session.beam));
  const Fitter fitter(session, {true, true});
  RETURN_IF_ERROR(CheckMeasured(session, fitter));
  return fitter.InformationAt({0.0, session.beam.yaw_rad, session.beam.pitch_rad});
}

absl::StatusOr<Reference> FitReference(const RodSession& session, const ReferenceOptions& options) {
  RETURN_IF_ERROR(Validate(session.beam));
  const Fitter fitter(session, options);
  RETURN_IF_ERROR(CheckMeasured(session, fitter));
  for (const MeasuredRod* const rod : fitter.rods()) RETURN_IF_ERROR(CheckReadouts(session.session, *rod));
  ASSIGN_OR_RETURN(Fit fit, BestFit(fitter, session, options));
  RETURN_IF_ERROR(CheckRods(session, fitter, fit));
  Reference out;
  out.chi2 = fit.chi2;
  out.degrees_of_freedom = fitter.rows() - fit.rank;
  ASSIGN_OR_RETURN(const std::optional<double> between_mm, BetweenRods(fitter, fit, out.degrees_of_freedom));
  out.between_rods_mm = between_mm.value_or(0.0);
  if (out.between_rods_mm > 0.0) {
    ASSIGN_OR_RETURN(fit, fitter.Solve(fit.at, out.between_rods_mm));
  }
  if (!between_mm) fit.covariance *= out.chi2 / out.degrees_of_freedom;
  const Eigen::MatrixXd alone = fitter.Covariance(fit.triggers, 0.0);
  for (size_t i = 0; i < fitter.rods().size(); ++i) {
    const std::vector<double>& readouts_mm = fitter.rods()[i]->readouts_mm;
    const auto [least, most] = std::minmax_element(readouts_mm.begin(), readouts_mm.end());
    RodAnswer answer{fitter.rods()[i]->name,
                     fit.triggers[i],
                     static_cast<int>(readouts_mm.size()),
                     fitter.MeanMm(i),
                     *most - *least,
                     fitter.AnswerMm(i, fit),
                     0.0};
    double variance = alone(i, i);
    if (!options.fit_yaw) variance += std::pow(answer.trigger.by_input[kYaw] * session.beam_sigma.yaw_rad, 2);
    if (!options.fit_pitch) variance += std::pow(answer.trigger.by_input[kPitch] * session.beam_sigma.pitch_rad, 2);
    answer.sigma_mm = std::sqrt(variance);
    out.rods.push_back(std::move(answer));
  }
  const auto [least, most] = std::minmax_element(
      out.rods.begin(), out.rods.end(), [](const auto& a, const auto& b) { return a.reference_mm < b.reference_mm; });
  out.range_mm = most->reference_mm - least->reference_mm;

  for (int i = 0; i < kReferenceParameters; ++i) out.parameters[i].estimate = fit.at[i];
  const std::vector<int>& free = fitter.free();
  for (const Eigen::VectorXd& direction : fit.unseen) {
    Eigen::Vector3d whole = Eigen::Vector3d::Zero();
    for (size_t c = 0; c < free.size(); ++c) whole[free[c]] = direction[c];
    out.unseen.push_back(whole);
  }
  for (size_t c = 0; c < free.size(); ++c) {
    Fitted& parameter = out.parameters[free[c]];
    parameter.is_free = true;
    parameter.sigma = std::sqrt(fit.covariance(c, c));
    parameter.is_identifiable = free[c] == kReferenceZ || std::abs(fit.at[free[c]]) < kLimitRad;
    for (const Eigen::VectorXd& direction : fit.unseen) parameter.is_identifiable &= std::abs(direction[c]) < 1e-6;
    for (size_t d = 0; d < free.size(); ++d) out.covariance(free[c], free[d]) = fit.covariance(c, d);
  }
  const Fitter::WithinRods within = fitter.Within(fit);
  out.degrees_between_rods = std::max(0, out.degrees_of_freedom - within.degrees_of_freedom);
  const bool are_judged = out.degrees_between_rods > 0 || fitter.AreLengthsStated();
  for (size_t c = 0; c < free.size(); ++c) out.has_interval[free[c]] = are_judged || within.is_determined[c];
  const bool is_estimated = out.between_rods_mm > 0.0 || !between_mm;
  out.coverage_factor = information::CoverageFactor(
      is_estimated, out.between_rods_mm > 0.0 && out.degrees_between_rods > 0 ? out.degrees_between_rods
                                                                               : out.degrees_of_freedom);
  for (int i = 0; i < kReferenceParameters; ++i) {
    if (out.parameters[i].is_identifiable) continue;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    out.parameters[i].estimate = out.parameters[i].sigma = kNone;
    out.covariance.row(i).setConstant(kNone);
    out.covariance.col(i).setConstant(kNone);
  }
  if (options.fit_yaw || options.fit_pitch) out.next = Propose(session, fit);
  return out;
}

}  // namespace axiscal::toolsetter
