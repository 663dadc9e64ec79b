// Looks for the state of least objective: add, drop, replace, merge, from a few starts.
#ifndef AXISCAL_CORE_OBJECTIVE_SEARCH_H_
#define AXISCAL_CORE_OBJECTIVE_SEARCH_H_

#include <functional>
#include <optional>
#include <set>
#include <vector>

#include "core/objective/design_effect.h"
#include "core/objective/scorer.h"

namespace axiscal::objective {

struct Found {
  State state;
  double objective = 0.0;  // at `design`
  double design = 1.0;     // D of what the state leaves
};

// One way to start: families that take part at first. Everything takes part afterwards.
struct Start {
  State state;
  std::vector<int> without;  // families left out at first
};

class Searcher {
 public:
  // All must outlive it. `cancelled` may be empty; a search that is cancelled ends with what it has.
  Searcher(Scorer* scorer, const DesignEffect* design, std::function<bool()> cancelled = {})
      : scorer_(scorer), design_(design), cancelled_(std::move(cancelled)) {}

  // From each start, and from its best few first effects; the least objective at the smallest design effect of all
  // ends.
  Found Search(const std::vector<Start>& starts);

  // What could be each member instead: per member all replacements within Policy::alike of the state, and within
  // `share` of what the member explains; best first.
  std::vector<std::vector<Move>> ClassesOf(const Found& found, double share = 0.0);

 private:
  using Passed = std::set<std::set<int>>;  // groups of states
  static std::set<int> GroupsOf(const State& state);
  // Nothing where it comes to a state that an earlier climb passed; adds what it passes.
  std::optional<Found> Climb(State state, const std::vector<bool>& allowed, Passed* passed);
  bool Improve(const std::vector<bool>& allowed, Found* found);
  bool AddBest(const std::vector<bool>& allowed, Found* found);
  bool AddIfItExplainsTheDesign(const std::vector<bool>& allowed, Found* found);
  bool Drop(Found* found);
  bool Replace(const std::vector<bool>& allowed, Found* found);
  bool Merge(const std::vector<bool>& allowed, Found* found);
  // Drops members while the objective falls; true where one went.
  bool DropAt(double design, State* state, double* objective);
  // Drops members that are worth less than their price by the design effect of their own columns.
  void Prune(Found* found);
  void AddAtPlaceOf(int member, const State& others, double design, double limit, std::vector<Move>* members);
  void RefinePlace(size_t member, Found* found);
  // Two groups that are one at two places.
  bool IsIt(int a, int b) const;
  double DesignOf(const State& state, double design);
  void Settle(Found* found);
  // Effects of a state that Policy::most_effects limits.
  int CountedOf(const State& state) const;
  // Whether one more may join.
  bool HasRoom(const State& state) const { return CountedOf(state) < scorer_->policy().most_effects; }
  bool IsCancelled() const { return cancelled_ && cancelled_(); }

  Scorer* scorer_;
  const DesignEffect* design_;
  const std::function<bool()> cancelled_;
};

}  // namespace axiscal::objective

#endif  // AXISCAL_CORE_OBJECTIVE_SEARCH_H_
