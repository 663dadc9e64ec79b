#include "core/loop/next_measurement.h"

#include <algorithm>
#include <utility>

#include "core/loop/chooser.h"
#include "core/loop/contest.h"
#include "core/loop/dictionary.h"
#include "core/loop/planned_tests.h"

namespace axiscal::loop {
namespace {

using machine::ErrorTerm;

constexpr size_t kMostSessions = 4;

// When the tests end, soon after one another counted once.
std::vector<double> EndsOf(const std::vector<PlannedTest>& tests) {
  std::vector<double> all, ends;
  for (const PlannedTest& test : tests) all.push_back(test.end_s);
  std::sort(all.begin(), all.end());
  constexpr double kLater = 1.3;
  for (const double end_s : all) {
    if (ends.empty() || end_s > kLater * ends.back()) ends.push_back(end_s);
  }
  return ends;
}

// What is told with reserve comes first; then instruments that the shop has used, another one only for what those leave
// open; last, two that only together tell something.
std::vector<Proposal> ChooseSessions(Chooser* chooser) {
  std::vector<Proposal> proposals;
  for (const bool is_relaxed : {false, true}) {
    if (is_relaxed) chooser->Relax();
    for (const bool any_instrument : {false, true}) {
      while (proposals.size() < kMostSessions && !chooser->IsDone()) {
        std::optional<Proposal> next = chooser->Next(any_instrument);
        if (!next) break;
        proposals.push_back(*std::move(next));
      }
    }
  }
  if (proposals.size() + 2 <= kMostSessions && !chooser->IsDone()) {
    for (Proposal& one : chooser->NextTwo()) proposals.push_back(std::move(one));
  }
  while (!proposals.empty() && proposals.back().separates.empty()) proposals.pop_back();
  return proposals;
}

}  // namespace

class Proposer::Tests {
 public:
  Tests(const identify::Problem& problem, const machine::ErrorModel& fitted)
      : list(PlanTests(problem, fitted)), ends_s(EndsOf(list)) {}
  const std::vector<PlannedTest> list;
  const std::vector<double> ends_s;
};

Proposer::Proposer(const identify::Problem& problem, const identify::Point& point) : problem_(problem), point_(point) {}
Proposer::~Proposer() = default;

std::vector<Proposal> Proposer::Propose(const ErrorTerm& effect, const std::vector<ErrorTerm>& equivalent) {
  if (equivalent.empty()) return {};
  if (!tests_) tests_ = std::make_unique<Tests>(problem_, point_.model);
  std::vector<ErrorTerm> known = {effect};
  known.insert(known.end(), equivalent.begin(), equivalent.end());
  constexpr double kNear = 0.5, kConfused = 0.7;
  const std::vector<ErrorTerm> neighbours = NeighboursOf(problem_, point_, known, kNear);
  std::vector<ErrorTerm> confused;
  std::vector<Proposal> proposals;
  std::vector<ErrorTerm> same_always;
  // What the chosen sessions would confuse with the effect, although those so far do not, must be told too.
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const Contest contest(problem_, point_, effect, equivalent, neighbours, confused, tests_->ends_s);
    if (contest.class_count() < 2) return {};
    same_always = contest.same_always();
    Chooser chooser(contest, tests_->list, LastReadingS(problem_));
    proposals = ChooseSessions(&chooser);
    if (chooser.IsDone() && proposals.empty()) return {};
    if (proposals.empty()) {
      proposals.emplace_back();
      proposals.back().remaining = chooser.Remaining();
      // The sessions so far were expected to tell them, and do not.
      if (proposals.back().remaining.empty()) proposals.back().remaining = equivalent;
      break;
    }
    if (round + 1 == kRounds) break;
    const identify::Problem together = Together(problem_, chooser.Chosen());
    identify::Point point = identify::StartingPoint(together, point_.model);
    std::copy(point_.setup.begin(), point_.setup.end(), point.setup.begin());
    std::vector<ErrorTerm> all = known;
    all.insert(all.end(), confused.begin(), confused.end());
    const size_t count = confused.size();
    for (const ErrorTerm& one : NeighboursOf(together, point, all, kConfused)) confused.push_back(one);
    if (confused.size() == count) break;
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
  for (Proposal& proposal : proposals) {
    proposal.effect = effect;
    proposal.same_always = same_always;
  }
  return proposals;
}

}  // namespace axiscal::loop
