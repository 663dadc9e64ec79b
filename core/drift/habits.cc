#include "core/drift/habits.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace axiscal::drift {
namespace {

constexpr int kLeastSeen = 26;             // calibrations of an error before anything is said of its habits
constexpr double kTwoCyclesWeeks = 104.4;  // a season that was seen once may be wear
constexpr double kWeeksPerYear = 52.1775;
constexpr double kSeasonVariance = 0.25;  // prior of sine, cosine and per 3 K (core/drift/errors_of_state.cc)
constexpr double kUsualKelvin = 3.0;      // core/drift/joint_filter.cc
constexpr double kSeasonOdds = 3.0, kSeasonOver = 0.0;  // ln of the odds at which a season is said, and over
constexpr double kWearing = 0.97, kWearingOver = 0.80;  // probability of one way at which wear is said, and over
constexpr double kNoisy = 1.5, kNoisyOver = 1.3;        // times what is stated
constexpr double kQuiet = 0.6, kQuietOver = 0.7;

struct Wear {
  double per_week = 0.0, sigma = 0.0, one_way = 0.0;
};

Wear WearOf(const Outlook& outlook) {
  const ModelWeights weights = WeightsOf(outlook, FlatPrior());
  double mean = 0.0, square = 0.0, up = 0.0, down = 0.0;
  for (int k = 0; k < kModels; ++k) {
    if (kSlopeSizes[SlopeIndex(k)] == 0.0) continue;
    const OutlookModel& model = outlook.models[k];
    const double variance = ScaleOf(outlook, k) * std::max(1e-12, model.covariance[2]);
    mean += weights[k] * model.mean[1];
    square += weights[k] * (variance + model.mean[1] * model.mean[1]);
    const double share_up = 0.5 * std::erfc(-model.mean[1] / std::sqrt(2.0 * variance));
    up += weights[k] * share_up;
    down += weights[k] * (1.0 - share_up);
  }
  return {mean, std::sqrt(std::max(0.0, square - mean * mean)), std::max(up, down)};
}

// ln of the odds for a season of error j against none, by the densities at 0 before and after (Savage and Dickey).
double SeasonOdds(const State& state, int j, bool has_temperature) {
  const int n = state.joint.count(), parts = has_temperature ? 3 : 2;
  Eigen::VectorXd mean(parts);
  Eigen::MatrixXd covariance(parts, parts);
  for (int a = 0; a < parts; ++a) {
    mean(a) = state.joint.mean((a + 1) * n + j);
    for (int b = 0; b < parts; ++b) covariance(a, b) = state.joint.covariance((a + 1) * n + j, (b + 1) * n + j);
  }
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  double log_determinant = 0.0;
  for (int a = 0; a < parts; ++a)
    log_determinant += 2.0 * std::log(root.matrixLLT()(a, a) / std::sqrt(kSeasonVariance));
  return 0.5 * log_determinant + 0.5 * mean.dot(root.solve(mean)) - std::log(static_cast<double>(n));
}

void TellSeason(int j, State* state, std::vector<Finding>* findings) {
  Followed& followed = state->errors[j];
  const int n = state->joint.count();
  if (WeeksBetween(followed.first_seen, state->last_at) < kTwoCyclesWeeks || followed.seen < kLeastSeen) return;
  const bool has_temperature = state->joint.covariance(3 * n + j, 3 * n + j) < 0.9 * kSeasonVariance;
  const double odds = SeasonOdds(*state, j, has_temperature);
  if (followed.is_seasonal ? odds >= kSeasonOver : odds <= kSeasonOdds) return;
  followed.is_seasonal = !followed.is_seasonal;
  const double sine = state->joint.mean(n + j), cosine = state->joint.mean(2 * n + j);
  const double amplitude = std::hypot(sine, cosine);
  const double variance = amplitude > 0.0 ? (sine * sine * state->joint.covariance(n + j, n + j) +
                                             cosine * cosine * state->joint.covariance(2 * n + j, 2 * n + j) +
                                             2.0 * sine * cosine * state->joint.covariance(n + j, 2 * n + j)) /
                                                (amplitude * amplitude)
                                          : state->joint.covariance(n + j, n + j);
  Season season{.at = state->last_at, .is_over = !followed.is_seasonal};
  season.amplitude = {followed.symbol, followed.unit, amplitude * followed.unit_size,
                      std::sqrt(std::max(0.0, variance)) * followed.unit_size};
  if (has_temperature) {
    const double per_kelvin = followed.unit_size / kUsualKelvin;
    season.per_kelvin = Amount{followed.symbol, followed.unit, state->joint.mean(3 * n + j) * per_kelvin,
                               std::sqrt(state->joint.covariance(3 * n + j, 3 * n + j)) * per_kelvin};
  }
  season.certainty = 1.0 / (1.0 + std::exp(-odds));
  findings->push_back(season);
}

void TellWear(int j, State* state, std::vector<Finding>* findings) {
  Followed& followed = state->errors[j];
  if (followed.outlook.count < kLeastSeen) return;
  const Wear wear = WearOf(followed.outlook);
  if (followed.is_wearing ? wear.one_way >= kWearingOver : wear.one_way <= kWearing) return;
  followed.is_wearing = !followed.is_wearing;
  const double per_year = kWeeksPerYear * followed.unit_size;
  findings->push_back(
      Slope{.at = state->last_at,
            .is_over = !followed.is_wearing,
            .per_year = {followed.symbol, followed.unit, wear.per_week * per_year, wear.sigma * per_year},
            .certainty = wear.one_way});
}

void TellNoise(int j, const Scales& scales, State* state, std::vector<Finding>* findings) {
  Followed& followed = state->errors[j];
  if (followed.bank.count < kLeastSeen) return;
  const double factor = std::sqrt(scales.each(j));
  const bool is_noisy =
      followed.is_noisy ? factor > kNoisyOver || factor < kQuietOver : factor > kNoisy || factor < kQuiet;
  if (is_noisy == followed.is_noisy) return;
  followed.is_noisy = is_noisy;
  findings->push_back(Noise{state->last_at, !is_noisy, followed.symbol, factor});
}

}  // namespace

void AbsorbInto(const Past& past, int j, base::UtcTime first_at, Outlook* outlook) {
  if (past.loosened(j) > 0.0) LoosenLevel(past.loosened(j), past.is_wear_new, outlook);
  if (past.suspicion(j) > 0.0 || !std::binary_search(past.seen.begin(), past.seen.end(), j)) return;
  Absorb(WeeksBetween(first_at, past.at), past.regressors, past.y(j), past.stated(j, j), outlook);
}

std::vector<Finding> TellHabits(const Scales& scales, State* state) {
  std::vector<Finding> findings;
  for (int j = 0; j < static_cast<int>(state->errors.size()); ++j) {
    TellWear(j, state, &findings);
    TellSeason(j, state, &findings);
    TellNoise(j, scales, state, &findings);
  }
  return findings;
}

}  // namespace axiscal::drift
