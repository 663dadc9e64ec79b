#include "core/toolsetter/wear.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/base/units.h"
#include "core/information/coverage_factor.h"

namespace axiscal::toolsetter {
namespace {

using Eigen::VectorXd;

constexpr double kSearchStep = base::kRadPerDeg;
constexpr int kSearchSteps = 360;

// Phase, then the length of each insert.
using Unknowns = VectorXd;

class Fitter {
 public:
  Fitter(const CurveSession& session, const InsertHeights& heights)
      : session_(session),
        heights_(heights),
        variance_(session.starts_rad.size(), session.sigma_mm * session.sigma_mm) {}

  int readings() const { return static_cast<int>(session_.starts_rad.size()); }
  int inserts() const { return session_.cutter.inserts; }

  std::vector<CurvePoint> Predict(const Unknowns& at, double shift_rad = 0.0) const {
    std::vector<double> starts;
    for (const double start_rad : session_.starts_rad) starts.push_back(start_rad + at[0] + shift_rad);
    return CurveOf(at).At(starts);
  }
  LengthCurve CurveOf(const Unknowns& at) const {
    const double longest_mm = at.tail(inserts()).maxCoeff();
    std::vector<double> wear_mm;
    for (int k = 0; k < inserts(); ++k) wear_mm.push_back(longest_mm - at[1 + k]);
    return LengthCurve(heights_, session_.cutter, session_.run, std::move(wear_mm));
  }
  // Measured - predicted.
  VectorXd Residual(const Unknowns& at, const std::vector<CurvePoint>& points) const {
    VectorXd residual(readings());
    const double longest_mm = at.tail(inserts()).maxCoeff();
    for (int i = 0; i < readings(); ++i) residual[i] = session_.lengths_mm[i] - longest_mm - points[i].height_mm;
    return residual;
  }
  VectorXd Whitened(VectorXd residual) const {
    for (int i = 0; i < readings(); ++i) residual[i] /= std::sqrt(variance_[i]);
    return residual;
  }
  double Chi2(const Unknowns& at) const { return Whitened(Residual(at, Predict(at))).squaredNorm(); }

  // d(reading) per unknown, unit variance. The descent starts h above the longest insert, which takes it along.
  Eigen::MatrixXd Jacobian(const Unknowns& at, const std::vector<CurvePoint>& points) const {
    Eigen::Index longest = 0;
    at.tail(inserts()).maxCoeff(&longest);
    Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(readings(), 1 + inserts());
    for (int i = 0; i < readings(); ++i) {
      const double weight = 1.0 / std::sqrt(variance_[i]);
      jacobian(i, 0) = weight * points[i].by_start;
      jacobian(i, 1 + points[i].insert) -= weight * points[i].by_wear;
      jacobian(i, 1 + longest) += weight * (1.0 + points[i].by_wear);
    }
    return jacobian;
  }

  // Levenberg and Marquardt; the curve has jumps, so that only steps that help are taken.
  double Refine(Unknowns* at) const {
    std::vector<CurvePoint> points = Predict(*at);
    VectorXd residual = Whitened(Residual(*at, points));
    double damping = 1e-4;
    for (int iteration = 0; iteration < 40 && damping < 1e6; ++iteration) {
      const Eigen::MatrixXd jacobian = Jacobian(*at, points);
      Eigen::MatrixXd normal = jacobian.transpose() * jacobian;
      for (Eigen::Index c = 0; c < normal.cols(); ++c) normal(c, c) = normal(c, c) * (1.0 + damping) + 1e-12;
      const Unknowns next = *at + normal.ldlt().solve(jacobian.transpose() * residual);
      std::vector<CurvePoint> next_points = Predict(next);
      VectorXd next_residual = Whitened(Residual(next, next_points));
      const double gain = residual.squaredNorm() - next_residual.squaredNorm();
      if (!(gain > 0.0)) {
        damping *= 10.0;
        continue;
      }
      *at = next;
      points = std::move(next_points);
      residual = std::move(next_residual);
      damping *= 0.1;
      if (gain < 1e-9 * (1.0 + residual.squaredNorm())) break;
    }
    return residual.squaredNorm();
  }

  // Readings where the start's own uncertainty moves the prediction weigh less.
  void Weigh(const Unknowns& at) {
    const double shift = session_.start_sigma_rad;
    const std::vector<CurvePoint> here = Predict(at), earlier = Predict(at, -shift), later = Predict(at, shift);
    for (int i = 0; i < readings(); ++i) {
      const double before_mm = here[i].height_mm - earlier[i].height_mm,
                   behind_mm = later[i].height_mm - here[i].height_mm;
      variance_[i] = session_.sigma_mm * session_.sigma_mm + 0.5 * (before_mm * before_mm + behind_mm * behind_mm);
    }
  }

  // The best phase of a set of wears, and the length that goes with it.
  double Scan(const std::vector<double>& wear_mm, Unknowns* best) const {
    static const std::vector<double>& starts = *[] {
      auto* all = new std::vector<double>;
      for (int i = 0; i < kSearchSteps; ++i) all->push_back(i * kSearchStep);
      return all;
    }();
    const std::vector<CurvePoint> curve = LengthCurve(heights_, session_.cutter, session_.run, wear_mm).At(starts);
    // Even spacing: a turn by one insert only renames them.
    const int reach = session_.cutter.insert_angles_rad.empty() ? kSearchSteps / (2 * inserts()) : kSearchSteps / 2;
    double least = std::numeric_limits<double>::infinity();
    for (int shift = -reach; shift < std::max(reach, 1 - reach); ++shift) {
      double sum = 0.0, squares = 0.0;
      for (int i = 0; i < readings(); ++i) {
        const long place = std::lround(session_.starts_rad[i] / kSearchStep) + shift;
        const double miss_mm = session_.lengths_mm[i] - session_.lengths_mm[0] -
                               curve[((place % kSearchSteps) + kSearchSteps) % kSearchSteps].height_mm;
        sum += miss_mm;
        squares += miss_mm * miss_mm;
      }
      const double scatter = squares - sum * sum / readings();
      if (!(scatter < least)) continue;
      least = scatter;
      best->resize(1 + inserts());
      (*best)[0] = shift * kSearchStep;
      for (int k = 0; k < inserts(); ++k) (*best)[1 + k] = session_.lengths_mm[0] + sum / readings() - wear_mm[k];
    }
    return least;
  }

  // Wears on a grid, one insert at a time, from several beginnings; each with its best phase.
  std::vector<Unknowns> Search() const {
    const double f_mm = session_.run.feed_per_insert_mm(session_.cutter);
    constexpr int kLevels = 24;
    const double step_mm = 1.25 * f_mm / kLevels;
    std::vector<Unknowns> found;
    for (int beginning = 0; beginning <= (inserts() > 1 ? inserts() : 0); ++beginning) {
      std::vector<double> wear_mm(inserts(), beginning == 0 ? 0.0 : 0.4 * f_mm);
      if (beginning > 0) wear_mm[beginning - 1] = 0.0;
      Unknowns best;
      double least = Scan(wear_mm, &best);
      bool improves = inserts() > 1;
      for (int pass = 0; improves && pass < 4; ++pass) {
        improves = false;
        for (int k = 0; k < inserts(); ++k) {
          for (int level = 0; level <= kLevels; ++level) {
            std::vector<double> tried = wear_mm;
            tried[k] = level * step_mm;
            const double shortest = *std::min_element(tried.begin(), tried.end());
            for (double& wear : tried) wear -= shortest;
            Unknowns at;
            const double scatter = Scan(tried, &at);
            if (!(scatter < 0.999 * least)) continue;
            least = scatter;
            best = at;
            wear_mm = tried;
            improves = true;
          }
        }
      }
      found.push_back(best);
    }
    return found;
  }

 private:
  const CurveSession& session_;
  const InsertHeights& heights_;
  std::vector<double> variance_;  // of each reading, mm2
};

// The best of `starts`, refined; then from around it: a jump of the curve may stand between it and the best phase.
double RefineAll(const Fitter& fitter, const std::vector<Unknowns>& starts, Unknowns* best) {
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](Unknowns at) {
    const double chi2 = fitter.Refine(&at);
    if (chi2 < least) least = chi2, *best = at;
  };
  for (const Unknowns& start : starts) take(start);
  const Unknowns middle = *best;
  for (const double shift_deg : {-0.25, 0.25, -1.0, 1.0}) {
    Unknowns at = middle;
    at[0] += shift_deg * base::kRadPerDeg;
    take(at);
  }
  return least;
}

// Covariance of phase and lengths about the best fit. Away from its jumps the curve is nearly a straight line, along
// which phase and lengths go together; what holds them are the jumps, of which no derivative knows. So the likelihood
// (chi-square over `grown`) is sampled by a Metropolis chain, one unknown at a time; wear beyond what can be seen has
// no weight. Unknowns that are not `seen` stay.
Eigen::MatrixXd Covariance(const Fitter& fitter, const CurveSession& session, const Unknowns& best, double chi2,
                           double grown, const std::vector<bool>& seen) {
  constexpr int kTuning = 700, kSteps = 3500;
  constexpr double kBeyondSeen = 1.25;
  const int count = static_cast<int>(best.size()), inserts = fitter.inserts();
  const double reach_rad = 0.5 * kTurn / inserts;
  const double lowest_mm = kBeyondSeen * session.run.feed_per_turn_mm();
  VectorXd scale = VectorXd::Constant(count, session.sigma_mm);
  scale[0] = 2.0 * base::kRadPerDeg;
  std::mt19937 random(1);  // the same readings give the same report
  const auto uniform = [&random] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
  Unknowns at = best;
  double now = chi2;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count);
  int used = 0;
  for (int step = 0; step < kSteps; ++step) {
    const int which = step % count;
    if (seen[which]) {
      Unknowns next = at;
      next[which] += scale[which] * (uniform() + uniform() + uniform() - 1.5) * 2.0;  // about normal
      const bool is_inside = std::abs(next[0] - best[0]) < reach_rad &&
                             next.tail(inserts).maxCoeff() - next.tail(inserts).minCoeff() < lowest_mm;
      const double then = is_inside ? fitter.Chi2(next) : std::numeric_limits<double>::infinity();
      const bool is_taken = std::log(uniform()) < -0.5 * (then - now) / grown;
      if (step < kTuning) scale[which] *= is_taken ? 1.08 : 0.95;  // towards two in five
      if (is_taken) at = next, now = then;
    }
    if (step < kTuning) continue;
    const VectorXd off = at - best;
    sum += off * off.transpose();
    ++used;
  }
  return sum / used;
}

// The least wear above which insert `k` changes nothing that the readings would show (chi-square + 3.84).
double BoundMm(const Fitter& fitter, const Unknowns& best, int k, double chi2, double scale, double f_mm) {
  const double longest_mm = best.tail(fitter.inserts()).maxCoeff();
  constexpr int kLevels = 100;
  constexpr double kRise = 3.84;
  double bound_mm = 0.0;
  for (int level = 0; level <= kLevels; ++level) {
    Unknowns at = best;
    const double wear_mm = 4.0 * f_mm * fitter.inserts() * level / kLevels;
    at[1 + k] = longest_mm - wear_mm;
    if (fitter.Chi2(at) > chi2 + kRise * scale) bound_mm = wear_mm;
  }
  return bound_mm;
}

}  // namespace

absl::StatusOr<WearReport> FitWear(const CurveSession& session) {
  ASSIGN_OR_RETURN(const InsertHeights heights, HeightsOf(session.cutter, session.run));
  RETURN_IF_ERROR(CheckInsertsApart(heights, session.cutter, session.run, session.sigma_mm));
  const std::vector<double> unseen_from_mm = UnseenFromMm(heights, session.cutter, session.run);
  Fitter fitter(session, heights);
  const int inserts = fitter.inserts();
  const std::vector<Unknowns> found = fitter.Search();
  Unknowns best;
  double chi2 = RefineAll(fitter, found, &best);
  for (int round = 0; round < 3; ++round) {
    fitter.Weigh(best);
    chi2 = RefineAll(fitter, {best}, &best);
  }

  WearReport report;
  const std::vector<CurvePoint> points = fitter.Predict(best);
  const VectorXd residual = fitter.Residual(best, points);
  report.inserts.resize(inserts);
  for (const CurvePoint& point : points) ++report.inserts[point.insert].readings;
  Eigen::MatrixXd jacobian = fitter.Jacobian(best, points);
  VectorXd scale(jacobian.cols());
  for (Eigen::Index c = 0; c < jacobian.cols(); ++c)
    scale[c] = jacobian.col(c).norm() > 0.0 ? 1.0 / jacobian.col(c).norm() : 0.0;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian * scale.asDiagonal(), Eigen::ComputeThinU | Eigen::ComputeFullV);
  std::vector<bool> is_seen(jacobian.cols(), true);
  int rank = 0;
  for (Eigen::Index k = 0; k < jacobian.cols(); ++k) {
    const VectorXd direction = svd.matrixV().col(k);
    const double value = k < svd.singularValues().size() ? svd.singularValues()[k] : 0.0;
    rank += value >= 1e-7;
    if (value >= 1e-7) continue;
    for (Eigen::Index c = 0; c < direction.size(); ++c) is_seen[c] = is_seen[c] && std::abs(direction[c]) < 1e-6;
  }
  report.chi2 = chi2;
  report.degrees_of_freedom = fitter.readings() - rank;
  if (report.degrees_of_freedom <= 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("session ", session.session, ": ", fitter.readings(), " readings for ", rank,
                     " unknowns leave no degree of freedom: nothing would judge the fit, expected more start angles"));
  }
  const double grown = std::max(1.0, chi2 / report.degrees_of_freedom);
  report.coverage_factor = information::CoverageFactor(grown > 1.0, report.degrees_of_freedom);
  const Eigen::MatrixXd covariance = Covariance(fitter, session, best, chi2, grown, is_seen);

  int longest = -1;
  for (int k = 0; k < inserts; ++k) {
    if (is_seen[1 + k] && (longest < 0 || best[1 + k] > best[1 + longest])) longest = k;
  }
  if (longest < 0 || !is_seen[0]) {
    return absl::InvalidArgumentError("session " + session.session +
                                      ": the readings do not tell length and phase apart, expected more start angles");
  }
  report.length_mm = best[1 + longest];
  report.length_sigma_mm = std::sqrt(covariance(1 + longest, 1 + longest));
  report.phase_rad = std::remainder(best[0], kTurn);
  report.phase_sigma_rad = std::sqrt(covariance(0, 0));
  const double f_mm = session.run.feed_per_insert_mm(session.cutter);
  std::vector<double> to_be_seen_mm(inserts, 0.0);
  for (int k = 0; k < inserts; ++k) {
    InsertWear& insert = report.inserts[k];
    insert.unseen_from_mm = unseen_from_mm[k];
    insert.is_identifiable = is_seen[1 + k];
    if (insert.is_identifiable) {
      insert.wear_mm = report.length_mm - best[1 + k];
      const double variance =
          covariance(1 + longest, 1 + longest) + covariance(1 + k, 1 + k) - 2.0 * covariance(1 + longest, 1 + k);
      insert.sigma_mm = k == longest ? 0.0 : std::sqrt(std::max(0.0, variance));
      continue;
    }
    insert.at_least_mm = BoundMm(fitter, best, k, chi2, grown, f_mm);
    to_be_seen_mm[k] = std::max(insert.unseen_from_mm, insert.at_least_mm);
  }
  if (std::any_of(to_be_seen_mm.begin(), to_be_seen_mm.end(), [](double mm) { return mm > 0.0; }))
    report.propose = FeedThatSees(session.cutter, session.run, to_be_seen_mm);

  std::vector<double> starts;
  for (int i = 0; i < 2 * kSearchSteps; ++i) starts.push_back(0.5 * i * kSearchStep);
  for (const CurvePoint& point : fitter.CurveOf(best).At(starts))
    report.inserts[point.insert].share_rad += 0.5 * kSearchStep;
  for (int i = 0; i < fitter.readings(); ++i) report.residual_mm.push_back(residual[i]);
  report.rms_mm = residual.norm() / std::sqrt(static_cast<double>(fitter.readings()));
  report.longest_reading_mm = *std::max_element(session.lengths_mm.begin(), session.lengths_mm.end());
  return report;
}

}  // namespace axiscal::toolsetter
