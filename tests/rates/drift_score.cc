#include "tests/rates/drift_score.h"

#include <absl/strings/str_format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <set>

#include "core/base/demand.h"
#include "core/base/random.h"

namespace axiscal::rates {
namespace {

constexpr int kFirst = 26;     // calibrations that are judged apart
constexpr int kDateSlack = 3;  // calibrations by which an alarm's date may be off and still mean the step
constexpr int kAlone = 8;      // calibrations around a step without another one, for its recall to be counted
constexpr int kGroup = 20;     // machines
constexpr double kYearWeeks = 52.1775;
constexpr std::array<int, 6> kForecastAt = {8, 26, 52, 104, 208, 400};  // calibrations that are known

struct Alarm {
  int found = 0, by = 0;  // calibrations
  std::set<int> errors;
  double certainty = 0.0, score = 0.0;
};

int IndexOf(const synthetic::MachineYears& machine, base::UtcTime at) {
  const auto found = std::lower_bound(machine.calibrations.begin(), machine.calibrations.end(), at,
                                      [](const drift::Calibration& one, base::UtcTime t) { return one.at < t; });
  return static_cast<int>(found - machine.calibrations.begin());
}

int ErrorOf(const synthetic::MachineYears& machine, const std::string& symbol) {
  for (size_t j = 0; j < machine.errors.size(); ++j) {
    if (machine.errors[j].symbol == symbol) return static_cast<int>(j);
  }
  return -1;
}

std::vector<std::string> KindsOf(const synthetic::MachineYears& machine) {
  bool wears = false, has_season = false;
  for (const auto& error : machine.errors) {
    wears |= error.wear_per_year != 0.0;
    has_season |= error.season != 0.0;
  }
  std::vector<std::string> kinds = {"all"};
  if (wears) kinds.push_back("wear");
  if (has_season)
    kinds.push_back(machine.is_temperature_recorded ? "season, temperature recorded" : "season, not recorded");
  if (machine.plans.size() > 1) kinds.push_back("three plans");
  if (machine.sigma_factor > 1.4) kinds.push_back("true sigma above 1.4 times the stated one");
  if (machine.sigma_factor < 0.8) kinds.push_back("true sigma below 0.8 times the stated one");
  if (!wears && !has_season) kinds.push_back("no wear, no season");
  return kinds;
}

void JudgeAlarms(const synthetic::MachineYears& machine, const std::vector<Alarm>& alarms, DriftScore* score) {
  const auto count = static_cast<int>(machine.calibrations.size());
  const int first = std::min(kFirst, count - 1);
  const double first_years =
      drift::WeeksBetween(machine.calibrations.front().at, machine.calibrations[first].at) / kYearWeeks;
  const double years =
      drift::WeeksBetween(machine.calibrations.front().at, machine.calibrations.back().at) / kYearWeeks - first_years;
  const std::vector<std::string> kinds = KindsOf(machine);
  score->first.years += first_years;
  for (const std::string& kind : kinds) score->after[kind].years += years;

  std::vector<int> found(machine.steps.size(), -1);
  std::vector<std::set<int>> named(machine.steps.size());
  for (const Alarm& alarm : alarms) {
    int best = -1;
    for (int s = 0; s < static_cast<int>(machine.steps.size()); ++s) {
      const synthetic::TrueStep& step = machine.steps[s];
      if (step.by > alarm.found || std::abs(step.by - alarm.by) > kDateSlack) continue;
      const bool is_new = std::any_of(step.errors.begin(), step.errors.end(),
                                      [&](int j) { return alarm.errors.contains(j) && !named[s].contains(j); });
      if (is_new && (best < 0 || std::abs(step.by - alarm.by) < std::abs(machine.steps[best].by - alarm.by))) best = s;
    }
    if (alarm.found < kFirst) {
      score->first.alarms += best < 0;
    } else {
      if (best < 0) {
        for (const std::string& kind : kinds) ++score->after[kind].alarms;
      }
      const auto bin = std::upper_bound(kCertainties.begin(), kCertainties.end(), alarm.certainty) - 1;
      score->certainty[bin - kCertainties.begin()].Add(best >= 0);
      score->stated[bin - kCertainties.begin()] += alarm.certainty;
      const auto row = std::upper_bound(kScores.begin(), kScores.end(), alarm.score) - 1;
      score->by_score[row - kScores.begin()].Add(best >= 0);
    }
    if (best < 0) continue;
    const synthetic::TrueStep& step = machine.steps[best];
    const bool is_first = found[best] < 0;
    if (is_first) found[best] = alarm.found;
    if (is_first && step.by >= kFirst) score->dated.Add(std::abs(step.by - alarm.by) <= 1);
    for (const int j : alarm.errors) {
      const bool moved = std::find(step.errors.begin(), step.errors.end(), j) != step.errors.end();
      if (step.by >= kFirst) score->named.Add(moved);
      if (moved) named[best].insert(j);
    }
  }
  for (size_t s = 0; s < machine.steps.size(); ++s) {
    const synthetic::TrueStep& step = machine.steps[s];
    const bool is_alone = std::none_of(
        machine.steps.begin(), machine.steps.end(),
        [&](const synthetic::TrueStep& other) { return &other != &step && std::abs(other.by - step.by) <= kAlone; });
    if (!is_alone || step.by < kFirst || step.by + kAlone >= count) continue;
    std::vector<std::string> rows = {absl::StrFormat("d = %g", step.distance)};
    if (step.distance >= 6.0) rows.push_back("d >= 6");
    if (step.errors.size() == 1 && step.largest_sigmas >= 4.0) rows.push_back("one error, >= 4 true sigma");
    if (step.largest_sigmas >= 3.0)
      rows.push_back(step.largest_sigmas < 4.0   ? "largest error 3 to 4 true sigma"
                     : step.largest_sigmas < 5.0 ? "largest error 4 to 5 true sigma"
                                                 : "largest error above 5 true sigma");
    for (const std::string& row : rows) {
      Recall& recall = score->recall[row];
      ++recall.all;
      for (size_t w = 0; w < Recall::kWithin.size(); ++w)
        recall.found[w] += found[s] >= 0 && found[s] - step.by + 1 <= Recall::kWithin[w];
    }
    if (found[s] >= 0) {
      for (const int j : step.errors) score->named_of_moved.Add(named[s].contains(j));
    }
  }
}

bool JumpsBetween(const synthetic::MachineYears& machine, int error, int from, int to) {
  return std::any_of(machine.steps.begin(), machine.steps.end(), [&](const synthetic::TrueStep& step) {
    return step.by > from && step.by <= to &&
           std::find(step.errors.begin(), step.errors.end(), error) != step.errors.end();
  });
}

void JudgeForecast(const synthetic::MachineYears& machine, const drift::State& state, int known, int error,
                   const drift::ForecastOptions& options, DriftScore* score) {
  const std::string& symbol = machine.errors[error].symbol;
  const auto count = static_cast<int>(machine.calibrations.size());
  const std::string age = absl::StrFormat("%3d known", known);
  for (const int days : {30, 90, 180, 728}) {
    const base::UtcTime at = state.last_at + std::chrono::days(days);
    int then = IndexOf(machine, at);
    while (then < count && machine.plan_of[then] != 0) ++then;
    if (then >= count || JumpsBetween(machine, error, known - 1, then)) continue;
    const auto forecast = drift::ForecastOf(state, symbol, machine.calibrations[then].at, options);
    if (!forecast.ok()) continue;
    const double measured = machine.calibrations[then].values[error].value, truth = machine.truth[then](error);
    const bool has_measured = measured >= forecast->measured_low && measured <= forecast->measured_high;
    const bool has_truth = truth >= forecast->low && truth <= forecast->high;
    const bool moves = machine.errors[error].wear_per_year != 0.0;
    if (days < 728) score->forecasts[absl::StrFormat("measured, %3d days, %s", days, age)].Add(has_measured);
    score->forecasts[absl::StrFormat("measured, %3d days", days)].Add(has_measured);
    score->forecasts[absl::StrFormat("true, %3d days%s", days, moves ? ", worn" : "")].Add(has_truth);
  }
}

void JudgeCrossing(const synthetic::MachineYears& machine, const drift::State& state, int known, int error,
                   const drift::ForecastOptions& options, base::Random& random, DriftScore* score) {
  const auto count = static_cast<int>(machine.calibrations.size());
  const int end = IndexOf(machine, state.last_at + std::chrono::days(365));
  if (end >= count || JumpsBetween(machine, error, known - 1, end)) return;
  const auto& facts = machine.errors[error];
  const auto here = drift::ForecastOf(state, facts.symbol, state.last_at, options);
  if (!here.ok()) return;
  const double reach = facts.stated_sigma * std::exp(random.Uniform(std::log(1.0), std::log(8.0)));
  const drift::Limits limits{here->value - reach, here->value + reach};
  const auto crossing = drift::CrossingOf(state, facts.symbol, limits, options);
  if (!crossing.ok()) return;
  bool crossed = false;
  for (int i = known - 1; i <= end; ++i)
    crossed |= machine.truth[i](error) < limits.low || machine.truth[i](error) > limits.high;
  const double stated = crossing->probability_within_year;
  const std::string row = stated < 0.1   ? "below .1"
                          : stated < 0.3 ? ".1 to .3"
                          : stated < 0.6 ? ".3 to .6"
                          : stated < 0.9 ? ".6 to .9"
                                         : "above .9";
  score->crossings[row].Add(crossed);
  score->crossing_stated[row] += stated;
}

void JudgeForecasts(const synthetic::MachineYears& machine, const drift::State& state, int known, Group* group,
                    DriftScore* score) {
  std::deque<drift::State>& others = (*group)[known];
  drift::ForecastOptions options;
  std::vector<const drift::State*> machines;
  for (const drift::State& other : others) machines.push_back(&other);
  options.prior = drift::PriorOfGroup(machines);
  base::Random random(base::StreamSeed(known, score->machines));
  std::vector<int> errors = {random.Below(machine.errors.size()), random.Below(machine.errors.size())};
  // Most errors neither wear nor go with the season; those that do are looked at as often.
  for (size_t j = 0; j < machine.errors.size(); ++j) {
    if (machine.errors[j].wear_per_year != 0.0) errors.push_back(static_cast<int>(j));
  }
  for (const int error : errors) {
    JudgeForecast(machine, state, known, error, options, score);
    JudgeCrossing(machine, state, known, error, options, random, score);
  }
  others.push_back(state);
  if (others.size() > kGroup) others.pop_front();
}

struct Said {
  std::set<int> wear, season;
};

}  // namespace

void Judge(const synthetic::MachineYears& machine, bool with_forecasts, Group* group, DriftScore* score) {
  drift::State state;
  std::vector<Alarm> alarms;
  std::set<int> suspects;
  Said said;
  const auto count = static_cast<int>(machine.calibrations.size());
  ++score->machines;
  for (int i = 0; i < count; ++i) {
    const std::clock_t before = std::clock();
    const auto findings = drift::Advance(machine.calibrations[i], &state);
    score->seconds += static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    ++score->calibrations;
    DEMAND(findings.ok());
    for (const drift::Finding& finding : *findings) {
      if (const auto* const step = std::get_if<drift::StepChange>(&finding)) {
        if (step->is_revision) {
          ++score->revisions;
          continue;
        }
        Alarm alarm{i, IndexOf(machine, step->by), {}, step->certainty, step->score};
        for (const drift::Amount& amount : step->amounts) alarm.errors.insert(ErrorOf(machine, amount.symbol));
        alarms.push_back(std::move(alarm));
      } else if (const auto* const retraction = std::get_if<drift::Retraction>(&finding)) {
        ++score->retractions;
        const int by = IndexOf(machine, retraction->by);
        score->retracted_right += std::any_of(machine.steps.begin(), machine.steps.end(),
                                              [&](const auto& one) { return std::abs(one.by - by) <= kDateSlack; });
      } else if (std::holds_alternative<drift::Suspect>(finding)) {
        suspects.insert(i);
        ++score->suspects;
      } else if (std::holds_alternative<drift::Unstable>(finding)) {
        ++score->unstable;
      } else if (const auto* const slope = std::get_if<drift::Slope>(&finding)) {
        const int j = ErrorOf(machine, slope->per_year.symbol);
        slope->is_over ? void(said.wear.erase(j)) : void(said.wear.insert(j));
      } else if (const auto* const season = std::get_if<drift::Season>(&finding)) {
        const int j = ErrorOf(machine, season->amplitude.symbol);
        season->is_over ? void(said.season.erase(j)) : void(said.season.insert(j));
      }
    }
    if (with_forecasts && std::find(kForecastAt.begin(), kForecastAt.end(), i + 1) != kForecastAt.end())
      JudgeForecasts(machine, state, i + 1, group, score);
  }
  if (count < 2) return;
  JudgeAlarms(machine, alarms, score);
  for (const synthetic::TrueOutlier& outlier : machine.outliers) {
    if (outlier.calibration < kFirst) continue;
    const bool is_alarm = std::any_of(alarms.begin(), alarms.end(),
                                      [&](const Alarm& alarm) { return alarm.found == outlier.calibration; });
    score->suspected.Add(is_alarm || suspects.contains(outlier.calibration));
  }
  for (size_t j = 0; j < machine.errors.size(); ++j) {
    const auto& error = machine.errors[j];
    const auto at = static_cast<int>(j);
    if (error.wear_per_year != 0.0) score->wears.Add(said.wear.contains(at));
    if (said.wear.contains(at)) score->wears_right.Add(error.wear_per_year != 0.0);
    if (std::abs(error.season) >= 0.8 * error.stated_sigma) score->seasons.Add(said.season.contains(at));
    if (said.season.contains(at)) score->seasons_right.Add(error.season != 0.0);
  }
}

std::string ToText(const DriftScore& score) {
  std::string text =
      absl::StrFormat("%d machines, %d calibrations, %.0f us a calibration\n", score.machines, score.calibrations,
                      1e6 * score.seconds / std::max<double>(1.0, score.calibrations));
  absl::StrAppend(&text, "\n| false alarms in 10 machine-years | | machine-years |\n|---|---|---|\n");
  absl::StrAppendFormat(&text, "| first 26 calibrations | %.2f | %.0f |\n", score.first.in_ten_years(),
                        score.first.years);
  for (const auto& [kind, one] : score.after)
    absl::StrAppendFormat(&text, "| %s | %.2f | %.0f |\n", kind, one.in_ten_years(), one.years);
  absl::StrAppend(&text, "\n| steps found within | 2 | 3 | 4 | 8 | steps |\n|---|---|---|---|---|---|\n");
  for (const auto& [row, one] : score.recall) {
    absl::StrAppendFormat(&text, "| %s |", row);
    for (const int found : one.found) absl::StrAppendFormat(&text, " %.2f |", found / static_cast<double>(one.all));
    absl::StrAppendFormat(&text, " %d |\n", one.all);
  }
  const auto line = [&](const char* what, const Share& share) {
    absl::StrAppendFormat(&text, "| %s | %.3f | %d |\n", what, share.share(), share.all);
  };
  absl::StrAppend(&text, "\n| share | | of |\n|---|---|---|\n");
  line("date of a step within one calibration", score.dated);
  line("named errors that moved", score.named);
  line("moved errors that were named", score.named_of_moved);
  line("outliers told at once", score.suspected);
  line("wear told at the end, of true wear", score.wears);
  line("true wear, of wear told at the end", score.wears_right);
  line("season told at the end, of true ones of 0.8 sigma or more", score.seasons);
  line("true season, of season told at the end", score.seasons_right);
  absl::StrAppendFormat(
      &text,
      "\nsuspects: %d (%.3f of calibrations), unstable: %d, corrected: %d steps, taken back: %d, %d of them true\n",
      score.suspects, score.suspects / std::max<double>(1.0, score.calibrations), score.unstable, score.revisions,
      score.retractions, score.retracted_right);
  absl::StrAppend(&text, "\n| certainty stated, mean | seen | alarms |\n|---|---|---|\n");
  for (size_t i = 0; i < score.certainty.size(); ++i) {
    const Share& share = score.certainty[i];
    if (share.all > 0)
      absl::StrAppendFormat(&text, "| %.3f | %.3f | %d |\n", score.stated[i] / share.all, share.share(), share.all);
  }
  absl::StrAppend(&text, "\n| score from | right | alarms |\n|---|---|---|\n");
  for (size_t i = 0; i < score.by_score.size(); ++i) {
    const Share& share = score.by_score[i];
    if (share.all > 0) absl::StrAppendFormat(&text, "| %g | %.3f | %d |\n", kScores[i], share.share(), share.all);
  }
  if (score.forecasts.empty()) return text;
  absl::StrAppend(&text, "\n| within the 90 % forecast | share | of |\n|---|---|---|\n");
  for (const auto& [row, one] : score.forecasts) line(row.c_str(), one);
  absl::StrAppend(&text, "\n| limit crossed within a year, stated | stated, mean | seen | of |\n|---|---|---|---|\n");
  for (const auto& [row, one] : score.crossings)
    absl::StrAppendFormat(&text, "| %s | %.2f | %.2f | %d |\n", row, score.crossing_stated.at(row) / one.all,
                          one.share(), one.all);
  return text;
}

}  // namespace axiscal::rates
