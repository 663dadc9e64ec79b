#include "core/loop/chooser.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace axiscal::loop {
namespace {

using machine::ErrorTerm;

// Two effects are told apart with reserve when the wrong one will fit worse by this chi-square (its own scatter,
// 2 sqrt(chi2), leaves the loop's bound for "explains as much" far behind) and their correlation is far below the
// class' bound, 0.98.
constexpr double kClearChi2 = 50.0, kClearCorrelation = 0.95;
// A margin of 1 has that reserve; of this, correlation 0.974 or chi-square 27, none.
constexpr double kJustTold = 0.53;
constexpr double kReserve = 4.0;

// 1 where two members are told apart, more with reserve, 0 where nothing tells them.
double Margin(const Separation& separation, int a, int b) {
  const double correlation = separation.Correlation(a, b);
  const double apart = (1.0 - correlation * correlation) / (1.0 - kClearCorrelation * kClearCorrelation);
  if (apart <= 0.0) return 0.0;
  return std::min(apart, std::min(separation.ExpectedChi2(a, b), separation.ExpectedChi2(b, a)) / kClearChi2);
}

}  // namespace

Chooser::Chooser(const Contest& contest, const std::vector<PlannedTest>& tests, double last_s)
    : of_(contest.rivals()),
      class_count_(contest.class_count()),
      tests_(tests),
      pairs_(contest.pairs()),
      is_chosen_(tests.size(), false),
      last_s_(last_s),
      information_(of_.information()),
      after_(tests.size()) {
  for (const PlannedTest& test : tests) added_.push_back(of_.InformationOfTest(test.rows));
  margins_ = MarginsWith(information_, last_s_);
}

bool Chooser::IsTold(double margin) const { return margin >= (is_relaxed_ ? kJustTold : 1.0); }

bool Chooser::IsDone() const {
  for (size_t p = 0; p < pairs_.size(); ++p) {
    if (pairs_[p].is_class && !IsTold(margins_[p])) return false;
  }
  return true;
}

std::optional<Proposal> Chooser::Next(bool any_instrument) {
  std::vector<size_t> open;
  std::vector<double> reachable = margins_;
  for (size_t t = 0; t < tests_.size(); ++t) {
    if (is_chosen_[t] || (!any_instrument && !tests_[t].has_used_instrument)) continue;
    open.push_back(t);
    const std::vector<double>& after = MarginsAfter(t);
    for (size_t p = 0; p < reachable.size(); ++p) reachable[p] = std::max(reachable[p], after[p]);
  }
  std::optional<size_t> best;
  Judged judged;
  for (const size_t t : open) {
    const Judged one = Judge(MarginsAfter(t), reachable, tests_[t].seconds);
    if (!one.Helps() || (best && !one.IsBetterThan(judged))) continue;
    best = t;
    judged = one;
  }
  if (!best) return std::nullopt;
  return Choose(*best, std::vector<double>(MarginsAfter(*best)));
}

std::vector<Proposal> Chooser::NextTwo() {
  std::vector<std::pair<double, size_t>> by_signal;
  const Member& effect = of_.members()[0];
  for (size_t t = 0; t < tests_.size(); ++t) {
    double signal = 0.0;
    for (size_t i = 0; i < effect.columns.size(); ++i) {
      signal += effect.amplitude[i] * effect.amplitude[i] * added_[t].matrix(effect.columns[i], effect.columns[i]);
    }
    if (!is_chosen_[t]) by_signal.push_back({-signal, t});
  }
  std::sort(by_signal.begin(), by_signal.end());
  constexpr size_t kTried = 20;
  by_signal.resize(std::min(kTried, by_signal.size()));
  std::pair<size_t, size_t> best;
  std::vector<double> best_after;
  Judged judged;
  for (size_t i = 0; i < by_signal.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const size_t t = by_signal[j].second, u = by_signal[i].second;
      Information together = information_;
      together += added_[t];
      together += added_[u];
      const std::vector<double> after = MarginsWith(together, std::max({last_s_, tests_[t].end_s, tests_[u].end_s}));
      const Judged one = Judge(after, after, tests_[t].seconds + tests_[u].seconds);
      if (!one.Helps() || (!best_after.empty() && !one.IsBetterThan(judged))) continue;
      best = {t, u};
      best_after = after;
      judged = one;
    }
  }
  if (best_after.empty()) return {};
  std::vector<Proposal> two;
  two.push_back(Choose(best.first, std::vector<double>(MarginsAfter(best.first))));
  two.push_back(Choose(best.second, best_after));
  return two;
}

std::vector<const PlannedTest*> Chooser::Chosen() const {
  std::vector<const PlannedTest*> chosen;
  for (size_t t = 0; t < tests_.size(); ++t) {
    if (is_chosen_[t]) chosen.push_back(&tests_[t]);
  }
  return chosen;
}

std::vector<ErrorTerm> Chooser::Remaining() const {
  std::vector<bool> remains(class_count_, false);
  for (size_t p = 0; p < pairs_.size(); ++p) {
    if (pairs_[p].a == 0 && pairs_[p].is_class && !(margins_[p] >= kJustTold)) remains[pairs_[p].member] = true;
  }
  std::vector<ErrorTerm> terms;
  for (int m = 1; m < class_count_; ++m) {
    if (remains[m]) terms.push_back(of_.term(m));
  }
  return terms;
}

std::vector<double> Chooser::MarginsWith(const Information& information, double last_s) const {
  const Separation separation(information, of_.members());
  std::vector<double> margins;
  for (const Pair& pair : pairs_)
    margins.push_back(pair.from_s > last_s ? kReserve : Margin(separation, pair.a, pair.b));
  return margins;
}

const std::vector<double>& Chooser::MarginsAfter(size_t test) {
  if (after_[test].empty()) {
    Information together = information_;
    together += added_[test];
    after_[test] = MarginsWith(together, std::max(last_s_, tests_[test].end_s));
  }
  return after_[test];
}

double Chooser::AloneAt(const std::vector<double>& margins) const {
  std::vector<bool> is_alone(class_count_, true);
  for (size_t p = 0; p < pairs_.size(); ++p) {
    const Pair& pair = pairs_[p];
    if (margins[p] >= (pair.is_class && !is_relaxed_ ? 1.0 : kJustTold)) continue;
    if (!pair.is_class && margins_[p] < kJustTold) continue;  // a neighbour that is no better told today
    is_alone[pair.a] = false;
    if (pair.is_class) is_alone[pair.member] = false;
  }
  double alone = 0.0;
  for (int m = 0; m < class_count_; ++m) alone += is_alone[m] ? 1.0 / (1 + m) : 0.0;
  return alone;
}

bool Chooser::Judged::Helps() const {
  // A long session tells what a short one would not, and asks for more: the next one gives it.
  constexpr double kStep = 0.3;
  return told > 0 || (told == 0 && (alone > 0.0 || (alone == 0.0 && progress > kStep)));
}

bool Chooser::Judged::IsBetterThan(const Judged& other) const {
  if (alone != other.alone) return alone > other.alone;
  if (told != other.told) return told > other.told;
  constexpr double kAlike = 0.1;
  if (std::abs(progress - other.progress) > kAlike) return progress > other.progress;
  if (std::abs(worst - other.worst) > kAlike) return worst > other.worst;
  return seconds < other.seconds;
}

Chooser::Judged Chooser::Judge(const std::vector<double>& after, const std::vector<double>& reachable,
                               double seconds) const {
  Judged judged{AloneAt(after) - AloneAt(margins_), 0, 0.0, kReserve, seconds};
  for (size_t p = 0; p < margins_.size(); ++p) {
    if (pairs_[p].is_class) {
      const int weight = pairs_[p].a == 0 ? class_count_ : 1;
      judged.told += weight * (static_cast<int>(IsTold(after[p])) - static_cast<int>(IsTold(margins_[p])));
    } else if (margins_[p] >= kJustTold && after[p] < kJustTold) {
      --judged.told;  // a neighbour comes into the class
    }
    judged.progress += std::min(1.0, after[p]) - std::min(1.0, margins_[p]);
    if (IsTold(reachable[p])) judged.worst = std::min(judged.worst, after[p]);
  }
  return judged;
}

Proposal Chooser::Choose(size_t test, const std::vector<double>& after) {
  is_chosen_[test] = true;
  Proposal proposal;
  proposal.test = tests_[test].test;
  proposal.session = tests_[test].planned.session;
  proposal.text = tests_[test].planned.text;
  proposal.beyond = tests_[test].beyond;
  const Separation before(information_, of_.members());
  information_ += added_[test];
  after_.assign(tests_.size(), {});
  last_s_ = std::max(last_s_, tests_[test].end_s);
  const Separation now(information_, of_.members());
  proposal.correlation_before = proposal.correlation_after = 0.0;
  double least_chi2 = INFINITY;
  std::vector<bool> takes_part(class_count_, false);
  for (size_t p = 0; p < pairs_.size(); ++p) {
    const auto [a, b, member, is_class, from_s] = pairs_[p];
    const bool is_just_told = margins_[p] < kJustTold && after[p] >= kJustTold;
    const bool has_reserve = margins_[p] < 1.0 && after[p] >= 1.0;
    if (!is_class || !(is_just_told || has_reserve)) continue;
    takes_part[a] = takes_part[member] = true;
    proposal.correlation_before = std::max(proposal.correlation_before, before.Correlation(a, b));
    proposal.correlation_after = std::max(proposal.correlation_after, now.Correlation(a, b));
    least_chi2 = std::min({least_chi2, now.ExpectedChi2(a, b), now.ExpectedChi2(b, a)});
  }
  for (int m = 0; m < class_count_; ++m) {
    if (takes_part[m]) proposal.separates.push_back(of_.term(m));
  }
  if (std::isfinite(least_chi2)) proposal.expected_chi2 = least_chi2;
  margins_ = after;
  proposal.remaining = Remaining();
  return proposal;
}

}  // namespace axiscal::loop
