#include "core/loop/next_measurement.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/loop/candidate.h"
#include "core/loop/planned_tests.h"
#include "core/loop/rivals.h"
#include "core/loop/same_always.h"

namespace axiscal::loop {
namespace {

using machine::ErrorTerm;

// Two effects count as told apart when the wrong one will fit worse by this chi-square (its own scatter, 2 sqrt(chi2),
// leaves the loop's bound for "explains as much" far behind) and their correlation is clearly below the class' bound.
constexpr double kClearChi2 = 32.0, kClearCorrelation = 0.975;
constexpr size_t kMostMembers = 12;
constexpr int kMostSessions = 3;

// 1 where two members are told apart, more with reserve, 0 where nothing tells them.
double Margin(const Separation& separation, int a, int b) {
  const double chi2 = std::min(separation.ExpectedChi2(a, b), separation.ExpectedChi2(b, a));
  const double correlation = separation.Correlation(a, b);
  return std::min(chi2 / kClearChi2, (1.0 - correlation * correlation) / (1.0 - kClearCorrelation * kClearCorrelation));
}

// The class of one effect, then its neighbours.
class Class {
 public:
  Class(const identify::Problem& problem, const identify::Point& point, const ErrorTerm& effect,
        const std::vector<ErrorTerm>& equivalent) {
    std::vector<ErrorTerm> named = {effect};
    for (const ErrorTerm& other : equivalent) {
      const auto is_known = [&](const ErrorTerm& term) { return IsSameEffect(term, other); };
      const bool is_fitted = std::any_of(point.model.terms.begin(), point.model.terms.end(), is_known);
      if (!is_fitted && std::none_of(named.begin(), named.end(), is_known)) named.push_back(other);
    }
    const std::vector<int> first = FirstOfTheSame(*problem.machine, problem.runs.front().tip_mm, named);
    std::vector<ErrorTerm> terms;
    for (size_t i = 0; i < named.size(); ++i) {
      if (first[i] == 0 && i > 0) same_always_.push_back(named[i]);
      if (first[i] == static_cast<int>(i) && terms.size() < kMostMembers) terms.push_back(named[i]);
    }
    class_count_ = static_cast<int>(terms.size());
    if (class_count_ < 2) return;
    for (const ErrorTerm& neighbour : NeighboursOf(problem, point, named)) terms.push_back(neighbour);
    rivals_.emplace(problem, point, terms);
  }

  int class_count() const { return class_count_; }
  const Rivals& rivals() const { return *rivals_; }
  const std::vector<ErrorTerm>& same_always() const { return same_always_; }

 private:
  int class_count_ = 0;
  std::vector<ErrorTerm> same_always_;
  std::optional<Rivals> rivals_;  // of a class with others in it
};

struct Pair {
  int a, b;
};

// Who must be told from whom: the members of the class from each other, the reported effect from its neighbours too.
// The pairs of the effect come first.
std::vector<Pair> PairsOf(const Class& of) {
  std::vector<Pair> pairs;
  for (int b = 1; b < of.rivals().count(); ++b) pairs.push_back({0, b});
  for (int a = 1; a < of.class_count(); ++a) {
    for (int b = a + 1; b < of.class_count(); ++b) pairs.push_back({a, b});
  }
  return pairs;
}

// Greedy choice of sessions: each is judged with those chosen before it already measured.
class Chooser {
 public:
  Chooser(const Class& of, const std::vector<PlannedTest>& tests)
      : of_(of.rivals()),
        class_count_(of.class_count()),
        tests_(tests),
        pairs_(PairsOf(of)),
        is_chosen_(tests.size(), false),
        information_(of_.information()) {
    for (const PlannedTest& test : tests) added_.push_back(of_.InformationOfTest(test.problem));
    margins_ = MarginsWith(information_);
  }

  // Every pair of the class is told.
  bool IsDone() const {
    for (size_t p = 0; p < pairs_.size(); ++p) {
      if (pairs_[p].b < class_count_ && !IsTold(margins_[p])) return false;
    }
    return true;
  }

  // The session that tells most pairs apart which are not yet, or comes nearest; of equal ones that with the best worst
  // pair, then the shortest. Nothing when none helps.
  std::optional<Proposal> Next(bool any_instrument) {
    std::vector<std::vector<double>> after(tests_.size());
    std::vector<double> reachable = margins_;
    for (size_t t = 0; t < tests_.size(); ++t) {
      if (is_chosen_[t] || (!any_instrument && !tests_[t].has_used_instrument)) continue;
      Information together = information_;
      together += added_[t];
      after[t] = MarginsWith(together);
      for (size_t p = 0; p < reachable.size(); ++p) reachable[p] = std::max(reachable[p], after[t][p]);
    }
    int best = -1;
    Judged judged;
    for (size_t t = 0; t < tests_.size(); ++t) {
      if (after[t].empty()) continue;
      const Judged one = Judge(after[t], reachable, tests_[t].seconds);
      if (one.told <= 0 || (best >= 0 && !one.IsBetterThan(judged))) continue;
      best = static_cast<int>(t);
      judged = one;
    }
    if (best < 0) return std::nullopt;
    return Choose(best, after[best]);
  }

  // Two sessions that only together tell something (a warm shop with a short and with a long tool), of those in which
  // the effect shows most; the first is marked as needing the next. Empty when no two do.
  std::vector<Proposal> NextTwo() {
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
        const std::vector<double> after = MarginsWith(together);
        const Judged one = Judge(after, after, tests_[t].seconds + tests_[u].seconds);
        if (one.told <= 0 || (!best_after.empty() && !one.IsBetterThan(judged))) continue;
        best = {t, u};
        best_after = after;
        judged = one;
      }
    }
    if (best_after.empty()) return {};
    std::vector<Proposal> two;
    Information first = information_;
    first += added_[best.first];
    two.push_back(Choose(static_cast<int>(best.first), MarginsWith(first)));
    two.push_back(Choose(static_cast<int>(best.second), best_after));
    return two;
  }

  // What the reported effect is not told from.
  std::vector<ErrorTerm> Remaining() const {
    std::vector<ErrorTerm> terms;
    for (int b = 1; b < class_count_; ++b) {
      if (!IsTold(margins_[b - 1])) terms.push_back(of_.term(b));
    }
    return terms;
  }

 private:
  std::vector<double> MarginsWith(const Information& information) const {
    const Separation separation(information, of_.members());
    std::vector<double> margins;
    for (const Pair& pair : pairs_) margins.push_back(Margin(separation, pair.a, pair.b));
    return margins;
  }

  struct Judged {
    int told = 0;  // pairs of the class that it tells and that were not told before, less those that it dilutes
    double progress = 0.0;  // of the margins up to 1, neighbours too
    double worst = 0.0;     // margin of the worst pair that any test tells, capped: with that much reserve time counts
    double seconds = 0.0;

    bool IsBetterThan(const Judged& other) const {
      if (told != other.told) return told > other.told;
      constexpr double kAlike = 0.1;
      if (std::abs(progress - other.progress) > kAlike) return progress > other.progress;
      if (std::abs(worst - other.worst) > kAlike) return worst > other.worst;
      return seconds < other.seconds;
    }
  };

  static bool IsTold(double margin) { return margin >= 1.0; }

  Judged Judge(const std::vector<double>& after, const std::vector<double>& reachable, double seconds) const {
    constexpr double kReserve = 4.0;
    Judged judged{0, 0.0, kReserve, seconds};
    for (size_t p = 0; p < margins_.size(); ++p) {
      if (pairs_[p].b < class_count_)
        judged.told += static_cast<int>(IsTold(after[p])) - static_cast<int>(IsTold(margins_[p]));
      judged.progress += std::min(1.0, after[p]) - std::min(1.0, margins_[p]);
      if (IsTold(reachable[p])) judged.worst = std::min(judged.worst, after[p]);
    }
    return judged;
  }

  Proposal Choose(int test, const std::vector<double>& after) {
    is_chosen_[test] = true;
    Proposal proposal;
    proposal.test = tests_[test].test;
    proposal.session = tests_[test].planned.session;
    proposal.text = tests_[test].planned.text;
    proposal.beyond = tests_[test].beyond;
    const Separation before(information_, of_.members());
    information_ += added_[test];
    const Separation now(information_, of_.members());
    proposal.correlation_before = proposal.correlation_after = 0.0;
    double least_chi2 = INFINITY;
    std::vector<bool> takes_part(of_.count(), false);
    for (size_t p = 0; p < pairs_.size(); ++p) {
      const auto [a, b] = pairs_[p];
      if (b >= class_count_ || IsTold(margins_[p]) || !IsTold(after[p])) continue;
      takes_part[a] = takes_part[b] = true;
      proposal.correlation_before = std::max(proposal.correlation_before, before.Correlation(a, b));
      proposal.correlation_after = std::max(proposal.correlation_after, now.Correlation(a, b));
      least_chi2 = std::min({least_chi2, now.ExpectedChi2(a, b), now.ExpectedChi2(b, a)});
    }
    for (int m = 0; m < of_.count(); ++m) {
      if (takes_part[m]) proposal.separates.push_back(of_.term(m));
    }
    if (std::isfinite(least_chi2)) proposal.expected_chi2 = least_chi2;
    margins_ = after;
    proposal.remaining = Remaining();
    return proposal;
  }

  const Rivals& of_;
  const int class_count_;
  const std::vector<PlannedTest>& tests_;
  const std::vector<Pair> pairs_;
  std::vector<bool> is_chosen_;
  Information information_;
  std::vector<Information> added_;  // per test
  std::vector<double> margins_;     // of the pairs, with what is measured and chosen
};

}  // namespace

class Proposer::Tests {
 public:
  explicit Tests(const identify::Problem& problem) : list(PlanTests(problem)) {}
  const std::vector<PlannedTest> list;
};

Proposer::Proposer(const identify::Problem& problem, const identify::Point& point) : problem_(problem), point_(point) {}
Proposer::~Proposer() = default;

std::vector<Proposal> Proposer::Propose(const ErrorTerm& effect, const std::vector<ErrorTerm>& equivalent) {
  const Class of(problem_, point_, effect, equivalent);
  if (of.class_count() < 2) return {};
  if (!tests_) tests_ = std::make_unique<Tests>(problem_);
  Chooser chooser(of, tests_->list);
  if (chooser.IsDone()) return {};
  std::vector<Proposal> proposals;
  // Instruments that the shop has used come first; another one only for what those leave open; last, two that only
  // together tell something.
  for (const bool any_instrument : {false, true}) {
    while (proposals.size() < kMostSessions && !chooser.IsDone()) {
      std::optional<Proposal> next = chooser.Next(any_instrument);
      if (!next) break;
      proposals.push_back(*std::move(next));
    }
  }
  if (proposals.size() + 2 <= kMostSessions && !chooser.IsDone()) {
    for (Proposal& one : chooser.NextTwo()) proposals.push_back(std::move(one));
  }
  for (size_t i = proposals.size(); i-- > 1;) {
    Proposal& step = proposals[i - 1];
    if (!step.separates.empty()) continue;
    step.needs_next = true;
    step.separates = proposals[i].separates;
    step.correlation_before = proposals[i].correlation_before;
    step.correlation_after = proposals[i].correlation_after;
    step.expected_chi2 = proposals[i].expected_chi2;
  }
  if (proposals.empty()) {
    proposals.emplace_back();
    proposals.back().remaining = chooser.Remaining();
  }
  for (Proposal& proposal : proposals) {
    proposal.effect = effect;
    proposal.same_always = of.same_always();
  }
  return proposals;
}

}  // namespace axiscal::loop
