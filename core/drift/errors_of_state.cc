#include "core/drift/errors_of_state.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace axiscal::drift {
namespace {

constexpr double kUnknownLevel = 1e4;      // (100 sigma)^2: what is known of a new error beside its first value
constexpr double kSeasonVariance = 0.25;   // (sigma / 2)^2 of sine, cosine and per 3 K
constexpr double kStatedTwice = 4.0;       // a stated variance may be too small by this
constexpr double kForgottenWeeks = 104.0;  // not seen for two years: a machine was rebuilt, or is measured otherwise
constexpr double kMostUnknown =
    100.0;                  // a direction less known than 10 times what single errors are known to makes no unit
constexpr int kYoung = 16;  // values of an outlook
constexpr double kAnotherUnit = 1.5;  // stated sigmas that differ by less are one unit

int Find(const State& state, const std::string& symbol) {
  for (size_t j = 0; j < state.errors.size(); ++j) {
    if (state.errors[j].symbol == symbol) return static_cast<int>(j);
  }
  return -1;
}

// Rows of a vector of `parts` times n numbers moved: new j is old from[j], or `fresh` where that is -1.
Eigen::VectorXd Moved(const Eigen::VectorXd& old, const std::vector<int>& from, int parts, double fresh) {
  const auto n = static_cast<int>(from.size());
  const auto old_n = static_cast<int>(old.size()) / parts;
  Eigen::VectorXd moved = Eigen::VectorXd::Constant(parts * n, fresh);
  for (int part = 0; part < parts; ++part) {
    for (int j = 0; j < n; ++j) {
      if (from[j] >= 0) moved(part * n + j) = old(part * old_n + from[j]);
    }
  }
  return moved;
}

Eigen::MatrixXd Moved(const Eigen::MatrixXd& old, const std::vector<int>& from, int parts) {
  const auto n = static_cast<int>(from.size());
  const auto old_n = static_cast<int>(old.rows()) / parts;
  Eigen::MatrixXd moved = Eigen::MatrixXd::Zero(parts * n, parts * n);
  for (int column = 0; column < parts * n; ++column) {
    if (from[column % n] < 0) continue;
    for (int row = 0; row < parts * n; ++row) {
      if (from[row % n] < 0) continue;
      moved(row, column) = old(row / n * old_n + from[row % n], column / n * old_n + from[column % n]);
    }
  }
  return moved;
}

void Move(const std::vector<int>& from, Joint* joint) {
  joint->mean = Moved(joint->mean, from, kParts, 0.0);
  joint->covariance = Moved(joint->covariance, from, kParts);
}

// `from`: as above. What is new has no variance yet.
void Move(const std::vector<int>& from, State* state) {
  Move(from, &state->joint);
  state->mark_loosens = Moved(state->mark_loosens, from, 1, 0.0);
  state->told.sizes = Moved(state->told.sizes, from, 1, 0.0);
  state->told.variances = Moved(state->told.variances, from, 1, 0.0);
  std::vector<int> to(state->errors.size(), -1);
  for (size_t j = 0; j < from.size(); ++j) {
    if (from[j] >= 0) to[from[j]] = static_cast<int>(j);
  }
  for (Past& past : state->last) {
    Move(from, &past.before);
    past.y = Moved(past.y, from, 1, 0.0);
    past.stated = Moved(past.stated, from, 1);
    past.suspicion = Moved(past.suspicion, from, 1, 0.0);
    past.loosened = Moved(past.loosened, from, 1, 0.0);
    std::vector<int> seen;
    for (const int j : past.seen) {
      if (to[j] >= 0) seen.push_back(to[j]);
    }
    past.seen = std::move(seen);
  }
  // A calibration of which no error is followed any more.
  std::erase_if(state->last, [](const Past& past) { return past.seen.empty(); });
}

// The places to keep: all but those long not seen, and the longest unseen where there would be too many.
std::vector<int> Kept(const Calibration& calibration, const State& state, int added) {
  const auto is_here = [&](int j) {
    return std::any_of(calibration.values.begin(), calibration.values.end(),
                       [&](const Value& value) { return value.symbol == state.errors[j].symbol; });
  };
  std::vector<int> kept;
  for (int j = 0; j < static_cast<int>(state.errors.size()); ++j) {
    if (is_here(j) || WeeksBetween(state.errors[j].last_seen, calibration.at) < kForgottenWeeks) kept.push_back(j);
  }
  // A calibration has no more errors than may be kept: those that it holds are never in the way.
  while (static_cast<int>(kept.size()) + added > kMostErrors) {
    kept.erase(std::min_element(kept.begin(), kept.end(), [&](int a, int b) {
      return std::pair(is_here(a), state.errors[a].last_seen) < std::pair(is_here(b), state.errors[b].last_seen);
    }));
  }
  return kept;
}

void Scale(int j, double factor, Joint* joint) {
  const int n = joint->count();
  for (int part = 0; part < kParts; ++part) {
    joint->mean(part * n + j) /= factor;
    joint->covariance.row(part * n + j) /= factor;
    joint->covariance.col(part * n + j) /= factor;
  }
}

// What is not known yet of error j's season is as large as the prior of the unit that it is counted in now; it has been
// the prior of a larger one. What the level leaned on it is uncertain then.
void LimitSeason(int j, Joint* joint) {
  const int n = joint->count();
  for (int part = 1; part < kParts; ++part) {
    const int at = part * n + j;
    if (joint->covariance(at, at) <= kSeasonVariance) continue;
    const double share = std::sqrt(kSeasonVariance / joint->covariance(at, at));
    const double lost = (1.0 - share) * joint->mean(at);
    joint->mean(at) *= share;
    joint->covariance.row(at) *= share;
    joint->covariance.col(at) *= share;
    joint->covariance(j, j) += lost * lost;
  }
}

// Error j is counted in a unit `factor` times as large.
void Rescale(int j, double factor, State* state) {
  Followed& followed = state->errors[j];
  followed.unit_size *= factor;
  for (double& mean : followed.bank.mean) mean /= factor;
  for (double& variance : followed.bank.variance) variance /= factor * factor;
  drift::Rescale(factor, &followed.outlook);
  // Slopes and seasons of its models have been those of the other unit; of a young one nothing is lost by a new start.
  if (followed.outlook.count < kYoung)
    followed.outlook = StartOutlook(followed.outlook.week, followed.outlook.models[0].mean[0], kUnknownLevel);
  state->told.sizes(j) /= factor;
  state->told.variances(j) /= factor * factor;
  Scale(j, factor, &state->joint);
  LimitSeason(j, &state->joint);
  for (Past& past : state->last) {
    Scale(j, factor, &past.before);
    LimitSeason(j, &past.before);
    past.y(j) /= factor;
    past.stated.row(j) /= factor;
    past.stated.col(j) /= factor;
  }
}

// Stated sigmas, but for what only a badly known combination adds to them: it would make a unit in which nothing that
// can be told is large.
Eigen::VectorXd UsualSigmas(const Eigen::MatrixXd& stated) {
  const auto n = stated.rows();
  Eigen::MatrixXd covariance = 0.5 * (stated + stated.transpose());
  covariance.diagonal() *= 1.0 + 1e-9;
  const Eigen::VectorXd stated_sigmas = covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation =
      stated_sigmas.cwiseInverse().asDiagonal() * covariance * stated_sigmas.cwiseInverse().asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> root(correlation);
  if (root.info() != Eigen::Success) return stated_sigmas;
  // Of each error where all others are known.
  const Eigen::VectorXd alone = root.solve(Eigen::MatrixXd::Identity(n, n)).diagonal().cwiseSqrt().cwiseInverse();
  if (alone.minCoeff() * alone.minCoeff() * kMostUnknown >= 1.0) return stated_sigmas;
  const Eigen::MatrixXd scaled = alone.cwiseInverse().asDiagonal() * correlation * alone.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(0.0).cwiseMin(kMostUnknown);
  const Eigen::VectorXd limited = (eigen.eigenvectors().cwiseAbs2() * values).cwiseSqrt();
  return stated_sigmas.cwiseProduct(alone).cwiseProduct(limited);
}

double UnitSize(const Followed& followed) {
  std::vector<double> sorted = followed.stated_sigmas;
  std::sort(sorted.begin(), sorted.end());
  return sorted[(sorted.size() - 1) / 4];
}

}  // namespace

std::vector<int> Follow(const Calibration& calibration, State* state) {
  std::vector<const Value*> added;
  for (const Value& value : calibration.values) {
    if (Find(*state, value.symbol) < 0) added.push_back(&value);
  }
  std::vector<int> from = Kept(calibration, *state, static_cast<int>(added.size()));
  if (!added.empty() || from.size() != state->errors.size()) {
    std::vector<Followed> errors;
    for (const int j : from) errors.push_back(std::move(state->errors[j]));
    for (const Value* value : added) {
      errors.push_back({.symbol = value->symbol,
                        .unit = value->unit,
                        .first_seen = calibration.at,
                        .last_seen = calibration.at,
                        .bank_at = calibration.at});
      from.push_back(-1);
    }
    Move(from, state);
    state->errors = std::move(errors);
  }
  const auto n = static_cast<int>(state->errors.size());
  const Eigen::VectorXd sigmas = UsualSigmas(calibration.covariance);
  std::vector<int> places;
  for (size_t i = 0; i < calibration.values.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const int j = Find(*state, calibration.values[i].symbol);
    places.push_back(j);
    Followed& followed = state->errors[j];
    followed.stated_sigmas.push_back(sigmas(at));
    if (followed.stated_sigmas.size() > kMostSigmas) followed.stated_sigmas.erase(followed.stated_sigmas.begin());
    if (followed.seen == 0) followed.unit_size = UnitSize(followed);
    const double factor = UnitSize(followed) / followed.unit_size;
    if (factor > kAnotherUnit || factor < 1.0 / kAnotherUnit) Rescale(j, factor, state);
  }
  // What is new starts at its first value. A combination that this calibration could not tell stays as unknown as that.
  for (size_t i = 0; i < places.size(); ++i) {
    Followed& followed = state->errors[places[i]];
    if (followed.seen > 0) continue;
    const int j = places[i];
    const double level = calibration.values[i].value / followed.unit_size;
    Restart(level, &followed.bank);
    const auto start = [&](Joint* joint) {
      joint->mean(j) = level;
      joint->covariance(j, j) = kUnknownLevel;
      for (int part = 1; part < kParts; ++part) joint->covariance(part * n + j, part * n + j) = kSeasonVariance;
      for (size_t k = 0; k < places.size(); ++k) {
        const Followed& other = state->errors[places[k]];
        if (other.seen > 0) continue;
        joint->covariance(j, places[k]) +=
            kStatedTwice * calibration.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) /
            (followed.unit_size * other.unit_size);
      }
    };
    start(&state->joint);
    for (Past& past : state->last) start(&past.before);
    followed.outlook = StartOutlook(WeeksBetween(state->first_at, calibration.at), level, kUnknownLevel);
  }
  for (const int j : places) {
    state->errors[j].last_seen = calibration.at;
    ++state->errors[j].seen;
  }
  return places;
}

}  // namespace axiscal::drift
