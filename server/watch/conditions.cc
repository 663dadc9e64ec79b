#include "server/watch/conditions.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_join.h"
#include "core/drift/forecast.h"
#include "core/drift/peers.h"
#include "server/inputs/tolerance.h"

namespace axiscal::watch {
namespace {

using records::EventContent;
using records::EventKind;

// A forecast is told when it is more likely than not that the error leaves its limits within a year. Probabilities are
// drawn, good to 0.02 (core/drift/forecast.h), and move from calibration to calibration.
constexpr double kForecastRaises = 0.5, kForecastKeeps = 0.3;
// A step is news for so long; one that nobody has acknowledged stays told.
// Told as unlike its group where a machine like the others had an error so far away by chance with less than this
// probability, all errors that are compared and all groups taken together (Bonferroni).
constexpr double kUnlikeRaises = 0.01, kUnlikeKeeps = 0.05;
constexpr auto kNews = std::chrono::days(90);

std::string UnitText(records::EstimateUnit unit) { return unit == records::EstimateUnit::kUm ? "um" : "urad"; }

records::DriftAmount ToRecord(const drift::Amount& amount) {
  const bool is_um = amount.unit == drift::Unit::kUm;
  return {amount.symbol, is_um ? records::EstimateUnit::kUm : records::EstimateUnit::kUrad, amount.size, amount.sigma};
}

std::vector<records::DriftAmount> ToRecords(const std::vector<drift::Amount>& amounts) {
  std::vector<records::DriftAmount> records;
  for (const drift::Amount& amount : amounts) records.push_back(ToRecord(amount));
  return records;
}

// The newest number of an error, and the calibration that it is from.
struct Newest {
  const records::CalibrationRecord* calibration = nullptr;
  const records::Estimate* estimate = nullptr;
};

Newest NewestOf(const inputs::MachineHistory& history, const std::string& symbol) {
  for (auto record = history.counted.rbegin(); record != history.counted.rend(); ++record) {
    for (const records::Estimate& estimate : record->content.estimates) {
      const bool has_number = estimate.identifiable && estimate.value && estimate.sigma;
      if (estimate.symbol == symbol && has_number) return {&*record, &estimate};
    }
  }
  return {};
}

// Nothing where the error is inside for sure, or has no number.
std::optional<Condition> OutOfTolerance(const inputs::MachineHistory& history, const records::DriftLimit& limit) {
  const Newest newest = NewestOf(history, limit.symbol);
  if (newest.estimate == nullptr) return std::nullopt;
  const double value = *newest.estimate->value, sigma = *newest.estimate->sigma;
  const double outside = inputs::ProbabilityOutside(limit, *newest.estimate);
  if (outside < inputs::kProvenInside) return std::nullopt;
  const std::string unit = UnitText(newest.estimate->unit);
  Condition condition;
  condition.raises = outside >= inputs::kProvenOutside;
  EventContent& content = condition.content;
  content.kind = EventKind::kOutOfTolerance;
  content.subject = limit.symbol;
  content.text =
      absl::StrFormat("%s is %.4g +- %.2g %s, its tolerance is %g .. %g %s (calibration %d, measured %s)", limit.symbol,
                      value, sigma, unit, limit.low, limit.high, unit, newest.calibration->id.number(),
                      inputs::DayText(newest.calibration->content.measured_at));
  content.advice =
      "repeat the measurement; then compensate with a calibration of now, or have the machine adjusted and put a mark "
      "in";
  content.amounts = {{limit.symbol, newest.estimate->unit, value, sigma}};
  content.certainty = outside;
  content.calibration = newest.calibration->id;
  return condition;
}

std::optional<Condition> LimitForecast(const inputs::MachineHistory& history, const records::DriftLimit& limit) {
  const absl::StatusOr<drift::Crossing> crossing =
      drift::CrossingOf(history.state, limit.symbol, {limit.low, limit.high});
  if (!crossing.ok() || crossing->probability_within_year < kForecastKeeps) return std::nullopt;
  const auto error = std::find_if(history.state.errors.begin(), history.state.errors.end(),
                                  [&](const drift::Followed& followed) { return followed.symbol == limit.symbol; });
  if (error == history.state.errors.end()) return std::nullopt;
  const bool is_um = error->unit == drift::Unit::kUm;
  const records::EstimateUnit unit = is_um ? records::EstimateUnit::kUm : records::EstimateUnit::kUrad;
  Condition condition;
  condition.raises = crossing->probability_within_year >= kForecastRaises;
  EventContent& content = condition.content;
  content.kind = EventKind::kLimitForecast;
  content.subject = limit.symbol;
  content.text =
      absl::StrFormat("%s leaves %g .. %g %s within a year after the last calibration, probability %.0f %%",
                      limit.symbol, limit.low, limit.high, UnitText(unit), 100 * crossing->probability_within_year);
  if (crossing->median) absl::StrAppend(&content.text, "; as likely as not by ", inputs::DayText(*crossing->median));
  content.advice = crossing->median ? "plan a service, or a new compensation, before then"
                                    : "plan a service, or a new compensation; more calibrations will tell the date";
  content.certainty = crossing->probability_within_year;
  content.from = crossing->earliest;
  content.to = crossing->median;
  if (!history.counted.empty()) content.calibration = history.counted.back().id;
  const Newest newest = NewestOf(history, limit.symbol);
  if (newest.estimate != nullptr)
    content.amounts = {{limit.symbol, newest.estimate->unit, *newest.estimate->value, *newest.estimate->sigma}};
  return condition;
}

void AddTolerances(const HistoryFacts& facts, std::vector<Condition>& conditions) {
  for (const records::DriftLimit& limit : facts.expected.content.tolerances) {
    const std::optional<Condition> outside = OutOfTolerance(facts.history, limit);
    if (outside) conditions.push_back(*outside);
    // What is outside already need not be foretold.
    if (outside && outside->raises) continue;
    if (const std::optional<Condition> forecast = LimitForecast(facts.history, limit)) conditions.push_back(*forecast);
  }
}

// Each as it was told last, without those that went back.
std::vector<drift::StepChange> StandingSteps(const inputs::MachineHistory& history) {
  std::vector<drift::StepChange> steps;
  const auto is_of = [](const drift::StepChange& step, base::UtcTime after, base::UtcTime by) {
    return step.after == after && step.by == by;
  };
  for (const drift::Finding& finding : history.findings) {
    if (const auto* const step = std::get_if<drift::StepChange>(&finding)) {
      std::erase_if(steps, [&](const auto& told) { return is_of(told, step->after, step->by); });
      steps.push_back(*step);
    } else if (const auto* const back = std::get_if<drift::Retraction>(&finding)) {
      std::erase_if(steps, [&](const auto& told) { return is_of(told, back->after, back->by); });
    }
  }
  return steps;
}

void AddSteps(const HistoryFacts& facts, std::vector<Condition>& conditions) {
  for (const drift::StepChange& step : StandingSteps(facts.history)) {
    Condition condition;
    condition.raises = facts.now - step.by <= kNews;
    EventContent& content = condition.content;
    content.kind = EventKind::kStep;
    content.text = drift::Text(step);
    content.advice =
        "look for a collision or a new fixture; acknowledge with what it was, or put a mark in; calibrate again";
    content.amounts = ToRecords(step.amounts);
    content.certainty = step.certainty;
    content.from = step.after;
    content.to = step.by;
    conditions.push_back(std::move(condition));
  }
}

// Wear and scatter: what was said last of each error, and is not over.
template <typename Kind>
std::map<std::string, Kind> LastOfEach(const inputs::MachineHistory& history,
                                       const std::string& (*symbol_of)(const Kind&)) {
  std::map<std::string, Kind> last;
  for (const drift::Finding& finding : history.findings) {
    const auto* const said = std::get_if<Kind>(&finding);
    if (said == nullptr) continue;
    last.erase(symbol_of(*said));
    if (!said->is_over) last.emplace(symbol_of(*said), *said);
  }
  return last;
}

void AddWearAndScatter(const inputs::MachineHistory& history, std::vector<Condition>& conditions) {
  const std::string& (*const of_slope)(const drift::Slope&) = [](const drift::Slope& slope) -> const std::string& {
    return slope.per_year.symbol;
  };
  for (const auto& [symbol, slope] : LastOfEach(history, of_slope)) {
    EventContent content;
    content.kind = EventKind::kWear;
    content.subject = symbol;
    content.text = drift::Text(slope);
    content.advice = "plan a service; a stated tolerance tells when it will be reached";
    content.amounts = {ToRecord(slope.per_year)};
    content.certainty = slope.certainty;
    conditions.push_back({std::move(content), true});
  }
  const std::string& (*const of_noise)(const drift::Noise&) = [](const drift::Noise& noise) -> const std::string& {
    return noise.symbol;
  };
  for (const auto& [symbol, noise] : LastOfEach(history, of_noise)) {
    if (noise.factor < 1) continue;  // better than stated is no harm
    EventContent content;
    content.kind = EventKind::kScatter;
    content.subject = symbol;
    content.text = drift::Text(noise);
    content.advice = "look at how the artefact is mounted, at the shop's temperature and at the stated sigma";
    conditions.push_back({std::move(content), true});
  }
}

// Of the last calibration alone.
void AddLast(const inputs::MachineHistory& history, std::vector<Condition>& conditions) {
  for (const drift::Finding& finding : history.findings) {
    EventContent content;
    if (const auto* const suspect = std::get_if<drift::Suspect>(&finding)) {
      if (suspect->at != history.state.last_at) continue;
      content.kind = EventKind::kSuspect;
      content.amounts = ToRecords(suspect->amounts);
      content.certainty = suspect->certainty;
      content.advice = "repeat the calibration before this one is used: it is a bad one, or the first after a step";
    } else if (const auto* const unstable = std::get_if<drift::Unstable>(&finding)) {
      if (unstable->at != history.state.last_at) continue;
      content.kind = EventKind::kUnstable;
      content.from = unstable->since;
      content.to = unstable->at;
      content.advice = "check fixture, probe and plan: calibrations in a row agree with nothing";
    } else {
      continue;
    }
    content.text = drift::Text(finding);
    content.calibration = history.counted.back().id;
    conditions.push_back({std::move(content), true});
  }
}

std::string TextOf(const reports::Unexplained& part) {
  std::string text;
  switch (part.kind) {
    case reports::PartKind::kLocal:
      text = "a local structure";
      break;
    case reports::PartKind::kSlip:
      text = "a slip";
      break;
    case reports::PartKind::kCheckSession:
      text = "a check session that does not fit";
      break;
    case reports::PartKind::kBadReadings:
      text = "bad readings";
      break;
    case reports::PartKind::kScatter:
      text = "scatter beyond the stated sigma";
      break;
  }
  if (!part.variable.empty() && std::isfinite(part.from) && std::isfinite(part.to))
    absl::StrAppend(&text, absl::StrFormat(" at %s = %.4g .. %.4g %s", part.variable, part.from, part.to, part.unit));
  if (!part.session.empty()) absl::StrAppend(&text, " in session ", part.session);
  if (std::isfinite(part.rms_um)) absl::StrAppend(&text, absl::StrFormat(" (%.2g um rms)", part.rms_um));
  return text;
}

void AddModelLacks(const HistoryFacts& facts, std::vector<Condition>& conditions) {
  if (!facts.newest_report || !facts.history.newest) return;
  EventContent content;
  content.kind = EventKind::kModelLacks;
  content.calibration = facts.history.newest;
  std::string what;
  const auto add = [&what](const std::string& text) { absl::StrAppend(&what, what.empty() ? "" : "; ", text); };
  const auto* const loop = std::get_if<reports::Loop>(&*facts.newest_report);
  if (loop != nullptr && loop->verdict == reports::Verdict::kUnexplained) {
    for (const reports::Unexplained& part : loop->unexplained) add(TextOf(part));
  }
  for (const reports::Warning& warning : reports::FittedOf(*facts.newest_report).warnings) {
    if (warning.kind == reports::WarningKind::kScatter) add(warning.text);
  }
  if (what.empty()) return;
  content.text = absl::StrCat("the model of calibration ", facts.history.newest->number(),
                              " does not explain its readings: ", what);
  content.advice = loop == nullptr ? "close the loop on its sessions (axiscal close-loop)" : "look at its report";
  if (loop != nullptr) {
    for (const reports::Proposal& proposal : loop->next_measurement) {
      if (!proposal.test) continue;
      content.advice = "measure next: " + proposal.test->text;
      break;
    }
  }
  conditions.push_back({std::move(content), true});
}

void AddRoutines(const HistoryFacts& facts, std::vector<Condition>& conditions) {
  for (const records::RoutineRun& run : facts.runs) {
    EventContent content;
    content.subject = run.routine;
    content.calibration = run.calibration;
    if (run.state == records::RunState::kFailed) {
      content.kind = EventKind::kRoutineFailed;
      content.text = absl::StrCat("routine ", run.routine, " failed (run ", run.id.number(), "): ", run.text);
      content.advice = "mend what it says; then axiscal routine retry, or wait for the next sessions";
    } else if (run.state == records::RunState::kProposed && run.calibration &&
               facts.candidates.contains(*run.calibration)) {
      content.kind = EventKind::kRoutineProposes;
      content.text =
          absl::StrCat("routine ", run.routine, " proposes calibration ", run.calibration->number(), ": ", run.text);
      content.advice = "look at it, then approve it or retire it";
    } else {
      continue;
    }
    conditions.push_back({std::move(content), true});
  }
}

void AddRejected(const HistoryFacts& facts, std::vector<Condition>& conditions) {
  if (!facts.on_rejected) return;
  EventContent content;
  content.kind = EventKind::kSessionRejected;
  const std::string sessions =
      absl::StrJoin(facts.on_rejected->rejected_sessions, ", ",
                    [](std::string* text, const SessionId& id) { absl::StrAppend(text, id.number()); });
  content.text = absl::StrCat("calibration ", facts.on_rejected->id.number(), ", which is in use, stands on session ",
                              sessions, ", which was rejected");
  content.advice = "identify again without it and approve that, or go back to an older calibration";
  content.calibration = facts.on_rejected->id;
  conditions.push_back({std::move(content), true});
}

// An error of this machine against the same of the others of a group.
void AddUnlikeGroup(const HistoryFacts& facts, std::vector<Condition>& conditions) {
  struct Compared {
    std::string group, symbol;
    Newest newest;
    size_t peers = 0;
    drift::Unlikeness unlike;
  };
  std::vector<Compared> all;
  std::set<std::string> own;
  for (const records::CalibrationRecord& record : facts.history.counted)
    for (const records::Estimate& estimate : record.content.estimates) own.insert(estimate.symbol);
  for (const auto& [group, rows] : facts.peers) {
    for (const std::string& symbol : own) {
      const Newest newest = NewestOf(facts.history, symbol);
      if (newest.estimate == nullptr) continue;
      std::vector<double> peers;
      for (const records::FleetRow& row : rows) {
        for (const records::LatestEstimate& latest : row.latest) {
          const records::Estimate& estimate = latest.estimate;
          if (estimate.symbol == symbol && estimate.unit == newest.estimate->unit && estimate.value)
            peers.push_back(*estimate.value);
        }
      }
      const std::optional<drift::Unlikeness> unlike =
          drift::UnlikePeers(*newest.estimate->value, *newest.estimate->sigma, peers);
      if (unlike) all.push_back({group, symbol, newest, peers.size(), *unlike});
    }
  }
  std::map<std::string, const Compared*> worst;  // of each error, over the groups
  for (const Compared& one : all) {
    const Compared*& kept = worst[one.symbol];
    if (kept == nullptr || one.unlike.probability < kept->unlike.probability) kept = &one;
  }
  for (const auto& [symbol, one] : worst) {
    const double by_chance = one->unlike.probability * static_cast<double>(all.size());
    if (by_chance >= kUnlikeKeeps) continue;
    const std::string unit = UnitText(one->newest.estimate->unit);
    Condition condition;
    condition.raises = by_chance < kUnlikeRaises;
    EventContent& content = condition.content;
    content.kind = EventKind::kUnlikeGroup;
    content.subject = symbol;
    content.text =
        absl::StrFormat("%s is %.4g +- %.2g %s; the %d others of group %s have %.4g, standard deviation %.2g %s",
                        symbol, *one->newest.estimate->value, *one->newest.estimate->sigma, unit, one->peers,
                        one->group, one->unlike.usual, one->unlike.spread, unit);
    content.advice =
        "look for what sets this machine apart: a collision, its foundation, its set-up, another test plan";
    content.amounts = {{symbol, one->newest.estimate->unit, one->unlike.away, one->unlike.sigma}};
    content.certainty = 1.0 - by_chance;
    content.calibration = one->newest.calibration->id;
    conditions.push_back(std::move(condition));
  }
}

// A silent cell's last word stays what it was.
void AddConditionsOf(const records::CellRecord& cell, std::vector<Condition>& conditions) {
  EventContent content;
  content.subject = cell.report.name;
  if (cell.is_silent()) {
    content.kind = EventKind::kCellSilent;
    content.text = absl::StrCat("cell ", cell.report.name, " has said nothing for longer than ",
                                cell.report.silent_after.count() / 60, " minutes, the last time on ",
                                inputs::DayText(cell.reported_at));
    content.advice =
        "look at the PC beside the machine: power, network, systemctl status axiscal-cell; where it is gone "
        "for good: axiscal cells forget";
    content.from = cell.reported_at;
    conditions.push_back({content, true});
    content.from.reset();
  }
  if (cell.report.problem.empty()) return;
  content.kind = EventKind::kCellProblem;
  content.text = absl::StrCat("cell ", cell.report.name, ": ", cell.report.problem);
  content.advice = "its status file says all (docs/cell.md); what it has refused: axiscal spool list on that PC";
  conditions.push_back({std::move(content), true});
}

}  // namespace

std::vector<storage::StandingFinding> StandingFindings(const inputs::MachineHistory& history,
                                                       std::optional<base::UtcTime> in_use) {
  std::vector<storage::StandingFinding> standing;
  for (const drift::StepChange& step : StandingSteps(history)) {
    if (!in_use || step.by > *in_use) standing.push_back({records::DriftKind::kStep, step.found_at, drift::Text(step)});
  }
  if (!standing.empty()) return standing;  // a doubt that became a jump is told by the jump
  if (in_use && history.state.last_at <= *in_use) return standing;
  for (const drift::Finding& finding : history.findings) {
    const auto* const suspect = std::get_if<drift::Suspect>(&finding);
    const auto* const unstable = std::get_if<drift::Unstable>(&finding);
    if (suspect != nullptr && suspect->at == history.state.last_at)
      standing.push_back({records::DriftKind::kSuspect, suspect->at, drift::Text(finding)});
    if (unstable != nullptr && unstable->at == history.state.last_at)
      standing.push_back({records::DriftKind::kUnstable, unstable->at, drift::Text(finding)});
  }
  return standing;
}

std::vector<Condition> ConditionsOf(const HistoryFacts& facts) {
  std::vector<Condition> conditions;
  AddTolerances(facts, conditions);
  AddSteps(facts, conditions);
  AddLast(facts.history, conditions);
  AddWearAndScatter(facts.history, conditions);
  AddModelLacks(facts, conditions);
  AddRoutines(facts, conditions);
  AddRejected(facts, conditions);
  AddUnlikeGroup(facts, conditions);
  return conditions;
}

std::vector<Condition> ConditionsOf(const TimeFacts& facts) {
  std::vector<Condition> conditions;
  for (const records::CellRecord& cell : facts.cells) AddConditionsOf(cell, conditions);
  const records::Expectations& expected = facts.expected.content;
  if (!facts.expected.changed_at) return conditions;
  if (expected.calibration_days) {
    const std::chrono::days most(*expected.calibration_days);
    const base::UtcTime due = facts.approved_measured_at.value_or(*facts.expected.changed_at) + most;
    if (facts.now > due) {
      EventContent content;
      content.kind = EventKind::kCalibrationOld;
      content.text =
          facts.approved
              ? absl::StrCat("calibration ", facts.approved->number(), ", which is in use, was measured on ",
                             inputs::DayText(*facts.approved_measured_at), ": more than ", most.count(), " days ago")
              : absl::StrCat("no calibration is in use, and one is expected every ", most.count(), " days");
      content.advice = "measure, identify and approve a new calibration";
      content.calibration = facts.approved;
      content.to = due;
      conditions.push_back({std::move(content), true});
    }
  }
  for (const records::ExpectedSession& session : expected.sessions) {
    const auto newest = facts.newest_sessions.find(session.name);
    const bool has_any = newest != facts.newest_sessions.end() && newest->second.has_value();
    const base::UtcTime last = has_any ? *newest->second : *facts.expected.changed_at;
    const base::UtcTime due = last + std::chrono::hours(session.every_hours);
    if (facts.now <= due) continue;
    EventContent content;
    content.kind = EventKind::kSessionMissed;
    content.subject = session.name;
    content.text = absl::StrCat("session ", session.name, " is expected every ", session.every_hours, " h; ",
                                has_any ? "the last one is of " + inputs::DayText(last) : "none has come yet");
    content.advice = "run its measuring program, or look why its session has not come";
    content.to = due;
    conditions.push_back({std::move(content), true});
  }
  return conditions;
}

std::string WhyCleared(EventKind kind) {
  switch (kind) {
    case EventKind::kOutOfTolerance:
      return "measured inside its tolerance, or no tolerance is stated any more";
    case EventKind::kLimitForecast:
      return "no longer foretold";
    case EventKind::kStep:
      return "the history shows it no longer: it went back, or a mark explains it";
    case EventKind::kSuspect:
      return "another calibration has followed";
    case EventKind::kUnstable:
      return "another calibration has followed";
    case EventKind::kWear:
    case EventKind::kScatter:
      return "no longer so";
    case EventKind::kCalibrationOld:
      return "a younger calibration is in use, or none is expected any more";
    case EventKind::kSessionMissed:
      return "it has come, or is not expected any more";
    case EventKind::kCellSilent:
      return "it was heard again, or is forgotten";
    case EventKind::kCellProblem:
      return "it says that all is well, or is forgotten";
    case EventKind::kModelLacks:
      return "the newest calibration explains its readings";
    case EventKind::kRoutineFailed:
      return "the routine has run again, was stopped or removed";
    case EventKind::kRoutineProposes:
      return "it was approved or retired, or the routine has run again, was stopped or removed";
    case EventKind::kSessionRejected:
      return "another calibration is in use, or the session counts again";
    case EventKind::kUnlikeGroup:
      return "no longer so";
  }
  return "no longer so";
}

}  // namespace axiscal::watch
