#include "core/objective/scorer.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace axiscal::objective {

namespace {

// A share of rss that is left at most: rounding.
constexpr double kLeft = 1e-12;
// A flat column's own ridge, share of its squares: rounding of the products.
constexpr double kRidge = 1e-10;

// Of a small positive definite matrix.
double LogDeterminant(const Eigen::MatrixXd& gram) {
  return gram.size() == 1 ? std::log(gram(0, 0)) : std::log(gram.determinant());
}

double LogRatio(double left, double squares) { return std::log(std::max(left / squares, kLeft)); }

}  // namespace

// Cholesky factor of K + D (precision of the priors), flat members' columns first.
struct Scorer::Factor {
  bool is_possible = true;
  std::vector<Eigen::Index> first;  // per member: where its columns stand
  Eigen::MatrixXd lower;
  Eigen::VectorXd half;   // lower^-1 b
  Eigen::Index flat = 0;  // columns of flat members
  double squares = 0.0;   // rss
  double log_det = 0.0;   // of the blocks
  double prices = 0.0;
};

Scorer::Scorer(const Rows& rows, std::vector<std::unique_ptr<Source>> sources, const Policy& policy)
    : rows_(rows), sources_(std::move(sources)), policy_(policy), nuisance_(rows) {
  Eigen::VectorXd of_y = nuisance_.CoefficientsOf(rows.y) + nuisance_.OfPriors();
  y_ = rows.y - nuisance_.Explained(of_y);
  squares_ = rows.y.squaredNorm() + nuisance_.PriorSquares() - of_y.squaredNorm();
  dof_ = std::max<double>(1.0, rows.count() - static_cast<double>(rows.common.cols()));
  const Eigen::MatrixXd own = rows.whitening.Adjoint(rows.own), common = rows.whitening.Adjoint(rows.common);
  const Eigen::MatrixXd y = rows.whitening.Adjoint(y_);
  for (size_t s = 0; s < sources_.size(); ++s) {
    const Source& source = *sources_[s];
    const Eigen::Index width = source.column_count();
    Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(width, nuisance_.size());
    for (const Stretch& some : rows.stretches) {
      const Eigen::Index n = some.end - some.begin, k = rows.own_precision[some.group].size();
      Eigen::MatrixXd vectors(n, k + common.cols());
      vectors << own.block(some.begin, 0, n, k), common.middleRows(some.begin, n);
      Eigen::MatrixXd products = Eigen::MatrixXd::Zero(width, vectors.cols());
      source.AddProducts(some.begin, vectors, products);
      coefficients.middleCols(nuisance_.OffsetOf(some.group), k) += products.leftCols(k);
      coefficients.rightCols(common.cols()) += products.rightCols(common.cols());
    }
    nuisance_.Finish(coefficients);
    Eigen::MatrixXd with_y = Eigen::MatrixXd::Zero(width, 1);
    source.AddProducts(0, y, with_y);
    const Eigen::Index before = with_y_.size();
    with_y_.conservativeResize(before + width);
    with_y_.tail(width) = with_y.col(0);
    std::vector<Eigen::MatrixXd> grams = source.Grams(rows.whitening);
    Eigen::Index at = 0;
    for (size_t g = 0; g < grams.size(); ++g) {
      const auto own_coefficients = coefficients.middleRows(at, grams[g].rows());
      const Eigen::VectorXd raw = grams[g].diagonal();
      Eigen::MatrixXd& gram = gram_.emplace_back(std::move(grams[g]));
      gram.noalias() -= own_coefficients * own_coefficients.transpose();
      constexpr double kRounding = 1e-6;  // squares of sigmas per unit: nothing is there
      double least = 1.0, most = 0.0;
      for (Eigen::Index i = 0; i < raw.size(); ++i) {
        const double share = raw[i] > kRounding ? gram(i, i) / raw[i] : 0.0;
        least = std::min(least, share);
        most = std::max(most, share);
      }
      const Group& group = source.groups()[g];
      // A block and an effect that a prior holds may be seen in a part of their columns.
      const bool is_held = group.IsBlock() || group.precision.size() > 0;
      is_visible_.push_back((is_held ? most : least) > policy_.visible);
      visible_members_[group.family] += is_visible_.back();
      at_.emplace_back(static_cast<int>(s), static_cast<int>(g));
      first_column_.push_back(column_count_ + at);
      at += raw.size();
    }
    column_count_ += width;
  }
}

const Group& Scorer::group(int group) const { return sources_[at_[group].first]->groups()[at_[group].second]; }

const Source& Scorer::SourceOf(int group, int* within) const {
  *within = at_[group].second;
  return *sources_[at_[group].first];
}

double Scorer::PriceOf(int which) const {
  const Group& one = group(which);
  const int members = visible_members_.at(one.family);
  return policy_.evidence + policy_.per_look * std::log(std::max(1, members)) +
         (one.IsBlock() ? 0.0 : policy_.per_column * (one.columns - 1)) + (one.is_exotic ? policy_.exotic : 0.0);
}

Eigen::MatrixXd Scorer::Projected(int group) const {
  int within = 0;
  const Source& source = SourceOf(group, &within);
  Eigen::MatrixXd columns = source.Columns(within);
  rows_.whitening.Apply(0, columns);
  for (Eigen::Index c = 0; c < columns.cols(); ++c)
    columns.col(c) -= nuisance_.Explained(nuisance_.CoefficientsOf(columns.col(c)));
  return columns;
}

const Scorer::Loaded& Scorer::Load(int group) {
  const auto [place, is_new] = loaded_.try_emplace(group);
  Loaded& loaded = place->second;
  if (!is_new) return loaded;
  loaded.columns = Projected(group);
  loaded.products = Eigen::MatrixXd::Zero(column_count_, loaded.columns.cols());
  const Eigen::MatrixXd u = rows_.whitening.Adjoint(loaded.columns);
  Eigen::Index at = 0;
  for (const std::unique_ptr<Source>& source : sources_) {
    const Eigen::Index width = source->column_count();
    source->AddProducts(0, u, loaded.products.middleRows(at, width));
    at += width;
  }
  // Of the group with itself the projected Gram matrix holds the priors' rows too.
  loaded.products.middleRows(first_column_[group], loaded.columns.cols()) = gram_[group];
  return loaded;
}

Scorer::Factor Scorer::FactorOf(const State& state, double design) {
  Factor factor;
  factor.first.resize(state.size());
  Eigen::Index size = 0;
  for (const bool blocks : {false, true}) {
    for (size_t i = 0; i < state.size(); ++i) {
      const Group& one = group(state[i].group);
      if (one.IsBlock() != blocks) continue;
      factor.first[i] = size;
      size += one.columns;
    }
    if (!blocks) factor.flat = size;
  }
  Eigen::MatrixXd gram(size, size);
  Eigen::VectorXd right(size);
  for (size_t i = 0; i < state.size(); ++i) {
    const Group& one = group(state[i].group);
    const Loaded& loaded = Load(state[i].group);
    for (size_t k = 0; k < state.size(); ++k) {
      const Group& other = group(state[k].group);
      gram.block(factor.first[k], factor.first[i], other.columns, one.columns) =
          loaded.products.middleRows(first_column_[state[k].group], other.columns);
    }
    right.segment(factor.first[i], one.columns) = with_y_.segment(first_column_[state[i].group], one.columns);
    for (int c = 0; c < one.columns; ++c) {
      double& own = gram(factor.first[i] + c, factor.first[i] + c);
      if (one.IsBlock()) {
        const double variance = state[i].variance * one.spectrum[c];
        own += design / variance;
        factor.log_det += std::log(variance / design);
      } else {
        own += kRidge * own + (one.precision.size() > 0 ? design * one.precision[c] : 0.0);
      }
    }
    factor.prices += PriceOf(state[i].group);
  }
  const Eigen::LLT<Eigen::MatrixXd> cholesky(gram);
  factor.is_possible = cholesky.info() == Eigen::Success;
  if (!factor.is_possible) return factor;
  factor.lower = cholesky.matrixL();
  for (Eigen::Index i = 0; i < factor.flat; ++i)
    factor.is_possible &= factor.lower(i, i) * factor.lower(i, i) > policy_.distinct * gram(i, i);
  factor.half = factor.lower.triangularView<Eigen::Lower>().solve(right);
  factor.squares = std::max(squares_ - factor.half.squaredNorm(), kLeft * squares_);
  for (Eigen::Index i = factor.flat; i < size; ++i) factor.log_det += 2.0 * std::log(factor.lower(i, i));
  return factor;
}

Score Scorer::ScoreOf(const State& state, double design) {
  const Factor factor = FactorOf(state, design);
  Score score;
  if (!factor.is_possible) return score;
  score.is_possible = true;
  score.squares = factor.squares;
  score.objective = dof_ / design * std::log(factor.squares / dof_) + factor.log_det + factor.prices;
  const Eigen::VectorXd amplitudes = factor.lower.triangularView<Eigen::Lower>().transpose().solve(factor.half);
  for (size_t i = 0; i < state.size(); ++i) {
    const Group& one = group(state[i].group);
    score.amplitude.emplace_back(amplitudes.segment(factor.first[i], one.columns));
    if (score.amplitude.back().cwiseAbs().maxCoeff() > one.largest_amplitude) score.is_possible = false;
  }
  if (!score.is_possible) score.objective = std::numeric_limits<double>::infinity();
  return score;
}

// With g the products and k the eigenvalues of the block's columns times the root of its spectrum:
//   2 ln evidence = -dof/D ln(1 - q / rss) - sum ln(1 + v k / D),   q = sum v g^2 / (D + v k)
Move Scorer::BestBlock(int which, const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, double squares,
                       double design) const {
  const Group& one = group(which);
  const Eigen::VectorXd root = one.spectrum.cwiseSqrt();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(root.asDiagonal() * gram * root.asDiagonal());
  const Eigen::ArrayXd k = eigen.eigenvalues().array().max(0.0);
  const Eigen::ArrayXd g2 = (eigen.eigenvectors().transpose() * root.cwiseProduct(right)).array().square();
  Move best{{which, 0.0}};
  if (!(k.mean() > 0.0)) return best;
  for (double power = policy_.smallest_log_variance; power <= policy_.largest_log_variance; power += 1.0) {
    const double variance = std::min(std::exp(power) / k.mean(), one.largest_variance);
    const double explained = (variance * g2 / (design + variance * k)).sum();
    const double change =
        dof_ / design * LogRatio(squares - explained, squares) + (1.0 + variance * k / design).log().sum();
    if (change < best.objective) best = {{which, variance}, change};
    if (variance == one.largest_variance) break;
  }
  return best;
}

template <typename Visit>
void Scorer::ForEachAddition(const State& state, double design, const std::vector<bool>& allowed, Visit visit) {
  const Factor factor = FactorOf(state, design);
  if (!factor.is_possible) return;
  const double base = dof_ / design * std::log(factor.squares / dof_) + factor.log_det + factor.prices;
  // lower^-1 times the products of the state's columns with all others: what the state explains of them.
  Eigen::MatrixXd half(factor.half.size(), column_count_);
  for (size_t i = 0; i < state.size(); ++i) {
    const Eigen::MatrixXd& products = Load(state[i].group).products;
    half.middleRows(factor.first[i], products.cols()) = products.transpose();
  }
  if (!state.empty()) factor.lower.triangularView<Eigen::Lower>().solveInPlace(half);
  Eigen::VectorXd right = with_y_;
  if (!state.empty()) right.noalias() -= half.transpose() * factor.half;
  for (int g = 0; g < group_count(); ++g) {
    if (!is_visible_[g] || (!allowed.empty() && !allowed[g])) continue;
    const Group& one = group(g);
    const bool is_there = std::any_of(state.begin(), state.end(), [&](const Member& member) {
      return member.group == g || IsSameEffect(group(member.group), one);
    });
    if (is_there) continue;
    const auto its = half.middleCols(first_column_[g], one.columns);
    Eigen::MatrixXd gram = gram_[g];
    if (!state.empty()) gram.noalias() -= its.transpose() * its;
    const auto b = right.segment(first_column_[g], one.columns);
    Move move{{g, 0.0}};
    if (one.IsBlock()) {
      move = BestBlock(g, gram, b, factor.squares, design);
    } else {
      bool is_distinct = true;
      for (int c = 0; c < one.columns; ++c) {
        is_distinct &= one.precision.size() > 0 || gram(c, c) > policy_.distinct * gram_[g](c, c);
        gram(c, c) += kRidge * gram_[g](c, c) + (one.precision.size() > 0 ? design * one.precision[c] : 0.0);
      }
      if (!is_distinct) continue;
      double explained = 0.0, largest = 0.0;
      if (one.columns == 1) {
        explained = b[0] * b[0] / gram(0, 0);
        largest = std::abs(b[0]) / gram(0, 0);
      } else {
        const Eigen::LLT<Eigen::MatrixXd> cholesky(gram);
        const double last = cholesky.matrixLLT()(one.columns - 1, one.columns - 1);
        if (cholesky.info() != Eigen::Success ||
            last * last < policy_.distinct * gram(one.columns - 1, one.columns - 1))
          continue;
        const Eigen::VectorXd amplitude = cholesky.solve(b);
        explained = b.dot(amplitude);
        largest = amplitude.cwiseAbs().maxCoeff();
      }
      if (largest > one.largest_amplitude) continue;
      move.objective = dof_ / design * LogRatio(factor.squares - explained, factor.squares);
      // What the new columns and the blocks share, the blocks need no longer explain.
      if (factor.flat < factor.half.size()) {
        const auto by_flat = its.topRows(factor.flat);
        const Eigen::MatrixXd beyond_flat = gram_[g] - by_flat.transpose() * by_flat;
        move.objective += LogDeterminant(gram) - LogDeterminant(beyond_flat);
      }
    }
    move.objective += base + PriceOf(g);
    visit(move);
  }
}

namespace {
bool IsBetter(const Move& a, const Move& b) { return a.objective < b.objective; }
}  // namespace

std::vector<Move> Scorer::Additions(const State& state, double design, const std::vector<bool>& allowed, int most) {
  std::vector<Move> best;
  ForEachAddition(state, design, allowed, [&](const Move& move) {
    if (static_cast<int>(best.size()) == most && !IsBetter(move, best.back())) return;
    best.insert(std::upper_bound(best.begin(), best.end(), move, IsBetter), move);
    if (static_cast<int>(best.size()) > most) best.pop_back();
  });
  return best;
}

std::vector<Move> Scorer::AdditionsWithin(const State& state, double design, double limit) {
  std::vector<Move> within;
  ForEachAddition(state, design, {}, [&](const Move& move) {
    if (move.objective <= limit) within.push_back(move);
  });
  std::stable_sort(within.begin(), within.end(), IsBetter);
  return within;
}

void Scorer::RefineVariances(double design, State* state) {
  for (size_t i = 0; i < state->size(); ++i) {
    if (!group((*state)[i].group).IsBlock()) continue;
    State others = *state;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    std::vector<bool> only(group_count(), false);
    only[(*state)[i].group] = true;
    const std::vector<Move> moves = Additions(others, design, only, 1);
    if (!moves.empty() && moves[0].member.variance > 0.0) (*state)[i].variance = moves[0].member.variance;
  }
}

Eigen::VectorXd Scorer::ResidualOf(const State& state, double design) {
  const Score score = ScoreOf(state, design);
  Eigen::VectorXd residual = y_;
  for (size_t i = 0; i < score.amplitude.size(); ++i) residual -= Load(state[i].group).columns * score.amplitude[i];
  return residual;
}

}  // namespace axiscal::objective
