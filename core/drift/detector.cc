#include "core/drift/detector.h"

#include <absl/strings/str_cat.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/drift/errors_of_state.h"
#include "core/drift/habits.h"
#include "core/drift/scales.h"
#include "core/drift/step_score.h"

namespace axiscal::drift {
namespace {

constexpr double kStepsPerYear = 0.3;                       // of a machine: collisions, repairs, settling foundations
constexpr double kLeastGapDays = 1.0, kMostGapDays = 28.0;  // between which a step grows likelier with the gap
constexpr double kDaysOfWeek = 7.0;
constexpr double kOutlierShare = 0.01;  // of calibrations
// A higher score is told as a step. Calibrations that come daily are looked at seven times as often as weekly ones and
// share their weather: they ask for more, so that false alarms in a year stay alike, and for most where it takes many
// of them to tell.
constexpr double kWeeklyAlarm = -1.5, kDailyAlarm = -0.8, kDailyAlarmOfMany = 3.0;
constexpr size_t kMany = 5;              // calibrations
constexpr int kBaseline = 4;             // calibrations before anything can be called a step
constexpr int kFirst = 26;               // calibrations in which false alarms are most frequent
constexpr double kFirstCertainty = 0.5;  // ... so that nothing is more than possible
constexpr double kLoosenMoved = 900.0;   // (30 sigma)^2 for the levels of errors that jumped
constexpr double kLoosenOthers = 1.0;    // small parts of a collision stay unnamed
constexpr double kLoosenMarked = 1e4;    // (100 sigma)^2: a person says that nothing is known any more
constexpr double kSuspicion = 400.0;     // (20 sigma)^2 for what is suspect in one calibration
constexpr int kRevisedWithin = 4;        // calibrations after a step is told
constexpr double kSameSquare = 16.0;     // (4 sigma)^2: sizes that differ by less are the same
constexpr int kMostSuspects = 6;         // in a row, after which the machine counts as unstable
constexpr double kMostVariance = 1e8;    // (10,000 sigma)^2 of a combination is as good as unknown

std::string TimeText(base::UtcTime at) { return absl::StrCat(base::ToUtcUs(at), " us UTC"); }

absl::Status CheckAgainst(const Calibration& calibration, const State& state) {
  if (state.calibrations > 0 && calibration.at <= state.last_at)
    return absl::FailedPreconditionError(absl::StrCat("calibration of ", TimeText(calibration.at),
                                                      ": must be later than the last one, of ",
                                                      TimeText(state.last_at)));
  if (state.is_marked && calibration.at < state.last_mark_at)
    return absl::FailedPreconditionError(absl::StrCat("calibration of ", TimeText(calibration.at),
                                                      ": must not be earlier than the last mark, of ",
                                                      TimeText(state.last_mark_at)));
  for (const Value& value : calibration.values) {
    for (const Followed& followed : state.errors) {
      if (followed.symbol == value.symbol && followed.unit != value.unit)
        return absl::InvalidArgumentError(
            absl::StrCat("unit of ", value.symbol, " = ", Text(value.unit), ", was ", Text(followed.unit), " before"));
    }
  }
  return absl::OkStatus();
}

// Where a combination is as good as unknown, its variance is held to what doubles can compute with.
void Limit(const std::vector<int>& seen, Eigen::MatrixXd* stated) {
  if (stated->trace() < kMostVariance) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(Eigen::MatrixXd((*stated)(seen, seen)));
  const Eigen::VectorXd values = eigen.eigenvalues().cwiseMax(0.0).cwiseMin(kMostVariance);
  const Eigen::MatrixXd limited = eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose();
  (*stated)(seen, seen) = 0.5 * (limited + limited.transpose());
}

Past PastOf(const Calibration& calibration, const std::vector<int>& places, const State& state) {
  const auto n = static_cast<Eigen::Index>(state.errors.size());
  Past past;
  past.at = calibration.at;
  past.regressors = RegressorsAt(calibration.at, calibration.temperature_celsius);
  past.seen = places;
  std::sort(past.seen.begin(), past.seen.end());
  past.y = Eigen::VectorXd::Zero(n);
  past.stated = Eigen::MatrixXd::Zero(n, n);
  past.suspicion = past.loosened = Eigen::VectorXd::Zero(n);
  for (size_t i = 0; i < places.size(); ++i) {
    const double unit = state.errors[places[i]].unit_size;
    past.y(places[i]) = calibration.values[i].value / unit;
    for (size_t k = 0; k < places.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(i), column = static_cast<Eigen::Index>(k);
      past.stated(places[i], places[k]) = 0.5 *
                                          (calibration.covariance(row, column) + calibration.covariance(column, row)) /
                                          (unit * state.errors[places[k]].unit_size);
    }
  }
  Limit(past.seen, &past.stated);
  // So that errors that are told only as one combination can be computed with.
  for (const int j : past.seen) past.stated(j, j) *= 1.0 + 1e-9;
  return past;
}

// Scores of the last calibrations.
class Window {
 public:
  Window(const std::vector<Past>& last, const Scales& scales) : last_(last), scales_(scales) {
    for (const Past& past : last) {
      noises_.push_back(NoiseOf(past.stated, scales));
      informations_.push_back(InverseOf(noises_.back(), past.seen));
    }
  }

  const Eigen::MatrixXd& noise(size_t i) const { return noises_[i]; }

  // Calibration i alone against what was expected before calibration `since`. `times`: how many calibrations share that
  // expectation.
  Evidence Alone(size_t i, size_t since, double times) const {
    const Past& past = last_[i];
    Evidence evidence;
    const Eigen::MatrixXd expected = ExpectedCovariance(since, past.at);
    evidence.information = InverseOf(noises_[i] + times * expected, past.seen);
    evidence.score = evidence.information * (Level(i, since) - last_[since].before.mean.head(past.y.size()));
    evidence.choices = static_cast<int>(past.seen.size());
    return evidence;
  }

  // The mean of all from `since` on.
  Evidence Together(size_t since) const {
    const auto n = last_[since].y.size();
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd weighed = Eigen::VectorXd::Zero(n);
    std::vector<bool> is_seen(n);
    for (size_t i = since; i < last_.size(); ++i) {
      information += informations_[i];
      weighed += informations_[i] * Level(i, since);
      for (const int j : last_[i].seen) is_seen[j] = true;
    }
    std::vector<int> seen;
    for (int j = 0; j < n; ++j) {
      if (is_seen[j]) seen.push_back(j);
    }
    const Eigen::MatrixXd covariance = InverseOf(information, seen);
    const base::UtcTime middle = last_[since].at + (last_.back().at - last_[since].at) / 2;
    Evidence evidence;
    evidence.information = InverseOf(covariance + ExpectedCovariance(since, middle), seen);
    evidence.score = evidence.information * (covariance * weighed - last_[since].before.mean.head(n));
    evidence.choices = static_cast<int>(seen.size());
    return evidence;
  }

 private:
  // What calibration i measured, less season and temperature as they were known before `since`.
  Eigen::VectorXd Level(size_t i, size_t since) const {
    return last_[i].y - Seasonal(last_[since].before, last_[i].regressors);
  }
  Eigen::MatrixXd ExpectedCovariance(size_t since, base::UtcTime at) const {
    Eigen::MatrixXd covariance = PredictedCovariance(last_[since].before, last_[since].regressors);
    covariance.diagonal() += scales_.rate * WeeksBetween(last_[since].at, at);
    return covariance;
  }

  const std::vector<Past>& last_;
  const Scales& scales_;
  std::vector<Eigen::MatrixXd> noises_, informations_;
};

// Where calibrations are `days` apart, kLeastGapDays or more, and a step shows in `calibrations`.
double AlarmAt(double days, size_t calibrations) {
  if (days >= kDaysOfWeek) return kWeeklyAlarm;
  const double daily = calibrations < kMany ? kDailyAlarm : kDailyAlarmOfMany;
  return daily + (kWeeklyAlarm - daily) * std::log(days) / std::log(kDaysOfWeek);
}

struct Alarm {
  size_t since = 0;  // the first calibration of the window after the step
  double score = 0.0;
  Shift shift;
  ShiftSize size;
};

// ln of the odds for a step before each calibration of the window; the best, where it is an alarm.
std::optional<Alarm> BestStep(const State& state, const Window& window) {
  std::optional<Alarm> best;
  const std::vector<Past>& last = state.last;
  for (size_t since = 0; since + 2 <= last.size(); ++since) {
    if (!last[since].may_start) continue;
    const Evidence evidence = window.Together(since);
    Shift shift = ChooseShift(evidence);
    if (shift.errors.empty()) continue;
    const base::UtcTime before = since > 0 ? last[since - 1].at : state.before_window;
    const double days = std::clamp(kDaysOfWeek * WeeksBetween(before, last[since].at), kLeastGapDays, kMostGapDays);
    const double alarm = AlarmAt(days, last.size() - since);
    double score = std::log(kStepsPerYear * days / 365.2425) + shift.score;
    // Outliers only lower it.
    if (score <= std::max(alarm, best ? best->score : alarm)) continue;
    for (size_t i = since; i < last.size(); ++i) {
      const Evidence alone = window.Alone(i, since, static_cast<double>(last.size() - since));
      score -= std::max(0.0, std::log(kOutlierShare) + ScoreOf(alone, shift.errors));
    }
    if (score <= std::max(alarm, best ? best->score : alarm)) continue;
    ShiftSize size = SizeOf(evidence, shift.errors);
    best = Alarm{since, score, std::move(shift), std::move(size)};
  }
  return best;
}

std::vector<Amount> AmountsOf(const std::vector<int>& errors, const ShiftSize& size, const State& state) {
  std::vector<Amount> amounts;
  for (size_t i = 0; i < errors.size(); ++i) {
    const Followed& followed = state.errors[errors[i]];
    const auto at = static_cast<Eigen::Index>(i);
    amounts.push_back({followed.symbol, followed.unit, size.size(at) * followed.unit_size,
                       std::sqrt(size.covariance(at, at)) * followed.unit_size});
  }
  return amounts;
}

// What the last calibration has elsewhere than expected, where that is no chance: the score of it.
std::optional<Alarm> SuspectIn(const State& state, const Window& window) {
  const size_t now = state.last.size() - 1;
  const Evidence evidence = window.Alone(now, now, 1.0);
  Shift shift = ChooseShift(evidence);
  const double score = std::log(kOutlierShare) + shift.score;
  if (shift.errors.empty() || score <= 0.0) return std::nullopt;
  ShiftSize size = SizeOf(evidence, shift.errors);
  return Alarm{now, score, std::move(shift), std::move(size)};
}

void DropFront(State* state) {
  for (size_t j = 0; j < state->errors.size(); ++j)
    AbsorbInto(state->last.front(), static_cast<int>(j), state->first_at, &state->errors[j].outlook);
  state->before_window = state->last.front().at;
  state->last.erase(state->last.begin());
}

// The window begins at `since`, with the levels loosened there, and is gone through again.
void Replay(size_t since, const Eigen::VectorXd& loosened, const Scales& scales, State* state) {
  for (size_t i = 0; i < since; ++i) DropFront(state);
  Joint joint = state->last.front().before;
  state->last.front().loosened += loosened;
  Loosen(loosened, &joint);
  for (size_t i = 0; i < state->last.size(); ++i) {
    Past& past = state->last[i];
    if (i > 0) Loosen(scales.rate * WeeksBetween(state->last[i - 1].at, past.at), &joint);
    past.may_start = i > 0;
    past.before = joint;
    Eigen::MatrixXd noise = NoiseOf(past.stated, scales);
    noise.diagonal() += past.suspicion;
    Update(past.regressors, past.y, noise, past.seen, &joint);
  }
  state->joint = std::move(joint);
}

// What error j measured in `past`, less season and temperature as they are known now.
double LevelOf(const Past& past, int j, const Joint& joint) { return past.y(j) - Seasonal(joint, past.regressors)(j); }

void AbsorbIntoBank(const Past& past, int j, bool is_anew, State* state) {
  Followed& followed = state->errors[j];
  const double level = LevelOf(past, j, state->joint);
  if (is_anew) Restart(level, &followed.bank);
  Absorb(level, past.stated(j, j), is_anew ? 0.0 : WeeksBetween(followed.bank_at, past.at), &followed.bank);
  followed.bank_at = past.at;
}

// Banks of errors that jumped before the window start anew with it.
void RestartBanks(const std::vector<int>& errors, State* state) {
  for (const int j : errors) {
    bool is_anew = true;
    for (const Past& past : state->last) {
      if (!std::binary_search(past.seen.begin(), past.seen.end(), j)) continue;
      AbsorbIntoBank(past, j, is_anew, state);
      is_anew = false;
    }
  }
}

StepChange StepOf(const Alarm& alarm, const State& state) {
  StepChange step;
  step.after = alarm.since > 0 ? state.last[alarm.since - 1].at : state.before_window;
  step.by = state.last[alarm.since].at;
  step.found_at = state.last_at;
  step.amounts = AmountsOf(alarm.shift.errors, alarm.size, state);
  step.score = alarm.score;
  step.certainty = CertaintyOf(alarm.score);
  step.word = WordOf(alarm.score);
  if (state.calibrations <= kFirst) {
    step.certainty = std::min(step.certainty, kFirstCertainty);
    step.word = Word::kPossible;
  }
  return step;
}

// What jumped starts anew where it is now; the rest of the window is gone through again.
void RestartAt(const Alarm& alarm, const Scales& scales, State* state) {
  Eigen::VectorXd loosened = Eigen::VectorXd::Constant(state->joint.count(), kLoosenOthers);
  for (const int j : alarm.shift.errors) {
    loosened(j) += kLoosenMoved;
    for (size_t i = alarm.since; i < state->last.size(); ++i) state->last[i].suspicion(j) = 0.0;
  }
  Replay(alarm.since, loosened, scales, state);
  RestartBanks(alarm.shift.errors, state);
}

// Nothing jumps but what was told as a jump just now: that had bad calibrations in it, and is told better now.
bool Revises(const Alarm& alarm, const State& state) {
  const std::vector<int>& errors = alarm.shift.errors;
  return state.told.found > 0 && state.calibrations - state.told.found <= kRevisedWithin &&
         std::all_of(errors.begin(), errors.end(), [&](int j) { return state.told.variances(j) > 0.0; });
}

// The told step with what the alarm adds to it. It is taken back where nothing is left of it.
Finding Revise(const Alarm& alarm, StepChange step, State* state) {
  ToldStep& told = state->told;
  bool is_nothing_left = true;
  for (size_t i = 0; i < alarm.shift.errors.size(); ++i) {
    const int j = alarm.shift.errors[i];
    const auto at = static_cast<Eigen::Index>(i);
    told.sizes(j) += alarm.size.size(at);
    const double variance = told.variances(j) + alarm.size.covariance(at, at);
    is_nothing_left &= told.sizes(j) * told.sizes(j) <= kSameSquare * variance;
    told.variances(j) = alarm.size.covariance(at, at);
  }
  if (is_nothing_left) {
    Retraction retraction{told.after, told.by, state->last_at, {}};
    for (const Amount& amount : step.amounts) retraction.symbols.push_back(amount.symbol);
    told.found = 0;
    return retraction;
  }
  step.is_revision = true;
  step.after = told.after;
  step.by = told.by;
  step.amounts.clear();
  for (Eigen::Index j = 0; j < told.sizes.size(); ++j) {
    if (told.variances(j) == 0.0) continue;
    const Followed& followed = state->errors[static_cast<size_t>(j)];
    step.amounts.push_back({followed.symbol, followed.unit, told.sizes(j) * followed.unit_size,
                            std::sqrt(told.variances(j)) * followed.unit_size});
  }
  return step;
}

Finding TellStep(const Alarm& alarm, State* state) {
  const StepChange step = StepOf(alarm, *state);
  if (Revises(alarm, *state)) return Revise(alarm, step, state);
  state->told = {step.after, step.by, state->calibrations, Eigen::VectorXd::Zero(state->joint.count()),
                 Eigen::VectorXd::Zero(state->joint.count())};
  for (size_t i = 0; i < alarm.shift.errors.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    state->told.sizes(alarm.shift.errors[i]) = alarm.size.size(at);
    state->told.variances(alarm.shift.errors[i]) = alarm.size.covariance(at, at);
  }
  return step;
}

// Suspects in a row that agree with nothing: all levels start anew at the last calibration.
void GiveUp(const Scales& scales, State* state) {
  std::vector<int> all(state->errors.size());
  std::iota(all.begin(), all.end(), 0);
  state->last.back().suspicion.setZero();
  const Eigen::VectorXd loosened = Eigen::VectorXd::Constant(state->joint.count(), kLoosenMoved);
  Replay(state->last.size() - 1, loosened, scales, state);
  RestartBanks(all, state);
}

// What marks have ended since the last calibration, before `past`.
void Obey(Past* past, State* state) {
  if (state->mark_loosens.maxCoeff() > 0.0) {
    while (!state->last.empty()) DropFront(state);
    past->loosened = state->mark_loosens;
    past->is_wear_new = state->is_service;
    past->may_start = false;
    Loosen(state->mark_loosens, &state->joint);
    state->mark_loosens.setZero();
  }
  state->is_service = false;
}

}  // namespace

absl::StatusOr<std::vector<Finding>> Advance(const Calibration& calibration, State* state) {
  RETURN_IF_ERROR(Check(calibration));
  RETURN_IF_ERROR(CheckAgainst(calibration, *state));
  const base::UtcTime before = state->last_at;
  if (state->calibrations == 0) state->first_at = state->before_window = calibration.at;
  const double weeks = state->calibrations == 0 ? 0.0 : WeeksBetween(before, calibration.at);
  state->last_at = calibration.at;
  ++state->calibrations;
  const std::vector<int> places = Follow(calibration, state);
  const Scales scales = ScalesOf(*state);
  Past now = PastOf(calibration, places, *state);
  now.may_start = state->calibrations > kBaseline;
  Loosen(scales.rate * weeks, &state->joint);
  std::vector<int> marked;
  for (int j = 0; j < state->joint.count(); ++j) {
    if (state->mark_loosens(j) > 0.0) marked.push_back(j);
  }
  Obey(&now, state);
  now.before = state->joint;
  if (state->last.size() == kWindow) DropFront(state);
  state->last.push_back(std::move(now));

  std::vector<Finding> findings;
  const Window window(state->last, scales);
  const std::optional<Alarm> suspect = state->calibrations > kBaseline ? SuspectIn(*state, window) : std::nullopt;
  if (suspect) {
    for (const int j : suspect->shift.errors) state->last.back().suspicion(j) = kSuspicion;
    if (state->suspects_in_a_row++ == 0) state->suspect_since = calibration.at;
  } else {
    state->suspects_in_a_row = 0;
  }
  const std::optional<Alarm> step = BestStep(*state, window);
  std::vector<int> restarted;
  if (step) {
    findings.push_back(TellStep(*step, state));
    RestartAt(*step, scales, state);
    restarted = step->shift.errors;
    state->suspects_in_a_row = 0;
  } else if (state->suspects_in_a_row >= kMostSuspects) {
    findings.push_back(Unstable{state->suspect_since, calibration.at});
    GiveUp(scales, state);
    restarted = state->last.back().seen;
    state->suspects_in_a_row = 0;
  } else {
    if (suspect)
      findings.push_back(Suspect{calibration.at, AmountsOf(suspect->shift.errors, suspect->size, *state),
                                 1.0 / (1.0 + std::exp(-suspect->score))});
    const Past& last = state->last.back();
    Eigen::MatrixXd noise = window.noise(state->last.size() - 1);
    noise.diagonal() += last.suspicion;
    Update(last.regressors, last.y, noise, last.seen, &state->joint);
  }
  for (const int j : state->last.back().seen) {
    if (std::find(restarted.begin(), restarted.end(), j) != restarted.end()) continue;
    const bool is_marked = std::find(marked.begin(), marked.end(), j) != marked.end();
    AbsorbIntoBank(state->last.back(), j, is_marked, state);
  }
  // Habits change slowly: once a week is enough for calibrations that come daily.
  if (std::floor(WeeksBetween(state->first_at, before)) < std::floor(WeeksBetween(state->first_at, calibration.at))) {
    for (Finding& habit : TellHabits(scales, state)) findings.push_back(std::move(habit));
  }
  return findings;
}

absl::Status Put(const Mark& mark, State* state) {
  if (state->calibrations > 0 && mark.at < state->last_at)
    return absl::FailedPreconditionError(absl::StrCat("mark of ", TimeText(mark.at),
                                                      ": must not be earlier than the last calibration, of ",
                                                      TimeText(state->last_at)));
  if (state->is_marked && mark.at < state->last_mark_at)
    return absl::FailedPreconditionError(absl::StrCat(
        "mark of ", TimeText(mark.at), ": must not be earlier than the last one, of ", TimeText(state->last_mark_at)));
  for (size_t j = 0; j < state->errors.size(); ++j) {
    const bool is_meant = mark.symbols.empty() || std::find(mark.symbols.begin(), mark.symbols.end(),
                                                            state->errors[j].symbol) != mark.symbols.end();
    if (is_meant) state->mark_loosens(static_cast<Eigen::Index>(j)) = kLoosenMarked;
  }
  state->last_mark_at = mark.at;
  state->is_marked = true;
  state->is_service |= mark.kind == MarkKind::kService;
  return absl::OkStatus();
}

}  // namespace axiscal::drift
