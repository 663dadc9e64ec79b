#include "core/objective/scorer.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

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

// Whether enough is left of a group's columns. A block and an effect that a prior holds may be seen in a part of them.
bool IsSeen(const Group& group, const Eigen::VectorXd& raw, const Eigen::VectorXd& left, double visible) {
  constexpr double kRounding = 1e-6;  // squares of sigmas per unit: nothing is there
  double least = 1.0, most = 0.0;
  for (Eigen::Index i = 0; i < raw.size(); ++i) {
    const double share = raw[i] > kRounding ? left[i] / raw[i] : 0.0;
    least = std::min(least, share);
    most = std::max(most, share);
  }
  return (group.IsBlock() || group.precision.size() > 0 ? most : least) > visible;
}

}  // namespace

double Scorer::LogSquares(double squares) const { return std::log(std::max(squares, rows_.least_squares) / dof_); }

double Scorer::LogRatio(double left, double squares) const {
  return LogSquares(std::max(left, kLeft * squares)) - LogSquares(squares);
}

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
  own_ = rows.whitening.Adjoint(rows.own);
  common_ = rows.whitening.Adjoint(rows.common);
  for (size_t s = 0; s < sources_.size(); ++s) {
    Take(*sources_[s], s);
    for (const Group& group : sources_[s]->groups()) {
      if (is_visible_[origin_.size()]) visible_members_[group.family] += group.looks;
      origin_.push_back(static_cast<int>(origin_.size()));
    }
  }
}

// Norms and products with y of a source's columns.
void Scorer::Take(const Source& source, size_t number) {
  const Eigen::MatrixXd y = rows_.whitening.Adjoint(y_);
  const Eigen::Index width = source.column_count();
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(source.IsScan() ? 0 : width, nuisance_.size());
  for (const Stretch& some : rows_.stretches) {
    if (source.IsScan()) break;
    const Eigen::Index n = some.end - some.begin, k = rows_.own_precision[some.group].size();
    Eigen::MatrixXd vectors(n, k + common_.cols());
    vectors << own_.block(some.begin, 0, n, k), common_.middleRows(some.begin, n);
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(width, vectors.cols());
    source.AddProducts(some.begin, vectors, products);
    coefficients.middleCols(nuisance_.OffsetOf(some.group), k) += products.leftCols(k);
    coefficients.rightCols(common_.cols()) += products.rightCols(common_.cols());
  }
  nuisance_.Finish(coefficients);
  Eigen::MatrixXd with_y = Eigen::MatrixXd::Zero(width, 1);
  source.AddProducts(0, y, with_y);
  const Eigen::Index before = with_y_.size();
  with_y_.conservativeResize(before + width);
  raw_.conservativeResize(before + width);
  with_y_.tail(width) = with_y.col(0);
  std::vector<Eigen::MatrixXd> grams = source.Grams(rows_.whitening);
  Eigen::Index at = 0;
  for (size_t g = 0; g < grams.size(); ++g) {
    const Eigen::VectorXd raw = grams[g].diagonal();
    raw_.segment(before + at, raw.size()) = raw;
    Eigen::MatrixXd& gram = gram_.emplace_back(std::move(grams[g]));
    if (!source.IsScan()) {
      const auto own_coefficients = coefficients.middleRows(at, gram.rows());
      gram.noalias() -= own_coefficients * own_coefficients.transpose();
    }
    is_exact_.push_back(!source.IsScan());
    is_visible_.push_back(IsSeen(source.groups()[g], raw, gram.diagonal(), policy_.visible));
    at_.emplace_back(static_cast<int>(number), static_cast<int>(g));
    first_column_.push_back(column_count_ + at);
    at += raw.size();
  }
  column_count_ += width;
}

const Group& Scorer::group(int group) const { return sources_[at_[group].first]->groups()[at_[group].second]; }

void Scorer::Exclude(int group) {
  answers_.clear();
  is_visible_[group] = false;
  is_exact_[group] = true;  // of a scan too: nobody looks closer
}

void Scorer::AddLooks(const std::map<int, double>& looks) {
  for (const auto& [family, count] : looks) visible_members_[family] += count;
}

const Source& Scorer::SourceOf(int group, int* within) const {
  *within = at_[group].second;
  return *sources_[at_[group].first];
}

double Scorer::PriceOf(int which, double design) const {
  const Group& one = group(which);
  const auto members = visible_members_.find(one.family);
  const double looks = members == visible_members_.end() ? 1.0 : std::max(1.0, members->second);
  const double price = policy_.evidence + policy_.per_look * std::log(looks) +
                       (one.IsBlock() ? 0.0 : policy_.per_column * (one.columns - 1)) +
                       (one.is_exotic ? policy_.exotic : 0.0);
  return one.is_counted ? std::max(price, rows_.rounding_squares / design) : price;
}

double Scorer::PrecisionOf(const Group& group, int column, double raw) const {
  const double own = group.precision.size() > 0 ? group.precision[column] : 0.0;
  if (!group.has_usual_size) return own;
  return own + raw / (policy_.largest_hidden * policy_.largest_hidden * std::max(squares_, dof_));
}

Eigen::MatrixXd Scorer::Projected(int group) const {
  int within = 0;
  const Source& source = SourceOf(group, &within);
  return ProjectedOf(WhitenedOf(source, within));
}

Eigen::MatrixXd Scorer::WhitenedOf(const Source& source, int within) const {
  Eigen::MatrixXd columns = source.Columns(within);
  rows_.whitening.Apply(0, columns);
  return columns;
}

Eigen::MatrixXd Scorer::ProjectedOf(Eigen::MatrixXd columns) const {
  for (Eigen::Index c = 0; c < columns.cols(); ++c)
    columns.col(c) -= nuisance_.Explained(nuisance_.CoefficientsOf(columns.col(c)));
  return columns;
}

int Scorer::Append(std::unique_ptr<Source> source, int of) {
  const Group& moved = source->groups().front();
  const auto [known, is_new] = moved_.try_emplace({origin_[of], moved.place, moved.size}, group_count());
  if (!is_new) return known->second;
  Take(*source, sources_.size());
  origin_.push_back(origin_[of]);
  sources_.push_back(std::move(source));
  return known->second;
}

double Scorer::ObjectiveWith(const State& state, const Source& moved, int of, double design) {
  const Factor factor = FactorOf(state, design);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (!factor.is_possible) return kNone;
  const Eigen::MatrixXd whitened = WhitenedOf(moved, 0), columns = ProjectedOf(whitened);
  Eigen::MatrixXd products(factor.half.size(), columns.cols());
  for (size_t i = 0; i < state.size(); ++i) {
    const Eigen::MatrixXd& its = Load(state[i].group).columns;
    products.middleRows(factor.first[i], its.cols()) = its.transpose() * whitened;
  }
  Eigen::MatrixXd gram = whitened.transpose() * columns;
  Eigen::VectorXd right = whitened.transpose() * y_;
  if (!state.empty()) {
    factor.lower.triangularView<Eigen::Lower>().solveInPlace(products);
    gram.noalias() -= products.transpose() * products;
    right.noalias() -= products.transpose() * factor.half;
  }
  const Group& one = moved.groups().front();
  for (int c = 0; c < one.columns; ++c) {
    gram(c, c) += design * PrecisionOf(one, c, whitened.col(c).squaredNorm());
    gram(c, c) *= 1.0 + kRidge;
  }
  const Eigen::LLT<Eigen::MatrixXd> cholesky(gram);
  if (cholesky.info() != Eigen::Success) return kNone;
  const double left = factor.squares - right.dot(cholesky.solve(right));
  return dof_ / design * (LogSquares(factor.squares) + LogRatio(left, factor.squares)) + factor.log_det +
         factor.prices + PriceOf(of, design);
}

std::unique_ptr<Source> Scorer::MovedTo(int group, double place) const {
  int within = 0;
  const Source& source = SourceOf(group, &within);
  return source.Moved(within, place);
}

bool Scorer::RefinePlace(size_t member, double design, State* state) {
  const Group before = group((*state)[member].group);
  if (!(before.reach > 0.0) && !(before.size_reach > 0.0)) return false;
  // Asked for again, the same state gives the same answer.
  const auto question = [&] {
    std::vector<int> asked;
    for (const Member& one : *state) asked.push_back(one.group);
    std::sort(asked.begin(), asked.end());
    asked.insert(asked.begin(), (*state)[member].group);
    return asked;
  };
  if (at_best_.contains(question())) return false;
  bool any = false;
  constexpr int kRounds = 2;  // a place that comes with another size
  for (int round = 0; round < kRounds; ++round) {
    bool is_moved = false;
    const auto moved = [this](int of, double place) { return MovedTo(of, place); };
    const auto resized = [this](int of, double size) {
      int within = 0;
      const Source& source = SourceOf(of, &within);
      return source.Resized(within, size);
    };
    if (before.reach > 0.0)
      is_moved = RefineAlong(member, design, group((*state)[member].group).place, before.reach, moved, state);
    if (before.size_reach > 0.0)
      is_moved |= RefineAlong(member, design, group((*state)[member].group).size, before.size_reach, resized, state);
    any |= is_moved;
    if (!is_moved || !(before.size_reach > 0.0)) break;
  }
  at_best_.insert(question());
  return any;
}

// Golden section search: within the reach the objective has one minimum, or the grid is too coarse.
template <typename Make>
bool Scorer::RefineAlong(size_t member, double design, double middle, double reach, Make make, State* state) {
  const int of = (*state)[member].group;
  State others = *state;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(member));
  const auto objective_at = [&](double place) {
    const std::unique_ptr<Source> moved = make(of, place);
    return moved == nullptr ? std::numeric_limits<double>::infinity() : ObjectiveWith(others, *moved, of, design);
  };
  constexpr double kGolden = 0.618033988749895, kNarrow = 4e-3;  // share of the reach: the full fit finds the rest
  double low = middle - reach, high = middle + reach;
  double inner = high - kGolden * (high - low), outer = low + kGolden * (high - low);
  double at_inner = objective_at(inner), at_outer = objective_at(outer);
  while (high - low > kNarrow * reach) {
    if (at_inner < at_outer) {
      high = outer;
      outer = inner;
      at_outer = at_inner;
      inner = high - kGolden * (high - low);
      at_inner = objective_at(inner);
    } else {
      low = inner;
      inner = outer;
      at_inner = at_outer;
      outer = low + kGolden * (high - low);
      at_outer = objective_at(outer);
    }
  }
  // On a grid of its own: what is found again is the same group.
  const double step = kNarrow * reach, place = step * std::round(0.5 * (low + high) / step);
  constexpr double kGain = 0.1;  // chi-square units: less is no reason for one more group
  if (!(objective_at(place) < ScoreOf(*state, design).objective - kGain)) return false;
  (*state)[member].group = Append(make(of, place), of);
  return true;
}

void Scorer::MakeExact(int which) {
  if (is_exact_[which]) return;
  int within = 0;
  Eigen::MatrixXd columns = SourceOf(which, &within).Columns(within);
  rows_.whitening.Apply(0, columns);
  const Eigen::VectorXd raw = columns.colwise().squaredNorm().transpose();
  Eigen::MatrixXd coefficients(nuisance_.size(), columns.cols());
  for (Eigen::Index c = 0; c < columns.cols(); ++c) coefficients.col(c) = nuisance_.CoefficientsOf(columns.col(c));
  gram_[which].noalias() = columns.transpose() * columns;
  gram_[which].noalias() -= coefficients.transpose() * coefficients;
  with_y_.segment(first_column_[which], columns.cols()) = columns.transpose() * y_;
  is_exact_[which] = true;
  is_visible_[which] = IsSeen(group(which), raw, gram_[which].diagonal(), policy_.visible);
}

const Scorer::Loaded& Scorer::Load(int group) {
  MakeExact(group);
  const auto [place, is_new] = loaded_.try_emplace(group);
  Loaded& loaded = place->second;
  if (!is_new) return loaded;
  int within = 0;
  const Source& source = SourceOf(group, &within);
  loaded.whitened = WhitenedOf(source, within);
  loaded.columns = ProjectedOf(loaded.whitened);
  return loaded;
}

const Eigen::MatrixXd& Scorer::Cross(int group, int other) {
  const auto [place, is_new] = cross_.try_emplace({group, other});
  // Projected at the rows times not projected: the rows of the priors, where the latter is zero, are not needed.
  if (is_new) place->second = Load(group).whitened.transpose() * Load(other).columns;
  return place->second;
}

void Scorer::LoadProducts(const State& state) {
  std::vector<Loaded*> missing, short_of;
  Eigen::Index width = 0, fewest = column_count_;
  for (const Member& member : state) {
    Load(member.group);
    Loaded& loaded = loaded_[member.group];
    if (loaded.products.size() == 0) {
      missing.push_back(&loaded);
      width += loaded.columns.cols();
    } else if (loaded.products.rows() < column_count_) {
      short_of.push_back(&loaded);
      fewest = std::min(fewest, loaded.products.rows());
    }
  }
  if (!short_of.empty()) {  // of groups that were appended since
    std::vector<Eigen::Index> had;
    for (Loaded* one : short_of) {
      had.push_back(one->products.rows());
      one->products.conservativeResize(column_count_, Eigen::NoChange);
    }
    Eigen::Index first = column_count_;
    for (size_t s = sources_.size(); s-- > 0;) {
      const Eigen::Index count = sources_[s]->column_count();
      first -= count;
      if (first < fewest) break;
      const Eigen::MatrixXd columns = WhitenedOf(*sources_[s], 0);
      for (size_t k = 0; k < short_of.size(); ++k)
        if (first >= had[k])
          short_of[k]->products.middleRows(first, count) = columns.transpose() * short_of[k]->columns;
    }
  }
  if (missing.empty()) return;
  Eigen::MatrixXd vectors(rows_.count(), width), products = Eigen::MatrixXd::Zero(column_count_, width);
  Eigen::Index at = 0;
  for (const Loaded* one : missing) {
    vectors.middleCols(at, one->columns.cols()) = one->columns;
    at += one->columns.cols();
  }
  vectors = rows_.whitening.Adjoint(std::move(vectors));
  Eigen::Index first = 0;
  for (const std::unique_ptr<Source>& source : sources_) {
    const Eigen::Index count = source->column_count();
    source->AddProducts(0, vectors, products.middleRows(first, count));
    first += count;
  }
  at = 0;
  for (Loaded* one : missing) {
    one->products = products.middleCols(at, one->columns.cols());
    at += one->columns.cols();
  }
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
    Load(state[i].group);
    gram.block(factor.first[i], factor.first[i], one.columns, one.columns) = gram_[state[i].group];
    for (size_t k = 0; k < i; ++k) {
      const Group& other = group(state[k].group);
      const bool is_ordered = state[i].group < state[k].group;
      const Eigen::MatrixXd& cross =
          is_ordered ? Cross(state[i].group, state[k].group) : Cross(state[k].group, state[i].group);
      auto block = gram.block(factor.first[i], factor.first[k], one.columns, other.columns);
      block = is_ordered ? cross : Eigen::MatrixXd(cross.transpose());
      gram.block(factor.first[k], factor.first[i], other.columns, one.columns) = block.transpose();
    }
    right.segment(factor.first[i], one.columns) = with_y_.segment(first_column_[state[i].group], one.columns);
    for (int c = 0; c < one.columns; ++c) {
      double& own = gram(factor.first[i] + c, factor.first[i] + c);
      if (one.IsBlock()) {
        const double variance = state[i].variance * one.spectrum[c];
        own += design / variance;
        factor.log_det += std::log(variance / design);
      } else {
        own += kRidge * own + design * PrecisionOf(one, c, raw_[first_column_[state[i].group] + c]);
      }
    }
    factor.prices += PriceOf(state[i].group, design);
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
  score.objective = dof_ / design * LogSquares(factor.squares) + factor.log_det + factor.prices;
  const Eigen::VectorXd amplitudes = factor.lower.triangularView<Eigen::Lower>().transpose().solve(factor.half);
  for (size_t i = 0; i < state.size(); ++i) {
    const Group& one = group(state[i].group);
    score.amplitude.emplace_back(amplitudes.segment(factor.first[i], one.columns));
    if (score.amplitude.back().cwiseAbs().maxCoeff() > one.largest_amplitude) score.is_possible = false;
    for (size_t j = 0; one.one_sign >= 0 && j < i; ++j) {
      if (group(state[j].group).one_sign == one.one_sign && score.amplitude[j][0] * score.amplitude[i][0] < 0.0)
        score.is_possible = false;
    }
  }
  if (!score.is_possible) score.objective = std::numeric_limits<double>::infinity();
  return score;
}

std::vector<Eigen::VectorXd> Scorer::VariancesOf(const State& state, double design) {
  const Factor factor = FactorOf(state, design);
  const Eigen::Index n = factor.lower.rows();
  const Eigen::MatrixXd inverse = factor.lower.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::VectorXd variance = design * factor.squares / dof_ * inverse.colwise().squaredNorm().transpose();
  std::vector<Eigen::VectorXd> out;
  for (size_t i = 0; i < state.size(); ++i)
    out.emplace_back(variance.segment(factor.first[i], group(state[i].group).columns));
  return out;
}

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
// B with B' B = W' V^-1 W, W the rows of some columns in K^-1 P and V their part of K^-1: what K^-1 explains by them
// beyond what it explains without them.
std::optional<Eigen::MatrixXd> BackOf(const Eigen::MatrixXd& inverse, const Eigen::MatrixXd& weights,
                                      Eigen::Index first, Eigen::Index count) {
  const Eigen::LLT<Eigen::MatrixXd> own(inverse.block(first, first, count, count));
  if (own.info() != Eigen::Success) return std::nullopt;  // rounding
  Eigen::MatrixXd back = weights.middleRows(first, count);
  own.matrixL().solveInPlace(back);
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
      std::optional<Eigen::MatrixXd> back = BackOf(ground_->inverse, ground_->weights, first, count), flat_back;
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
  for (size_t i = 0; !is_known && i < state.size(); ++i) {
    const Eigen::MatrixXd& products = Load(state[i].group).products;
    out.half.middleRows(factor.first[i], products.cols()) = products.transpose();
  }
  if (!is_known && !state.empty()) factor.lower.triangularView<Eigen::Lower>().solveInPlace(out.half);
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
  ground.weights = lower.transpose().solve(whole.half);
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

void Scorer::RefineVariances(double design, State* state) {
  for (size_t i = 0; i < state->size(); ++i) {
    const int block = (*state)[i].group;
    if (!group(block).IsBlock()) continue;
    State others = *state;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const Factor factor = FactorOf(others, design);
    if (!factor.is_possible) continue;
    Load(block);
    Eigen::MatrixXd gram = gram_[block], half(factor.half.size(), gram.cols());
    Eigen::VectorXd right = with_y_.segment(first_column_[block], gram.cols());
    if (!others.empty()) {
      for (size_t k = 0; k < others.size(); ++k) {
        const int other = others[k].group;
        half.middleRows(factor.first[k], group(other).columns) =
            other < block ? Cross(other, block) : Eigen::MatrixXd(Cross(block, other).transpose());
      }
      factor.lower.triangularView<Eigen::Lower>().solveInPlace(half);
      gram.noalias() -= half.transpose() * half;
      right.noalias() -= half.transpose() * factor.half;
    }
    const Move best = BestBlock(block, gram, right, factor.squares, design);
    if (best.member.variance > 0.0) (*state)[i].variance = best.member.variance;
  }
}

Eigen::VectorXd Scorer::ResidualOf(const State& state, double design) {
  const Score score = ScoreOf(state, design);
  Eigen::VectorXd residual = y_;
  for (size_t i = 0; i < score.amplitude.size(); ++i) residual -= Load(state[i].group).columns * score.amplitude[i];
  return residual;
}

}  // namespace axiscal::objective
