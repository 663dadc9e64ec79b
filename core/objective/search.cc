#include "core/objective/search.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace axiscal::objective {
namespace {

State Without(const State& state, size_t member) {
  State others = state;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(member));
  return others;
}

State With(State state, const Member& member) {
  state.push_back(member);
  return state;
}

}  // namespace

std::set<int> Searcher::GroupsOf(const State& state) {
  std::set<int> groups;
  for (const Member& one : state) groups.insert(one.group);
  return groups;
}

double Searcher::DesignOf(const State& state, double design) { return design_->Of(scorer_->ResidualOf(state, design)); }

bool Searcher::IsIt(int a, int b) const { return scorer_->OriginOf(a) == scorer_->OriginOf(b); }

int Searcher::CountedOf(const State& state) const {
  return static_cast<int>(std::count_if(state.begin(), state.end(),
                                        [&](const Member& one) { return scorer_->group(one.group).is_counted; }));
}

// D of what is left now, and the objective at it.
void Searcher::Settle(Found* found) {
  found->design = DesignOf(found->state, found->design);
  scorer_->RefineVariances(found->design, &found->state);
  found->objective = scorer_->ScoreOf(found->state, found->design).objective;
}

bool Searcher::DropAt(double design, State* state, double* objective) {
  bool any = false;
  while (!state->empty()) {
    size_t best = 0;
    double least = *objective;
    for (size_t i = 0; i < state->size(); ++i) {
      const double without = scorer_->ScoreOf(Without(*state, i), design).objective;
      if (without < least) {
        least = without;
        best = i + 1;
      }
    }
    if (best == 0) break;
    *state = Without(*state, best - 1);
    *objective = least;
    any = true;
  }
  return any;
}

bool Searcher::AddBest(const std::vector<bool>& allowed, Found* found) {
  for (const Move& move : scorer_->Additions(found->state, found->design, allowed, 1)) {
    if (!(move.objective < found->objective)) return false;
    State more = With(found->state, move.member);
    const double objective = scorer_->ScoreOf(more, found->design).objective;
    if (!(objective < found->objective)) return false;
    found->state = std::move(more);
    found->objective = objective;
    RefinePlace(found->state.size() - 1, found);
    return true;
  }
  return false;
}

void Searcher::RefinePlace(size_t member, Found* found) {
  if (scorer_->RefinePlace(member, found->design, &found->state))
    found->objective = scorer_->ScoreOf(found->state, found->design).objective;
}

// One strong effect alone makes what is left of it go together in clusters, and so hides itself behind a large D. Taken
// as true, it must explain that too: both states are compared at the D that the larger one leaves.
bool Searcher::AddIfItExplainsTheDesign(const std::vector<bool>& allowed, Found* found) {
  constexpr double kNothingToExplain = 1.05;
  if (found->design < kNothingToExplain || !HasRoom(found->state)) return false;
  for (const Move& move : scorer_->Additions(found->state, found->design, allowed, scorer_->policy().trials)) {
    State more = With(found->state, move.member);
    if (!scorer_->ScoreOf(more, found->design).is_possible) continue;
    const double design = DesignOf(more, found->design);
    const double objective = scorer_->ScoreOf(more, design).objective;
    if (design < found->design && objective < scorer_->ScoreOf(found->state, design).objective) {
      *found = {std::move(more), objective, design};
      return true;
    }
  }
  return false;
}

bool Searcher::Drop(Found* found) { return DropAt(found->design, &found->state, &found->objective); }

bool Searcher::Replace(const std::vector<bool>& allowed, Found* found) {
  bool any = false;
  for (size_t i = 0; i < found->state.size(); ++i) {
    const State others = Without(found->state, i);
    scorer_->Keep(found->state, found->design);
    for (const Move& move : scorer_->Additions(others, found->design, allowed, 2)) {
      if (IsIt(move.member.group, found->state[i].group)) continue;
      if (!(move.objective < found->objective - scorer_->policy().replacement_gain)) break;
      State changed = found->state;
      changed[i] = move.member;
      const double objective = scorer_->ScoreOf(changed, found->design).objective;
      if (!(objective < found->objective - scorer_->policy().replacement_gain)) break;
      found->state = std::move(changed);
      found->objective = objective;
      RefinePlace(i, found);
      any = true;
      break;
    }
  }
  return any;
}

// One effect for two or more: an addition that does not pay until those leave that it makes superfluous.
bool Searcher::Merge(const std::vector<bool>& allowed, Found* found) {
  if (found->state.size() < 2) return false;
  for (const Move& move : scorer_->Additions(found->state, found->design, allowed, scorer_->policy().trials)) {
    State more = With(found->state, move.member);
    double objective = scorer_->ScoreOf(more, found->design).objective;
    if (!std::isfinite(objective)) continue;
    DropAt(found->design, &more, &objective);
    if (CountedOf(more) > scorer_->policy().most_effects) continue;
    if (objective < found->objective - scorer_->policy().replacement_gain) {
      found->state = std::move(more);
      found->objective = objective;
      return true;
    }
  }
  return false;
}

bool Searcher::Improve(const std::vector<bool>& allowed, Found* found) {
  bool any = false;
  Passed passed;  // as D changes with the state, two could each be better in the other's place
  while (HasRoom(found->state) && !IsCancelled() && AddBest(allowed, found)) {
    any = true;
    Drop(found);
    // What is left goes together less with every effect that was found: faint ones show.
    Settle(found);
    if (!passed.insert(GroupsOf(found->state)).second) break;
  }
  for (size_t i = 0; i < found->state.size(); ++i) RefinePlace(i, found);
  any |= Drop(found);
  any |= Replace(allowed, found);
  any |= Merge(allowed, found);
  return any;
}

std::optional<Found> Searcher::Climb(State state, const std::vector<bool>& allowed, Passed* passed) {
  Found found{std::move(state)};
  Settle(&found);
  Passed own = {GroupsOf(found.state)};
  constexpr int kRounds = 30;  // each must lower the objective or D: a bound for rounding
  for (int round = 0; round < kRounds && !IsCancelled(); ++round) {
    // Where another climb has been this one ends as that did.
    if (passed->contains(GroupsOf(found.state))) return std::nullopt;
    const bool any = Improve(allowed, &found);
    Settle(&found);
    if (any) {
      if (!own.insert(GroupsOf(found.state)).second) break;
      continue;
    }
    if (!AddIfItExplainsTheDesign(allowed, &found)) break;
    Settle(&found);
    own.insert(GroupsOf(found.state));
  }
  passed->merge(own);
  return found;
}

// Inside the climb this would throw out true effects whose rivals are not there yet: at the end only.
void Searcher::Prune(Found* found) {
  while (!found->state.empty()) {
    const Eigen::VectorXd residual = scorer_->ResidualOf(found->state, found->design);
    double worst = 0.0;
    size_t which = 0;
    for (size_t i = 0; i < found->state.size(); ++i) {
      const double price = scorer_->PriceOf(found->state[i].group, found->design);
      const double own = std::max(1.0, design_->OfGroup(found->state[i].group, residual) / found->design);
      const double without = scorer_->ScoreOf(Without(found->state, i), found->design).objective;
      const double worth = (without - found->objective + price) / own - price;
      if (worth >= worst) continue;
      worst = worth;
      which = i + 1;
    }
    if (which == 0) return;
    found->state = Without(found->state, which - 1);
    Settle(found);
  }
}

Found Searcher::Search(const std::vector<Start>& starts) {
  std::vector<Found> ends;
  Passed passed_with_all;
  const auto is_known = [&ends](const State& state) {
    return std::any_of(ends.begin(), ends.end(),
                       [&](const Found& end) { return GroupsOf(end.state) == GroupsOf(state); });
  };
  for (const Start& start : starts) {
    std::vector<bool> allowed(scorer_->group_count(), true);
    for (int g = 0; g < scorer_->group_count(); ++g)
      allowed[g] =
          std::find(start.without.begin(), start.without.end(), scorer_->group(g).family) == start.without.end();
    Found empty{start.state};
    Settle(&empty);
    std::vector<State> begins = {start.state};
    const int beam = scorer_->policy().beam;
    constexpr int kLooks = 10;  // per beginning: the best are often one effect by many names
    const std::vector<Move> first = scorer_->Additions(start.state, empty.design, allowed, kLooks * beam);
    for (size_t k = 1; k < first.size() && static_cast<int>(begins.size()) < beam; ++k) {
      if (!(first[k].objective < empty.objective)) break;
      // What explains as much and stops paying beside another beginning is that by another name: a replacement finds
      // it.
      constexpr double kAsMuch = 0.9;
      const State other = With(start.state, first[k].member);
      const bool is_known_by_name = std::any_of(begins.begin(), begins.end(), [&](const State& begin) {
        const Member& known = begin.size() > start.state.size() ? begin.back() : first[0].member;
        const double alone = scorer_->ScoreOf(With(start.state, known), empty.design).objective;
        const double both = scorer_->ScoreOf(With(other, known), empty.design).objective;
        return !(both < alone) && empty.objective - first[k].objective > kAsMuch * (empty.objective - alone);
      });
      if (!is_known_by_name) begins.push_back(other);
    }
    Passed passed;
    for (State& begin : begins) {
      if (IsCancelled()) break;
      std::optional<Found> found = Climb(std::move(begin), allowed, &passed);
      if (found && !start.without.empty()) found = Climb(found->state, {}, &passed_with_all);
      if (!found) continue;
      Prune(&*found);
      if (!is_known(found->state)) ends.push_back(*std::move(found));
    }
    if (start.without.empty()) passed_with_all.merge(passed);
  }
  if (ends.empty()) {  // cancelled
    Found& start = ends.emplace_back(Found{starts.front().state});
    Settle(&start);
  }
  double design = std::numeric_limits<double>::infinity();
  for (const Found& end : ends) design = std::min(design, end.design);
  const Found* best = &ends.front();
  double least = std::numeric_limits<double>::infinity();
  for (const Found& end : ends) {
    const double objective = scorer_->ScoreOf(end.state, design).objective;
    if (objective < least) {
      least = objective;
      best = &end;
    }
  }
  return *best;
}

// The same form of effect elsewhere (on another joint) looks alike only at the member's own place, not at those of a
// grid.
void Searcher::AddAtPlaceOf(int member, const State& others, double design, double limit, std::vector<Move>* members) {
  const Group own = scorer_->group(member);
  if (!(own.reach > 0.0) || own.form < 0) return;
  std::map<int, int> nearest;  // per kin
  const int count = scorer_->group_count();
  for (int g = 0; g < count; ++g) {
    const Group& one = scorer_->group(g);
    if (one.form != own.form || one.kin == own.kin || one.kin < 0 || !(one.reach > 0.0) || !scorer_->IsVisible(g))
      continue;
    const auto [place, is_new] = nearest.try_emplace(one.kin, g);
    if (!is_new && std::abs(one.place - own.place) < std::abs(scorer_->group(place->second).place - own.place))
      place->second = g;
  }
  for (const auto& [kin, g] : nearest) {
    std::unique_ptr<Source> moved = scorer_->MovedTo(g, own.place);
    if (moved == nullptr) continue;
    const double objective = scorer_->ObjectiveWith(others, *moved, g, design);
    if (objective <= limit) members->push_back({{scorer_->Append(std::move(moved), g), 0.0}, objective});
  }
}

std::vector<std::vector<Move>> Searcher::ClassesOf(const Found& found, double share) {
  std::vector<std::vector<Move>> classes;
  for (size_t i = 0; i < found.state.size(); ++i) {
    const State others = Without(found.state, i);
    scorer_->Keep(found.state, found.design);  // anew where groups were appended
    const double worth = scorer_->ScoreOf(others, found.design).objective - found.objective;
    const double limit = found.objective + scorer_->policy().alike + share * std::max(0.0, worth);
    std::vector<Move> members = scorer_->AdditionsWithin(others, found.design, limit);
    AddAtPlaceOf(found.state[i].group, others, found.design, limit, &members);
    std::erase_if(members, [&](const Move& move) { return IsIt(move.member.group, found.state[i].group); });
    classes.push_back(std::move(members));
  }
  return classes;
}

}  // namespace axiscal::objective
