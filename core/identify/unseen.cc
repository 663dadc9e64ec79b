#include "core/identify/unseen.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/identify/errors_of_run.h"
#include "core/identify/plausible_errors.h"
#include "core/identify/rows.h"
#include "core/identify/whitening.h"
#include "core/instruments/distortion.h"

namespace axiscal::identify {
namespace {

using instruments::MeasuringRun;

ReadingSample SampleOf(const MeasuringRun& run, int stretches) {
  constexpr int kStretch = 4;
  if (run.reading_count() / stretches <= kStretch) return {};
  return {kStretch, (run.reading_count() + stretches - 1) / stretches};
}

// Of solved.null_space, those whose error is held at the solution: a row each.
Eigen::MatrixXd HeldDirections(const SolvedProblem& solved) {
  std::vector<int> rows;
  for (size_t k = 0; k < solved.null_space.fixed.size(); ++k) {
    if (solved.IsHeld(solved.null_space.fixed[k])) rows.push_back(static_cast<int>(k));
  }
  return solved.null_space.directions(rows, Eigen::all);
}

// Where the solution was linearised, with the errors moved along each direction by as much as an error of a plausible
// size (`sizes`) does.
struct MovedPoint {
  Point point;
  double size;  // of the move, in units of the direction
};

std::vector<MovedPoint> MovedAlong(const SolvedProblem& solved, const Eigen::MatrixXd& directions,
                                   const Eigen::VectorXd& sizes) {
  std::vector<MovedPoint> out;
  for (const auto direction : directions.rowwise()) {
    out.push_back({solved.solution.linearised, 1.0 / direction.transpose().cwiseQuotient(sizes).cwiseAbs().maxCoeff()});
    for (size_t i = 0; i < solved.parameters.size(); ++i) {
      const Parameter& parameter = solved.parameters[i];
      const double move = out.back().size * direction[static_cast<Eigen::Index>(i)];
      if (move != 0.0) SetValue(parameter, ValueOf(out.back().point.model, parameter) + move, &out.back().point.model);
    }
  }
  return out;
}

struct Sums {
  Eigen::MatrixXd gram, by_change;  // J' J, J' D

  Sums(Eigen::Index rows, Eigen::Index columns)
      : gram(Eigen::MatrixXd::Zero(rows, rows)), by_change(Eigen::MatrixXd::Zero(rows, columns)) {}
  void operator+=(const Sums& other) {
    gram += other.gram;
    by_change += other.by_change;
  }
  void operator*=(double factor) {
    gram *= factor;
    by_change *= factor;
  }
};

// J' D of all readings, by those of a sample and by J' J of all (`gram`). Most of D is like an offset or an error, D =
// J c + R: offsets and errors take that up, and what they do not is small beside it. In J' D of a sample the part J c
// is off by the sample's scatter, many times R, so that it is taken by J' J of all and R alone by the sample (control
// variate: c need not be exact). What the sample shows by less than a thousandth of what all show is left out of c.
Eigen::MatrixXd ByChangeOfAll(const Sums& sample, const Eigen::MatrixXd& gram) {
  constexpr double kLeastShare = 1e-3, kRidge = 1e-12;
  const Eigen::VectorXd scale =
      gram.diagonal().unaryExpr([](double own) { return own > 0.0 ? 1.0 / std::sqrt(own) : 0.0; });
  Eigen::MatrixXd block = scale.asDiagonal() * (sample.gram + kLeastShare * gram) * scale.asDiagonal();
  block.diagonal().array() += kRidge;
  const Eigen::MatrixXd like = scale.asDiagonal() * block.ldlt().solve(scale.asDiagonal() * sample.by_change);
  return sample.by_change + (gram - sample.gram) * like;
}

// Takes the rows of a run (VisitRows) and sums J' J and J' D: column K i + k of D is d(J n_k)/ds_i.
// d(J n_k)/ds_i is also how far the derivative by s_i moves with the errors along n_k: one evaluation for all offsets.
class ProductSink {
 public:
  // `is_unknown`: 1 for an offset that counts, 0 for one that does not.
  ProductSink(const SolvedProblem& solved, int run, const Eigen::MatrixXd& directions,
              const std::vector<MovedPoint>& moved, const Eigen::RowVectorXd& is_unknown, const ReadingSample& sample)
      : problem_(solved.problem),
        run_(run),
        setup_(SetupOf(solved.problem, solved.solution.linearised, static_cast<size_t>(run))),
        offsets_(solved.problem.offsets_of_run[static_cast<size_t>(run)]),
        setup_count_(SetupCount(solved.problem, run)),
        directions_(directions),
        moved_(moved),
        is_unknown_(is_unknown),
        sample_(sample),
        row_(setup_count_ + directions.cols() + 1 + setup_count_ * directions.rows()),
        whiteners_(Run().row_count, SeriesWhitener(solved.problem.noise[run], row_.size())),
        by_setup_(moved.size()),
        sums_(setup_count_ + directions.cols(), setup_count_ * directions.rows()) {
    errors_of_run_.reserve(moved.size());
    for (const MovedPoint& one : moved) errors_of_run_.emplace_back(problem_, one.point);
  }

  Eigen::VectorBlock<Eigen::RowVectorXd> NextRow() { return row_.head(row_.size()); }

  template <typename Row>
  void Close(int reading, int r, const instruments::Evaluation&, Row& row) {
    if (reading != evaluated_) EvaluateMoved(reading);
    const Eigen::Index s = setup_count_, p = directions_.cols(), k = directions_.rows();
    row.tail(s * k).setZero();
    for (Eigen::Index z = 0; z < k; ++z) {
      const auto n = static_cast<size_t>(z);
      for (Eigen::Index own = 0; own < setup_.size(); ++own) {
        const Eigen::Index i = offsets_[static_cast<size_t>(own)];
        row[s + p + 1 + i * k + z] = is_unknown_[i] * (by_setup_[n](r, own) - row[i]) / moved_[n].size;
      }
    }
    whiteners_[static_cast<size_t>(r)].Apply(reading, row);
    if (sample_.IsFirstOfStretch(reading)) return;
    sums_.gram.selfadjointView<Eigen::Lower>().rankUpdate(row.head(s + p).transpose());
    sums_.by_change.noalias() += row.head(s + p).transpose() * row.tail(s * k);
    ++summed_;
  }

  // Of all used rows of the run, from those that were taken.
  Sums Scaled() const {
    const std::vector<bool>& is_used = problem_.is_used[run_];
    const auto used = static_cast<double>(std::count(is_used.begin(), is_used.end(), true));
    Sums scaled = sums_;
    scaled.gram.triangularView<Eigen::StrictlyUpper>() = scaled.gram.transpose();
    if (summed_ > 0) scaled *= used / static_cast<double>(summed_);
    return scaled;
  }

 private:
  const MeasuringRun& Run() const { return problem_.runs[run_]; }

  // Derivatives of a reading by the offsets, at each of the moved points.
  void EvaluateMoved(int reading) {
    evaluated_ = reading;
    const shapes::State state = Run().StateOf(reading);
    const RowWeight* const weight = problem_.WeightOf(run_, reading);
    for (size_t n = 0; n < moved_.size(); ++n) {
      const auto errors_at = [&](const shapes::State& at) -> const machine::JointErrors<double>& {
        return errors_of_run_[n].At(at);
      };
      if (Run().path_readings != nullptr) {
        instruments::EvaluateAlongPath(*problem_.machine, Run(), reading, errors_at, setup_.data(), &evaluation_,
                                       [](const shapes::State&, const instruments::Evaluation&, double) {});
      } else {
        instruments::Evaluate(*problem_.machine, Run(), reading, errors_at(state), setup_.data(), &evaluation_);
      }
      by_setup_[n] = evaluation_.by_setup;
      if (weight != nullptr) by_setup_[n] = *weight * by_setup_[n];
    }
  }

  const Problem& problem_;
  const size_t run_;
  const Eigen::VectorXd setup_;  // the run's own
  const std::vector<Eigen::Index>& offsets_;
  const Eigen::Index setup_count_;  // of its group
  const Eigen::MatrixXd& directions_;
  const std::vector<MovedPoint>& moved_;
  const Eigen::RowVectorXd& is_unknown_;
  const ReadingSample sample_;
  std::vector<ErrorsOfRun> errors_of_run_;  // per direction
  Eigen::RowVectorXd row_;
  std::vector<SeriesWhitener> whiteners_;
  std::vector<Eigen::MatrixXd> by_setup_;  // per direction, of the reading that was evaluated last
  Sums sums_;
  std::int64_t summed_ = 0;
  instruments::Evaluation evaluation_;
  int evaluated_ = -1;
};

}  // namespace

Eigen::MatrixXd UnseenCovariance(const SolvedProblem& solved, const Covariance& covariance, int stretches) {
  const Problem& problem = solved.problem;
  const auto p = static_cast<Eigen::Index>(solved.parameters.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(p, p);
  const Eigen::MatrixXd directions = HeldDirections(solved);
  const Eigen::Index k = directions.rows();
  if (k == 0) return out;
  // Sizes along the directions, each error by itself of a plausible size: precision N P N'.
  const Eigen::VectorXd sizes = kMeasuredWithin * PlausibleSizes(solved.solution.point.model, solved.parameters);
  const Eigen::MatrixXd precision = directions * sizes.cwiseAbs2().cwiseInverse().asDiagonal() * directions.transpose();
  const Eigen::MatrixXd root = precision.llt().matrixU().solve(Eigen::MatrixXd::Identity(k, k));  // root root' = 1 / P

  const Point& at = solved.solution.linearised;
  const std::vector<MovedPoint> moved = MovedAlong(solved, directions, sizes);
  std::vector<Eigen::MatrixXd> by_change;
  for (size_t g = 0; g < problem.groups.size(); ++g) {
    const Eigen::Index s = static_cast<Eigen::Index>(problem.groups[g].parameters.size());
    Eigen::RowVectorXd is_unknown = (covariance.setup_sigma[g].array() > 0.0).cast<double>().transpose();
    for (const int run : problem.groups[g].runs) {
      const std::vector<Eigen::Index>& offsets = problem.offsets_of_run[static_cast<size_t>(run)];
      for (auto own = static_cast<size_t>(instruments::OwnSetupCount(problem.runs[run])); own < offsets.size(); ++own)
        is_unknown[offsets[own]] = 0.0;
    }
    const Eigen::MatrixXd gram = solved.solution.normal.groups[g].gram.topLeftCorner(s + p, s + p);
    Sums sums(s + p, s * k);
    for (const int run : problem.groups[g].runs) {
      const ReadingSample sample = SampleOf(problem.runs[run], stretches);
      ProductSink sink(solved, run, directions, moved, is_unknown, sample);
      VisitRows(problem, run, at, solved.parameters, &sink, sample);
      sums += sink.Scaled();
    }
    by_change.emplace_back(s + p, (s + 1) * k);
    by_change.back() << ByChangeOfAll(sums, gram), gram.rightCols(p) * directions.transpose();
  }
  const std::vector<Eigen::MatrixXd> moves = StepsOf(problem, at, solved.solution.normal, solved.held, by_change);
  for (size_t g = 0; g < moves.size(); ++g) {
    const Eigen::Index s = static_cast<Eigen::Index>(problem.groups[g].parameters.size());
    for (Eigen::Index z = 0; z < k; ++z) {
      Eigen::MatrixXd by_offset = Eigen::MatrixXd::Zero(p, s);
      for (Eigen::Index i = 0; i < s; ++i) by_offset.col(i) = moves[g].middleCols(i * k, k) * root.col(z);
      out += by_offset * covariance.setup[g] * by_offset.transpose();
    }
  }
  // An error is the same in all groups. At the solution J n is d more for each unit of the last step.
  Eigen::MatrixXd at_solution = Eigen::MatrixXd::Zero(p, k);
  for (size_t g = 0; g < moves.size(); ++g) {
    const Eigen::VectorXd last_step = solved.solution.point.setup[g] - at.setup[g];
    Eigen::MatrixXd move = moves[g].rightCols(k);
    for (Eigen::Index i = 0; i < last_step.size(); ++i) move += last_step[i] * moves[g].middleCols(i * k, k);
    at_solution += move * root;
  }
  out += at_solution * at_solution.transpose();
  return out;
}

}  // namespace axiscal::identify
