// One round of the loop's search: a fit, linearised, and the set of effects of least objective in what it leaves.
#ifndef AXISCAL_CORE_DECIDE_EFFECT_SEARCH_H_
#define AXISCAL_CORE_DECIDE_EFFECT_SEARCH_H_

#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/decide/close_loop.h"
#include "core/effects/catalogue.h"
#include "core/loop/extension.h"
#include "core/objective/search.h"

namespace axiscal::decide {

// What makes two sets of effects the same: names, and for slips and bad rows their places.
using Key = std::tuple<std::string, int, int>;
Key KeyOf(const machine::Machine& machine, const loop::Candidate& one);

// Scores and classes of a search, for the same effects in the order and with the terms of `extension`.
void TakeOver(const machine::Machine& machine, const loop::Extension& searched, loop::Extension* extension);

class EffectSearch {
 public:
  // All must outlive it. `declared`: the model without effects.
  EffectSearch(const machine::Machine& machine, const machine::ErrorModel& declared, const objective::Policy& policy,
               const Options& options)
      : machine_(machine), declared_(declared), policy_(policy), options_(options) {}

  // What `fit`, a fit of `extension`, lacks or has too much, from there: placed in `next`, which is empty. `first`: the
  // report to say in what the declared model lacks at first sight; may be null.
  void Run(const loop::Extension& extension, const identify::Fit& fit, loop::Report* first, loop::Extension* next);
  // From now on nothing of this kind is looked for.
  void LeaveOut(std::function<bool(const loop::Candidate&)> is_left_out) { is_left_out_ = std::move(is_left_out); }
  // The last search held as many effects as it may.
  bool has_stopped_early() const { return has_stopped_early_; }
  // loop::Report::design_effect of the last run.
  double design_effect() const { return design_effect_; }

 private:
  // What a search of thinned rows has looked at.
  struct Seen {
    const effects::Linearised* thinned = nullptr;
    std::map<int, double> looks;
  };

  // Looks for effects in rows, from those that are known, and places what it finds in `next`; how many looks it took,
  // per family. `first`: the report to say in what the declared model lacks at first sight, null where it was said.
  std::map<int, double> SearchRows(const effects::Linearised& linearised, const Seen& seen,
                                   const std::vector<loop::Candidate>& known, const std::vector<loop::BadRow>& bad_rows,
                                   loop::Report* first, loop::Extension* next);
  void Take(objective::Scorer& scorer, const objective::Found& found,
            const std::vector<std::vector<objective::Move>>& classes, const effects::Linearised& linearised,
            const effects::Catalogue& catalogue, loop::Extension* next) const;

  const machine::Machine& machine_;
  const machine::ErrorModel& declared_;
  const objective::Policy& policy_;
  const Options& options_;
  std::function<bool(const loop::Candidate&)> is_left_out_ = [](const loop::Candidate&) { return false; };
  bool has_stopped_early_ = false;
  double design_effect_ = 1.0;
};

}  // namespace axiscal::decide

#endif  // AXISCAL_CORE_DECIDE_EFFECT_SEARCH_H_
