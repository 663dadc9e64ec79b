// What one more group would do to the objective, for all groups at once.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/objective/scorer_factor.h"

namespace axiscal::objective {

namespace {

// Of a small positive definite matrix.
double LogDeterminant(const Eigen::MatrixXd& gram) {
  return gram.size() == 1 ? std::log(gram(0, 0)) : std::log(gram.determinant());
}

}  // namespace

// No variance explains more than the largest, and the determinant only costs.
double Scorer::LeastOfBlock(int which, const Eigen::MatrixXd& gram, const Eigen::VectorXd& right, double squares,
                            double design) const {
  const Group& one = group(which);
  const double mean = gram.diagonal().dot(one.spectrum) / static_cast<double>(one.spectrum.size());
  if (!(mean > 0.0)) return std::numeric_limits<double>::infinity();
  const double variance = std::min(std::exp(policy_.largest_log_variance) / mean, one.largest_variance);
  Eigen::MatrixXd held = gram;
  held.diagonal().array() += design / variance / one.spectrum.array();
  const Eigen::LLT<Eigen::MatrixXd> cholesky(held);
  if (cholesky.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();  // rounding: nothing is known
  return dof_ / design * LogRatio(squares - right.dot(cholesky.solve(right)), squares);
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

namespace {
// Of 16 to 200 numbers for each of tens of thousands of columns so many are worked on at once that they are still in a
// processor's level-two cache when they are read again: 32,768 numbers are 256 KiB. Eigen would copy all columns that a
// solve is given.
constexpr Eigen::Index kNumbersAtOnce = 32768;

// Calls visit(first, count) for all columns of a matrix, some at a time.
template <typename Visit>
void ForColumns(Eigen::Index rows, Eigen::Index columns, Visit visit) {
  const Eigen::Index at_once = std::max<Eigen::Index>(1, kNumbersAtOnce / std::max<Eigen::Index>(1, rows));
  for (Eigen::Index first = 0; first < columns; first += at_once) visit(first, std::min(at_once, columns - first));
}

// B with B' B = W' V^-1 W, W the rows of some columns in K^-1 P and V their part of K^-1: what K^-1 explains by them
// beyond what it explains without them.
std::optional<Eigen::MatrixXd> BackOf(const Eigen::MatrixXd& inverse, const Eigen::Ref<const Eigen::MatrixXd>& weights,
                                      Eigen::Index first, Eigen::Index count) {
  const Eigen::LLT<Eigen::MatrixXd> own(inverse.block(first, first, count, count));
  if (own.info() != Eigen::Success) return std::nullopt;  // rounding
  Eigen::MatrixXd back(count, weights.cols());
  ForColumns(count, weights.cols(), [&](Eigen::Index column, Eigen::Index columns) {
    auto some = back.middleCols(column, columns);
    some = weights.block(first, column, count, columns);
    own.matrixL().solveInPlace(some);
  });
  return back;
}
}  // namespace

Scorer::Explained Scorer::ExplainedBy(const State& state, double design, const Factor& factor) {
  Explained out;
  out.flat = factor.flat;
  const bool is_fresh = ground_ && ground_->design == design && ground_->of_y.size() == column_count_;
  if (is_fresh && ground_->state == state) {
    out.ground = &*ground_;
    out.of_y = ground_->of_y;
    return out;
  }
  if (is_fresh && ground_->state.size() == state.size() + 1) {
    const auto gone = std::mismatch(state.begin(), state.end(), ground_->state.begin()).second;
    const auto which = gone - ground_->state.begin();
    if (std::equal(gone + 1, ground_->state.end(), state.begin() + which)) {
      const Eigen::Index first = ground_->first[static_cast<size_t>(which)], count = group(gone->group).columns;
      const bool has_flat = first < ground_->flat && ground_->flat_weights.size() > 0;
      std::optional<Eigen::MatrixXd> back = BackOf(ground_->inverse, ground_->Weights(), first, count), flat_back;
      if (has_flat) flat_back = BackOf(ground_->flat_inverse, ground_->flat_weights, first, count);
      if (back && (flat_back || !has_flat)) {
        out.ground = &*ground_;
        const std::optional<Eigen::MatrixXd> of_y = BackOf(ground_->inverse, ground_->amplitude, first, count);
        out.of_y = ground_->of_y;
        out.of_y.noalias() -= back->transpose() * *of_y;
        out.back = *std::move(back);
        if (has_flat) out.flat_back = *std::move(flat_back);
        return out;
      }
    }
  }
  const Eigen::Index size = factor.half.size();
  const bool is_known = half_of_.design == design && half_of_.columns == column_count_ && half_of_.state == state;
  if (!is_known) {
    LoadProducts(state);
    if (static_cast<Eigen::Index>(half_.size()) < size * column_count_) half_.resize(size * column_count_);
  }
  new (&out.half) Eigen::Map<Eigen::MatrixXd>(half_.data(), size, column_count_);
  if (!is_known && !state.empty()) {
    const auto lower = factor.lower.triangularView<Eigen::Lower>();
    ForColumns(size, column_count_, [&](Eigen::Index first, Eigen::Index count) {
      auto some = out.half.middleCols(first, count);
      for (size_t i = 0; i < state.size(); ++i) {
        const Eigen::MatrixXd& products = loaded_.at(state[i].group).products;
        some.middleRows(factor.first[i], products.cols()) = products.middleRows(first, count).transpose();
      }
      lower.solveInPlace(some);
    });
  }
  half_of_ = {state, design, column_count_};
  out.of_y = out.half.transpose() * factor.half;
  return out;
}

template <typename Gram>
void Scorer::TakeOff(const Explained& explained, int group, bool by_flat, Gram* gram) const {
  const Eigen::Index columns = gram->cols(), first = first_column_[group];
  const auto add = [&](const auto& rows, double sign) {
    if (rows.rows() == 0) return;
    const auto its = rows.middleCols(first, columns);
    if constexpr (Gram::MaxRowsAtCompileTime == Eigen::Dynamic) {
      gram->noalias() += sign * (its.transpose() * its);
    } else {
      *gram += sign * its.transpose().lazyProduct(its);
    }
  };
  if (explained.ground == nullptr)
    return add(explained.half.topRows(by_flat ? explained.flat : explained.half.rows()), -1.0);
  *gram -= (by_flat ? explained.ground->taken_flat : explained.ground->taken)[static_cast<size_t>(group)];
  add(by_flat ? explained.flat_back : explained.back, 1.0);
}

void Scorer::Keep(const State& state, double design) {
  const Factor factor = FactorOf(state, design);
  if (!factor.is_possible || state.empty()) return;
  const Explained whole = ExplainedBy(state, design, factor);
  if (whole.ground != nullptr) {
    if (whole.back.rows() == 0) return;  // it is that
    ground_.reset();                     // less than what was kept: from the beginning
    return Keep(state, design);
  }
  Ground ground{state, design, factor.first, factor.flat, {}, {}, {}, {}, {}, whole.of_y, {}, {}};
  const auto lower = factor.lower.triangularView<Eigen::Lower>();
  const Eigen::Index n = factor.lower.rows();
  const Eigen::MatrixXd root = lower.solve(Eigen::MatrixXd::Identity(n, n));
  ground.inverse = root.transpose() * root;
  if (ground_) ground.weights = std::move(ground_->weights);
  if (static_cast<Eigen::Index>(ground.weights.size()) < whole.half.size()) ground.weights.resize(whole.half.size());
  Eigen::Map<Eigen::MatrixXd> weights(ground.weights.data(), n, whole.half.cols());
  ForColumns(n, whole.half.cols(), [&](Eigen::Index first, Eigen::Index count) {
    auto some = weights.middleCols(first, count);
    some = whole.half.middleCols(first, count);
    lower.transpose().solveInPlace(some);
  });
  ground.amplitude = lower.transpose().solve(factor.half);
  const bool has_blocks = factor.flat < n;
  if (has_blocks && factor.flat > 0) {
    const auto flat_root = root.topLeftCorner(factor.flat, factor.flat);
    ground.flat_inverse = flat_root.transpose() * flat_root;
    ground.flat_weights = flat_root.transpose() * whole.half.topRows(factor.flat);
  }
  for (int g = 0; g < group_count(); ++g) {
    const auto its = whole.half.middleCols(first_column_[g], group(g).columns);
    ground.taken.emplace_back(its.transpose() * its);
    if (!has_blocks) continue;
    const auto by_flat = its.topRows(factor.flat);
    ground.taken_flat.emplace_back(by_flat.transpose() * by_flat);
  }
  ground_ = std::move(ground);
}

template <typename Limit, typename Visit>
void Scorer::ForEachAddition(const State& state, double design, const std::vector<bool>& allowed, Limit limit,
                             Visit visit) {
  const Factor factor = FactorOf(state, design);
  if (!factor.is_possible) return;
  const double base = dof_ / design * LogSquares(factor.squares) + factor.log_det + factor.prices;
  const Explained explained = ExplainedBy(state, design, factor);
  Eigen::VectorXd right = with_y_ - explained.of_y;
  // What a flat group explains, or nothing where it is a combination of the state or has an amplitude that is none.
  const auto explains = [&](int g, auto gram, bool is_exact) -> std::optional<double> {
    const Group& one = group(g);
    for (int c = 0; c < one.columns; ++c) {
      if (one.precision.size() == 0 && gram(c, c) <= policy_.distinct * gram_[g](c, c)) return std::nullopt;
      gram(c, c) += kRidge * gram_[g](c, c) + design * PrecisionOf(one, c, raw_[first_column_[g] + c]);
    }
    const auto b = right.segment(first_column_[g], one.columns);
    if (one.columns == 1) {
      if (is_exact && std::abs(b[0]) > one.largest_amplitude * gram(0, 0)) return std::nullopt;
      return b[0] * b[0] / gram(0, 0);
    }
    using Gram = decltype(gram);
    const Eigen::LLT<Gram> cholesky(gram);
    const double last = cholesky.matrixLLT()(one.columns - 1, one.columns - 1);
    if (cholesky.info() != Eigen::Success || last * last < policy_.distinct * gram(one.columns - 1, one.columns - 1))
      return std::nullopt;
    const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, Gram::MaxRowsAtCompileTime, 1> amplitude = cholesky.solve(b);
    if (is_exact && amplitude.cwiseAbs().maxCoeff() > one.largest_amplitude) return std::nullopt;
    return b.dot(amplitude);
  };
  const auto gain = [&](double squares) { return dof_ / design * LogRatio(factor.squares - squares, factor.squares); };
  const auto beyond = [&](int g, bool by_flat = false) {
    Eigen::MatrixXd gram = gram_[g];
    TakeOff(explained, g, by_flat, &gram);
    return gram;
  };
  const auto flat_explains = [&](int g, bool is_exact) {
    constexpr int kSmall = 4;  // columns of nearly all groups: on the stack, as there are tens of thousands
    if (group(g).columns > kSmall) return explains(g, beyond(g), is_exact);
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kSmall, kSmall> gram = gram_[g];
    TakeOff(explained, g, false, &gram);
    return explains(g, gram, is_exact);
  };
  const auto look_at = [&](int g) {
    const Group& one = group(g);
    Move move{{g, 0.0}};
    if (one.IsBlock()) {
      const Eigen::MatrixXd left = beyond(g);
      const Eigen::VectorXd its = right.segment(first_column_[g], one.columns);
      // Eigenvalues take ten times as long, and few blocks come near.
      if (LeastOfBlock(g, left, its, factor.squares, design) + PriceOf(g, design) > limit()) return;
      move = BestBlock(g, left, its, factor.squares, design);
    } else {
      const std::optional<double> squares = flat_explains(g, true);
      if (!squares) return;
      move.objective = gain(*squares);
      // What the new columns and the blocks share, the blocks need no longer explain.
      if (factor.flat < factor.half.size())
        move.objective += LogDeterminant(beyond(g)) - LogDeterminant(beyond(g, true));
    }
    move.objective += PriceOf(g, design);
    if (move.objective > limit()) return;
    move.objective += base;
    visit(move, base);
  };
  // Members of scans with the least that their objective may be, beyond the state's.
  std::vector<std::pair<double, int>> scanned;
  for (int g = 0; g < group_count(); ++g) {
    if (!is_visible_[g] || (!allowed.empty() && !allowed[origin_[g]])) continue;
    const bool is_there = std::any_of(state.begin(), state.end(), [&](const Member& member) {
      return member.group == g || IsSameEffect(group(member.group), group(g));
    });
    if (is_there) continue;
    if (is_exact_[g]) {
      look_at(g);
      continue;
    }
    const std::optional<double> squares = flat_explains(g, false);
    if (squares) scanned.emplace_back(gain(*squares / policy_.scan_visible) + PriceOf(g, design), g);
  }
  // The most promising first: what they are worth spares the projection of most others.
  std::sort(scanned.begin(), scanned.end());
  for (const auto& [least, g] : scanned) {
    if (least > limit()) break;
    MakeExact(g);
    const Eigen::Index first = first_column_[g], columns = group(g).columns;
    right.segment(first, columns) = with_y_.segment(first, columns) - explained.of_y.segment(first, columns);
    if (is_visible_[g]) look_at(g);
  }
}

namespace {
bool IsBetter(const Move& a, const Move& b) { return a.objective < b.objective; }
}  // namespace

std::optional<std::vector<Move>> Scorer::Known(const std::vector<Answer>& answers, const std::vector<bool>& allowed,
                                               int most) const {
  const auto is_allowed = [&](const Move& move) { return allowed.empty() || allowed[origin_[move.member.group]]; };
  for (const Answer& one : answers) {
    const auto holds = [&](size_t g) { return one.allowed.empty() || one.allowed[g]; };
    bool is_wider = true;
    for (size_t g = 0; is_wider && !one.allowed.empty() && g < one.allowed.size(); ++g)
      is_wider = holds(g) || !(allowed.empty() || allowed[g]);
    if (!is_wider) continue;
    std::vector<Move> moves;
    std::copy_if(one.moves.begin(), one.moves.end(), std::back_inserter(moves), is_allowed);
    // Where the wider one ended before its list was full, it holds all there are.
    const bool is_whole = static_cast<int>(one.moves.size()) < one.most;
    if (!is_whole && static_cast<int>(moves.size()) < most) continue;
    if (static_cast<int>(moves.size()) > most) moves.resize(most);
    return moves;
  }
  return std::nullopt;
}

std::vector<Move> Scorer::Additions(const State& state, double design, const std::vector<bool>& allowed, int most) {
  std::vector<std::pair<double, double>> members;
  for (const Member& one : state) members.emplace_back(one.group, one.variance);
  std::sort(members.begin(), members.end());
  std::vector<double> question = {static_cast<double>(group_count()), design};
  for (const auto& [group, variance] : members) question.insert(question.end(), {group, variance});
  if (!answers_.empty() && answers_.begin()->first.front() != question.front()) answers_.clear();
  std::vector<Answer>& answers = answers_[question];
  if (std::optional<std::vector<Move>> known = Known(answers, allowed, most)) return *std::move(known);
  std::vector<Move> best;
  double worst = std::numeric_limits<double>::infinity();  // beyond the state, once there are enough
  ForEachAddition(
      state, design, allowed, [&] { return std::min(worst, policy_.evidence); },
      [&](const Move& move, double base) {
        best.insert(std::upper_bound(best.begin(), best.end(), move, IsBetter), move);
        if (static_cast<int>(best.size()) > most) best.pop_back();
        if (static_cast<int>(best.size()) == most) worst = best.back().objective - base;
      });
  answers.push_back({allowed, most, best});
  return best;
}

std::vector<Move> Scorer::AdditionsWithin(const State& state, double design, double limit) {
  std::vector<Move> within;
  const double beyond = limit - ScoreOf(state, design).objective;
  ForEachAddition(
      state, design, {}, [beyond] { return beyond; }, [&](const Move& move, double) { within.push_back(move); });
  std::stable_sort(within.begin(), within.end(), IsBetter);
  return within;
}

}  // namespace axiscal::objective
