#include "core/drift/forecast.h"

#include <absl/strings/str_cat.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "core/drift/habits.h"
#include "core/drift/student.h"

namespace axiscal::drift {
namespace {

constexpr double kGroupShare = 0.8;
constexpr int kLeastToForetell = 3;  // values from which anything can be foretold
constexpr int kLeastOfGroup = 10;    // values of an error that tell something of its group
constexpr int kLeastForDates = 52;   // before, no two-sided interval of a date exists
constexpr int kDraws = 1000;
constexpr int kHorizonWeeks = 261;  // five years
constexpr int kYearWeeks = 52;

struct Known {
  Outlook outlook;
  ModelWeights weights;
  double unit_size = 1.0;
  Unit unit = Unit::kUm;
  double noise = 1.0;  // stated variance of a usual calibration
};

absl::StatusOr<int> PlaceOf(const State& state, const std::string& symbol) {
  for (size_t j = 0; j < state.errors.size(); ++j) {
    if (state.errors[j].symbol != symbol) continue;
    if (state.errors[j].seen < kLeastToForetell)
      return absl::FailedPreconditionError(absl::StrCat(symbol, " was seen in ", state.errors[j].seen,
                                                        " calibrations, a forecast needs ", kLeastToForetell));
    return static_cast<int>(j);
  }
  return absl::NotFoundError(absl::StrCat("error '", symbol, "' is not in the machine's history"));
}

absl::StatusOr<Known> KnownOf(const State& state, const std::string& symbol, const ForecastOptions& options) {
  if (!(options.coverage > 0.0 && options.coverage < 1.0))
    return absl::InvalidArgumentError(absl::StrCat("coverage = ", options.coverage, ", must be > 0 and < 1"));
  ASSIGN_OR_RETURN(const int j, PlaceOf(state, symbol));
  Outlook outlook = state.errors[j].outlook;
  for (const Past& past : state.last) AbsorbInto(past, j, state.first_at, &outlook);
  Known known{outlook, {}, state.errors[j].unit_size, state.errors[j].unit};
  known.weights = WeightsOf(known.outlook, options.prior ? *options.prior : FlatPrior());
  return known;
}

// A mixture of Student distributions with one number of degrees of freedom.
struct Mixture {
  std::array<double, kModels> weight, mean, sigma;
  double freedom = 1.0;

  double ShareBelow(double x) const {
    double share = 0.0;
    for (int k = 0; k < kModels; ++k) {
      if (weight[k] > 1e-9) share += weight[k] * StudentBelow((x - mean[k]) / sigma[k], freedom);
    }
    return share;
  }
  double Quantile(double share) const {
    double low = INFINITY, high = -INFINITY;
    for (int k = 0; k < kModels; ++k) {
      if (weight[k] <= 1e-9) continue;
      low = std::min(low, mean[k] - 50.0 * sigma[k]);
      high = std::max(high, mean[k] + 50.0 * sigma[k]);
    }
    for (int i = 0; i < 50; ++i) {
      const double middle = 0.5 * (low + high);
      (ShareBelow(middle) < share ? low : high) = middle;
    }
    return 0.5 * (low + high);
  }
};

Mixture MixtureAt(const Known& known, double weeks, const Regressors& at, double noise) {
  Mixture mixture;
  mixture.freedom = FreedomOf(known.outlook);
  for (int k = 0; k < kModels; ++k) {
    const Ahead ahead = LookAhead(known.outlook, k, weeks, at);
    mixture.weight[k] = known.weights[k];
    mixture.mean[k] = ahead.mean;
    mixture.sigma[k] = std::sqrt(std::max(1e-12, ScaleOf(known.outlook, k) * (ahead.variance + noise)));
  }
  return mixture;
}

// Level, slope, sine and cosine as one model knows them.
struct Course {
  double level, slope, sine, cosine, wander;  // wander: sigma per root of a week
};

class Courses {
 public:
  explicit Courses(const Known& known) : known_(known) {
    for (int k = 0; k < kModels; ++k) {
      const OutlookModel& model = known.outlook.models[k];
      Eigen::Matrix4d covariance;
      for (int i = 0, at = 0; i < 4; ++i) {
        for (int j = 0; j <= i; ++j, ++at) covariance(i, j) = covariance(j, i) = model.covariance[at];
      }
      // Models without slope or season have zeros there.
      roots_[k] = Eigen::LLT<Eigen::Matrix4d>(covariance + 1e-9 * Eigen::Matrix4d::Identity()).matrixL();
    }
  }

  // The draw `share` of all, 0 .. 1: models come in the order of their weights.
  Course Draw(double share, base::Random& random) const {
    int k = 0;
    for (; k + 1 < kModels && share >= known_.weights[k]; ++k) share -= known_.weights[k];
    const double scale = std::sqrt(ScaleOf(known_.outlook, k) / Chi2OverFreedom(random));
    Eigen::Vector4d normal;
    for (double& one : normal) one = random.Normal();
    const Eigen::Vector4d off = scale * (roots_[k] * normal);
    const std::array<double, 4>& mean = known_.outlook.models[k].mean;
    return {mean[0] + off(0), mean[1] + off(1), mean[2] + off(2), mean[3] + off(3),
            scale * kOutlookRates[RateIndex(k)]};
  }

 private:
  double Chi2OverFreedom(base::Random& random) const {
    // Wilson and Hilferty: the cube root is nearly normal; freedom is 12 at least.
    const double share = 2.0 / (9.0 * FreedomOf(known_.outlook));
    const double root = std::max(0.1, 1.0 - share + std::sqrt(share) * random.Normal());
    return root * root * root;
  }
  const Known& known_;
  std::array<Eigen::Matrix4d, kModels> roots_;
};

base::UtcTime WeeksAfter(base::UtcTime at, int weeks) { return at + std::chrono::days(7 * weeks); }

}  // namespace

GroupPrior PriorOfGroup(const std::vector<const State*>& machines) {
  GroupPrior sum{};
  double count = 0.0;
  for (const State* machine : machines) {
    for (int j = 0; j < static_cast<int>(machine->errors.size()); ++j) {
      if (machine->errors[j].outlook.count < kLeastOfGroup) continue;
      const ModelWeights weights = WeightsOf(machine->errors[j].outlook, FlatPrior());
      for (int k = 0; k < kModels; ++k) sum[k] += weights[k];
      count += 1.0;
    }
  }
  if (count == 0.0) return FlatPrior();
  for (int k = 0; k < kModels; ++k) sum[k] = kGroupShare * sum[k] / count + (1.0 - kGroupShare) * FlatPrior()[k];
  return sum;
}

absl::StatusOr<Forecast> ForecastOf(const State& state, const std::string& symbol, base::UtcTime at,
                                    const ForecastOptions& options) {
  ASSIGN_OR_RETURN(const Known known, KnownOf(state, symbol, options));
  if (at < state.last_at)
    return absl::FailedPreconditionError(absl::StrCat("forecast for ", base::ToUtcUs(at),
                                                      " us UTC: must not be before the last calibration, of ",
                                                      base::ToUtcUs(state.last_at), " us UTC"));
  const double weeks = WeeksBetween(state.first_at, at) - known.outlook.week;
  const Regressors regressors = RegressorsAt(at, std::nullopt);
  const Mixture itself = MixtureAt(known, weeks, regressors, 0.0);
  const Mixture measured = MixtureAt(known, weeks, regressors, known.noise);
  const double tail = 0.5 * (1.0 - options.coverage);
  Forecast forecast{.at = at, .unit = known.unit};
  forecast.value = known.unit_size * itself.Quantile(0.5);
  forecast.low = known.unit_size * itself.Quantile(tail);
  forecast.high = known.unit_size * itself.Quantile(1.0 - tail);
  forecast.measured_low = known.unit_size * measured.Quantile(tail);
  forecast.measured_high = known.unit_size * measured.Quantile(1.0 - tail);
  return forecast;
}

absl::StatusOr<Crossing> CrossingOf(const State& state, const std::string& symbol, const Limits& limits,
                                    const ForecastOptions& options) {
  if (!(limits.low < limits.high))
    return absl::InvalidArgumentError(
        absl::StrCat("limits ", limits.low, " .. ", limits.high, ", expected the lower one first"));
  ASSIGN_OR_RETURN(const Known known, KnownOf(state, symbol, options));
  const double low = limits.low / known.unit_size, high = limits.high / known.unit_size;
  const Courses courses(known);
  // Courses start at the error's last value; what is foretold, at the machine's last calibration.
  const double unseen = WeeksBetween(state.first_at, state.last_at) - known.outlook.week;
  const bool has_dates = known.outlook.count >= kLeastForDates;
  const int horizon = has_dates ? kHorizonWeeks : kYearWeeks;
  std::vector<Regressors> regressors;
  for (int week = 0; week <= horizon; ++week)
    regressors.push_back(RegressorsAt(WeeksAfter(state.last_at, week), std::nullopt));
  base::Random random(1);
  std::vector<int> crossed(horizon + 1, 0);  // draws that are outside for the first time in this week
  for (int draw = 0; draw < kDraws; ++draw) {
    const Course course = courses.Draw((draw + 0.5) / kDraws, random);
    double level = course.level + course.slope * unseen + course.wander * std::sqrt(unseen) * random.Normal();
    for (int week = 0; week <= horizon; ++week) {
      if (week > 0) level += course.slope + (course.wander > 0.0 ? course.wander * random.Normal() : 0.0);
      const double value = level + course.sine * regressors[week][1] + course.cosine * regressors[week][2];
      if (value >= low && value <= high) continue;
      ++crossed[week];
      break;
    }
  }
  Crossing crossing;
  crossing.probability_now = static_cast<double>(crossed[0]) / kDraws;
  const double tail = 0.5 * (1.0 - options.coverage);
  int outside = 0;
  for (int week = 0; week <= horizon; ++week) {
    outside += crossed[week];
    const double share = static_cast<double>(outside) / kDraws;
    if (week == kYearWeeks) crossing.probability_within_year = share;
    if (!has_dates) continue;
    const base::UtcTime at = WeeksAfter(state.last_at, week);
    if (!crossing.earliest && share >= tail) crossing.earliest = at;
    if (!crossing.median && share >= 0.5) crossing.median = at;
    if (!crossing.latest && share >= 1.0 - tail) crossing.latest = at;
  }
  return crossing;
}

}  // namespace axiscal::drift
