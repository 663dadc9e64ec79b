// The search for a set of tests, whatever it is judged by: all sets of up to two are compared, larger ones grow from
// the best and are improved by exchange of one test at a time (Fedorov, Theory of Optimal Experiments, 1972; Atkinson,
// Donev and Tobias, Optimum Experimental Designs, 2007, ch. 12).
#ifndef AXISCAL_CORE_INFORMATION_SMALLEST_SET_H_
#define AXISCAL_CORE_INFORMATION_SMALLEST_SET_H_

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace axiscal::information {

template <typename Verdict>
struct ChosenSet {
  std::vector<int> tests;  // indices from 0 to count - 1
  Verdict verdict;
};

// The smallest set of `count` tests (at least one) that tells as much as all of them together; of equal size the best.
// `judge(set)` returns a Verdict, in whose class stand
//   bool TellsLessThan(const Verdict& other) const;  // the set is too small
//   bool IsBetterThan(const Verdict& other) const;   // tells more, or as much and better; a strict order
// One or two tests are the best of all such sets; more are as good as exchange finds.
template <typename JudgeSet>
auto SmallestSet(int count, const JudgeSet& judge) -> ChosenSet<decltype(judge(std::vector<int>()))> {
  using Chosen = ChosenSet<decltype(judge(std::vector<int>()))>;
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  const auto reachable = judge(all);
  std::optional<Chosen> best;
  const auto consider = [&](std::vector<int> tests) {
    auto verdict = judge(tests);
    if (!best || verdict.IsBetterThan(best->verdict)) best = Chosen{std::move(tests), std::move(verdict)};
  };
  const auto contains = [](const std::vector<int>& tests, int test) {
    return std::find(tests.begin(), tests.end(), test) != tests.end();
  };
  for (int i = 0; i < count; ++i) consider({i});
  if (best->verdict.TellsLessThan(reachable)) {
    for (int i = 0; i < count; ++i) {
      for (int j = i + 1; j < count; ++j) consider({i, j});
    }
  }
  while (best->verdict.TellsLessThan(reachable) && static_cast<int>(best->tests.size()) < count) {
    const std::vector<int> smaller = best->tests;
    best.reset();
    for (int i = 0; i < count; ++i) {
      if (contains(smaller, i)) continue;
      std::vector<int> larger = smaller;
      larger.push_back(i);
      consider(std::move(larger));
    }
    for (bool improves = true; improves;) {
      const std::vector<int> before = best->tests;
      for (size_t place = 0; place < before.size(); ++place) {
        for (int i = 0; i < count; ++i) {
          if (contains(before, i)) continue;
          std::vector<int> other = before;
          other[place] = i;
          consider(std::move(other));
        }
      }
      improves = best->tests != before;
    }
  }
  return *std::move(best);
}

}  // namespace axiscal::information

#endif  // AXISCAL_CORE_INFORMATION_SMALLEST_SET_H_
