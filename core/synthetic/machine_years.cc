#include "core/synthetic/machine_years.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/base/random.h"

namespace axiscal::synthetic {
namespace {

constexpr double kYearDays = 365.2425;
constexpr int64_t kStartUs = 1'420'416'000'000'000;  // 2015-01-05, a Monday
constexpr int64_t kDayUs = 86'400'000'000;

// Of a five-axis machine whose table tilts (A) and turns (C).
constexpr std::array kSymbols = {"EC0Y", "EA0Z", "EB0Z", "EY0A", "EZ0A", "EB0A", "EC0A",
                                 "EX0C", "EY0C", "EA0C", "EB0C", "EX0T", "EY0T"};
constexpr int kErrors = static_cast<int>(kSymbols.size());
constexpr int kReadings = 2 * kErrors;  // of the imagined test: its covariance has one direction known badly
constexpr std::array kDistances = {3.0, 4.0, 5.0, 6.0, 8.0, 12.0};
constexpr int kMostStep = 6;  // errors of one step

double LogNormal(double median, double spread, base::Random& random) {
  return median * std::exp(spread * random.Normal());
}

std::vector<int> Some(int least, int most, base::Random& random) {
  std::vector<int> all(kErrors);
  std::iota(all.begin(), all.end(), 0);
  const int count = least + random.Below(most - least + 1);
  for (int i = 0; i < count; ++i) std::swap(all[i], all[i + random.Below(kErrors - i)]);
  all.resize(count);
  std::sort(all.begin(), all.end());
  return all;
}

Eigen::VectorXd Normals(Eigen::Index count, base::Random& random) {
  Eigen::VectorXd normals(count);
  for (double& one : normals) one = random.Normal();
  return normals;
}

// The correlations of what a test with twice as many readings as errors tells.
Eigen::MatrixXd DrawCorrelation(base::Random& random) {
  Eigen::MatrixXd readings(kReadings, kErrors);
  for (int i = 0; i < kReadings; ++i) readings.row(i) = Normals(kErrors, random);
  const Eigen::MatrixXd covariance =
      (readings.transpose() * readings).llt().solve(Eigen::MatrixXd::Identity(kErrors, kErrors));
  const Eigen::VectorXd scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  return 0.5 * (correlation + correlation.transpose());
}

// What a machine is; sizes in stated sigmas.
struct Nature {
  Eigen::VectorXd sigma;               // um, urad: the unit of all else
  std::vector<Eigen::MatrixXd> plans;  // stated covariance, kErrors x kErrors
  std::vector<std::vector<int>> told;  // errors of each plan
  double factor = 1.0;                 // true by stated sigma
  Eigen::VectorXd setup;               // sigma that set-ups add
  Eigen::VectorXd wear, wander;        // per year; per root of a week
  Eigen::VectorXd season;              // at the height of the year
  double yearly_kelvin = 0.0, phase = 0.0;
  bool is_recorded = false;
};

Nature DrawNature(const Disturbances& has, base::Random& random) {
  Nature nature;
  nature.sigma.resize(kErrors);
  for (double& sigma : nature.sigma) sigma = LogNormal(1.5, 0.4, random);
  const Eigen::MatrixXd full = DrawCorrelation(random);
  Eigen::VectorXd unknown = Normals(kErrors, random).normalized();
  std::vector<int> all(kErrors);
  std::iota(all.begin(), all.end(), 0);
  std::vector<int> fewer = all;
  for (int i = 0; i < 2; ++i) fewer.erase(fewer.begin() + random.Below(fewer.size()));
  const bool has_plans = random.Chance(0.5) && has.plans;
  nature.plans = {full};
  nature.told = {all};
  if (has_plans) {
    nature.plans.push_back(2.25 * full + 2500.0 * unknown * unknown.transpose());
    nature.plans.push_back(full);
    nature.told.push_back(all);
    nature.told.push_back(fewer);
  }
  const double factor = std::clamp(LogNormal(1.0, 0.3, random), 0.7, 2.0);
  const bool has_setup = random.Chance(0.5) && has.wrong_sigma;
  nature.factor = has.wrong_sigma ? factor : 1.0;
  nature.setup = Eigen::VectorXd::Zero(kErrors);
  for (double& setup : nature.setup) {
    const double size = random.Uniform(0.0, 0.7);
    if (has_setup) setup = size;
  }
  nature.wear = nature.wander = nature.season = Eigen::VectorXd::Zero(kErrors);
  const bool has_wear = random.Chance(1.0 / 3.0) && has.wear;
  for (const int j : Some(1, 3, random)) {
    const double wear = random.Uniform(1.0, 5.0) * (random.Chance(0.5) ? 1.0 : -1.0);
    if (has_wear) nature.wear(j) = wear, nature.wander(j) = 0.03;
  }
  const bool has_season = random.Chance(0.5) && has.season;
  nature.is_recorded = random.Chance(0.5);
  nature.yearly_kelvin = random.Uniform(1.5, 5.0);
  nature.phase = random.Uniform(0.0, 2.0 * std::numbers::pi);
  for (const int j : Some(3, 8, random)) {
    const double size = 0.8 * random.Normal();
    if (has_season) nature.season(j) = size;
  }
  return nature;
}

// In days from the start; missing ones are left out.
std::vector<double> DrawDates(const YearsToDraw& asked, base::Random& random) {
  std::vector<double> days;
  const double end = asked.years * kYearDays;
  double gap_until = -1.0;
  for (double day = 0.0; day < end; day += asked.interval_days) {
    const double at = day + asked.interval_days * random.Uniform(0.0, 0.4);
    const bool starts_gap = random.Chance(0.3 * asked.interval_days / kYearDays);
    const double weeks = random.Uniform(4.0, 12.0);
    const bool is_missing = random.Chance(0.1);
    if (asked.disturbances.gaps && starts_gap) gap_until = std::max(gap_until, day + 7.0 * weeks);
    if (asked.disturbances.gaps && (is_missing || day < gap_until)) continue;
    days.push_back(at);
  }
  return days;
}

// In stated sigmas.
struct Jump {
  double day = 0.0, distance = 0.0, largest = 0.0;
  Eigen::VectorXd size;
};

std::vector<Jump> DrawJumps(const YearsToDraw& asked, const Nature& nature, base::Random& random) {
  Eigen::MatrixXd covariance = nature.factor * nature.factor * nature.plans[0];
  covariance.diagonal() += nature.setup.cwiseAbs2();
  const Eigen::LLT<Eigen::MatrixXd> root(covariance);
  std::vector<Jump> jumps;
  if (!asked.disturbances.steps) return jumps;
  for (double day = 0.0;;) {
    day -= std::log(random.Uniform()) * kYearDays / 0.3;
    if (day >= asked.years * kYearDays) return jumps;
    Jump jump{day, kDistances[random.Below(kDistances.size())], 0.0, Eigen::VectorXd::Zero(kErrors)};
    for (const int j : Some(1, kMostStep, random)) jump.size(j) = random.Normal();
    jump.size *= jump.distance / std::sqrt(jump.size.dot(root.solve(jump.size)));
    jump.largest = (jump.size.cwiseAbs().array() / covariance.diagonal().array().sqrt()).maxCoeff();
    jumps.push_back(std::move(jump));
  }
}

std::vector<int> NotZero(const Eigen::VectorXd& sizes) {
  std::vector<int> errors;
  for (int j = 0; j < sizes.size(); ++j) {
    if (sizes(j) != 0.0) errors.push_back(j);
  }
  return errors;
}

MachineYears Described(const Nature& nature, int number) {
  MachineYears machine;
  machine.machine = absl::StrFormat("m%05d", number + 1);
  machine.sigma_factor = nature.factor;
  machine.is_temperature_recorded = nature.is_recorded;
  for (int j = 0; j < kErrors; ++j) {
    const std::string symbol = kSymbols[j];
    const bool is_angle = symbol[1] >= 'A' && symbol[1] <= 'C';
    machine.errors.push_back({symbol, is_angle ? drift::Unit::kUrad : drift::Unit::kUm, nature.sigma(j),
                              nature.wear(j) * nature.sigma(j), nature.season(j) * nature.sigma(j)});
  }
  static constexpr std::array kNames = {"full", "quick", "fewer"};
  for (size_t k = 0; k < nature.plans.size(); ++k) {
    const Eigen::MatrixXd scaled = nature.sigma.asDiagonal() * nature.plans[k] * nature.sigma.asDiagonal();
    machine.plans.push_back({kNames[k], nature.told[k], scaled(nature.told[k], nature.told[k])});
  }
  return machine;
}

// The machine between its calibrations; sizes in stated sigmas.
class Life {
 public:
  Life(const YearsToDraw& asked, const Nature& nature, base::Random& random)
      : nature_(nature), jumps_(DrawJumps(asked, nature, random)), level_(20.0 * Normals(kErrors, random)) {}

  // The jumps since the last call, summed, if any.
  void LiveUntil(double day, base::Random& random, std::vector<Jump>* jumped) {
    const double years = (day - day_) / kYearDays, weeks = (day - day_) / 7.0;
    level_ += years * nature_.wear + std::sqrt(weeks) * nature_.wander.cwiseProduct(Normals(kErrors, random));
    const double remembered = std::exp(-weeks);  // weather lasts a week
    weather_kelvin_ = remembered * weather_kelvin_ + std::sqrt(1.0 - remembered * remembered) * random.Normal();
    day_ = day;
    for (; next_ < jumps_.size() && jumps_[next_].day < day; ++next_) {
      level_ += jumps_[next_].size;
      jumped->push_back(jumps_[next_]);
    }
  }
  double kelvin() const {
    return nature_.yearly_kelvin * std::sin(2.0 * std::numbers::pi * day_ / kYearDays + nature_.phase) +
           weather_kelvin_;
  }
  Eigen::VectorXd errors() const { return level_ + nature_.season * (kelvin() / nature_.yearly_kelvin); }

 private:
  const Nature& nature_;
  const std::vector<Jump> jumps_;
  Eigen::VectorXd level_;
  double day_ = 0.0, weather_kelvin_ = 0.0;
  size_t next_ = 0;
};

class Measurement {
 public:
  explicit Measurement(const Nature& nature) : nature_(nature) {
    for (const Eigen::MatrixXd& plan : nature.plans) {
      Eigen::MatrixXd covariance = nature.factor * nature.factor * plan;
      covariance.diagonal() += nature.setup.cwiseAbs2();
      sigma_.push_back(covariance.diagonal().cwiseSqrt());
      roots_.push_back(covariance.llt().matrixL());
    }
  }
  int DrawPlan(base::Random& random) const {
    const double share = random.Uniform();
    if (nature_.plans.size() == 1) return 0;
    return share < 0.6 ? 0 : share < 0.85 ? 1 : 2;
  }
  // What a calibration by `plan` is off by; `outlier`: the errors that a bad one has elsewhere.
  Eigen::VectorXd Off(int plan, const std::vector<int>& outlier, base::Random& random) const {
    Eigen::VectorXd off = roots_[plan] * Normals(kErrors, random);
    for (const int j : outlier) {
      const double size = std::exp(random.Uniform(std::log(4.0), std::log(30.0)));
      off(j) += (random.Chance(0.5) ? size : -size) * sigma_[0](j);
    }
    return off;
  }

 private:
  const Nature& nature_;
  std::vector<Eigen::VectorXd> sigma_;
  std::vector<Eigen::MatrixXd> roots_;
};

std::vector<int> Both(std::vector<int> some, const std::vector<int>& told) {
  std::erase_if(some, [&](int j) { return !std::binary_search(told.begin(), told.end(), j); });
  return some;
}

}  // namespace

absl::Status Check(const YearsToDraw& asked) {
  if (!(asked.years >= 0.1 && asked.years <= 50.0))
    return absl::InvalidArgumentError(absl::StrCat("years = ", asked.years, ", must be 0.1 to 50"));
  if (!(asked.interval_days >= 0.5 && asked.interval_days <= 60.0))
    return absl::InvalidArgumentError(absl::StrCat("interval_days = ", asked.interval_days, ", must be 0.5 to 60"));
  return absl::OkStatus();
}

MachineYears DrawMachineYears(const YearsToDraw& asked, int number) {
  base::Random random(base::StreamSeed(asked.seed, static_cast<uint64_t>(number)));
  const Nature nature = DrawNature(asked.disturbances, random);
  MachineYears machine = Described(nature, number);
  Life life(asked, nature, random);
  const Measurement measurement(nature);
  for (const double day : DrawDates(asked, random)) {
    std::vector<Jump> jumps;
    life.LiveUntil(day, random, &jumps);
    const auto index = static_cast<int>(machine.calibrations.size());
    for (const Jump& jump : jumps) {
      TrueStep step{index, NotZero(jump.size), {}, jump.distance, jump.largest};
      for (const int j : step.errors) step.sizes.push_back(jump.size(j) * nature.sigma(j));
      machine.steps.push_back(std::move(step));
    }
    const int plan = measurement.DrawPlan(random);
    const std::vector<int>& told = nature.told[plan];
    std::vector<int> outlier;
    if (random.Chance(asked.disturbances.outlier_share)) outlier = Both(Some(1, 6, random), told);
    if (!outlier.empty()) machine.outliers.push_back({index, outlier});
    const Eigen::VectorXd truth = nature.sigma.cwiseProduct(life.errors());
    const Eigen::VectorXd off = nature.sigma.cwiseProduct(measurement.Off(plan, outlier, random));

    drift::Calibration calibration;
    calibration.at = base::FromUtcUs(kStartUs + std::llround(day * 1440.0) * (kDayUs / 1440));  // whole minutes
    calibration.covariance = machine.plans[plan].covariance;
    for (const int j : told)
      calibration.values.push_back({machine.errors[j].symbol, machine.errors[j].unit, truth(j) + off(j)});
    if (nature.is_recorded) calibration.temperature_celsius = 20.0 + life.kelvin();
    machine.calibrations.push_back(std::move(calibration));
    machine.plan_of.push_back(plan);
    machine.truth.push_back(truth);
  }
  return machine;
}

namespace {

std::string Iso(base::UtcTime at) {
  const auto day = std::chrono::floor<std::chrono::days>(at);
  const std::chrono::year_month_day date(day);
  const int64_t minutes = std::chrono::duration_cast<std::chrono::minutes>(at - day).count();
  return absl::StrFormat("%04d-%02d-%02dT%02d:%02d:00Z", static_cast<int>(date.year()),
                         static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), minutes / 60,
                         minutes % 60);
}

void AppendNumber(double number, std::string* text) { absl::StrAppendFormat(text, "%.6g", number); }

// {"EX0C": 1.5, ...}
template <typename SizeOf>
void AppendNamed(const MachineYears& machine, const std::vector<int>& errors, const SizeOf& size, std::string* text) {
  *text += "{";
  for (size_t i = 0; i < errors.size(); ++i) {
    absl::StrAppend(text, i == 0 ? "\"" : ", \"", machine.errors[errors[i]].symbol, "\": ");
    AppendNumber(size(i), text);
  }
  *text += "}";
}

void AppendPlan(const MachineYears& machine, const MachineYears::Plan& plan, std::string* text) {
  absl::StrAppend(text, "\"", plan.name, "\": {\"of\": [");
  for (size_t i = 0; i < plan.errors.size(); ++i)
    absl::StrAppend(text, i == 0 ? "\"" : ", \"", machine.errors[plan.errors[i]].symbol, "\"");
  *text += "], \"covariance\": [";
  for (Eigen::Index i = 0; i < plan.covariance.rows(); ++i) {
    *text += i == 0 ? "[" : ", [";
    for (Eigen::Index j = 0; j <= i; ++j) {
      if (j > 0) *text += ", ";
      AppendNumber(plan.covariance(i, j), text);
    }
    *text += "]";
  }
  *text += "]}";
}

void AppendTruth(const MachineYears& machine, std::string* text) {
  absl::StrAppend(text, "{\"machine\": \"", machine.machine, "\", \"truth\": {\"sigma_factor\": ");
  AppendNumber(machine.sigma_factor, text);
  std::vector<int> all(machine.errors.size());
  std::iota(all.begin(), all.end(), 0);
  *text += ", \"wear_per_year\": ";
  AppendNamed(
      machine, all, [&](size_t i) { return machine.errors[i].wear_per_year; }, text);
  *text += ", \"season\": ";
  AppendNamed(
      machine, all, [&](size_t i) { return machine.errors[i].season; }, text);
  *text += ", \"steps\": [";
  for (size_t i = 0; i < machine.steps.size(); ++i) {
    const TrueStep& step = machine.steps[i];
    absl::StrAppend(text, i == 0 ? "" : ", ", "{\"by\": \"", Iso(machine.calibrations[step.by].at),
                    "\", \"distance\": ", step.distance, ", \"sizes\": ");
    AppendNamed(
        machine, step.errors, [&](size_t k) { return step.sizes[k]; }, text);
    *text += "}";
  }
  *text += "], \"outliers\": [";
  for (size_t i = 0; i < machine.outliers.size(); ++i) {
    const TrueOutlier& outlier = machine.outliers[i];
    absl::StrAppend(text, i == 0 ? "" : ", ", "{\"at\": \"", Iso(machine.calibrations[outlier.calibration].at),
                    "\", \"errors\": [");
    for (size_t k = 0; k < outlier.errors.size(); ++k)
      absl::StrAppend(text, k == 0 ? "\"" : ", \"", machine.errors[outlier.errors[k]].symbol, "\"");
    *text += "]}";
  }
  *text += "]}}\n";
}

}  // namespace

std::string HistoryHeader(const YearsToDraw& asked, int machines) {
  return absl::StrCat("{\"axiscal\": \"history/1\", \"machines\": ", machines, ", \"years\": ", asked.years,
                      ", \"interval_days\": ", asked.interval_days, ", \"seed\": ", asked.seed, "}\n");
}

std::string HistoryLines(const MachineYears& machine) {
  std::string text = absl::StrCat("{\"machine\": \"", machine.machine, "\", \"units\": {");
  for (size_t j = 0; j < machine.errors.size(); ++j)
    absl::StrAppend(&text, j == 0 ? "\"" : ", \"", machine.errors[j].symbol, "\": \"",
                    drift::Text(machine.errors[j].unit), "\"");
  text += "}, \"plans\": {";
  for (size_t k = 0; k < machine.plans.size(); ++k) {
    if (k > 0) text += ", ";
    AppendPlan(machine, machine.plans[k], &text);
  }
  text += "}}\n";
  for (size_t i = 0; i < machine.calibrations.size(); ++i) {
    const drift::Calibration& calibration = machine.calibrations[i];
    const MachineYears::Plan& plan = machine.plans[machine.plan_of[i]];
    absl::StrAppend(&text, "{\"machine\": \"", machine.machine, "\", \"at\": \"", Iso(calibration.at),
                    "\", \"plan\": \"", plan.name, "\"");
    if (calibration.temperature_celsius)
      absl::StrAppendFormat(&text, ", \"temperature_celsius\": %.2f", *calibration.temperature_celsius);
    text += ", \"values\": ";
    AppendNamed(
        machine, plan.errors, [&](size_t k) { return calibration.values[k].value; }, &text);
    text += "}\n";
  }
  AppendTruth(machine, &text);
  return text;
}

}  // namespace axiscal::synthetic
