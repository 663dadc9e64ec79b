#include "core/objective/scorer.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/objective/scorer_factor.h"

namespace axiscal::objective {

namespace {

// A share of rss that is left at most: rounding.
constexpr double kLeft = 1e-12;

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
