// What can be wrong: every effect that the readings could show, as groups of columns for the objective, and what each
// group is.
#ifndef AXISCAL_CORE_EFFECTS_CATALOGUE_H_
#define AXISCAL_CORE_EFFECTS_CATALOGUE_H_

#include <memory>
#include <vector>

#include "core/effects/linearised.h"
#include "core/loop/extension.h"
#include "core/objective/source.h"

namespace axiscal::effects {

// A bad reading or what the loop knows: an error term, an instrument's fault or a slip.
struct Effect {
  loop::Candidate candidate;
  int bad_row = -1;  // of Linearised; then `candidate` has no meaning
};

struct Catalogue {
  std::vector<std::unique_ptr<objective::Source>> sources;
  std::vector<Effect> effects;  // per group of all sources
  std::vector<int> known;       // groups of the effects that were known, in their order
};

// Families of the objective beyond those of loop::Family.
inline constexpr int kToolSlipFamily = 100, kBadRowFamily = 101;

// An error, mm or rad, that no machine in use has of this kind in any reading: with one, a column that is nearly
// explained would fit anything.
double LargestErrorOf(const loop::Candidate& one);

// `known`: effects as they were fitted; of what is no different from one of them there is no other group. `declared`:
// the model without effects. Of thinned rows (thinned.h): what they tell, no bad rows. `thinned`: beside what is known,
// only what these do not tell, slips (at their very readings) and bad rows. Everything must outlive the result.
Catalogue MakeCatalogue(const Linearised& linearised, const machine::ErrorModel& declared,
                        const std::vector<loop::Candidate>& known, const std::vector<loop::BadRow>& bad_rows,
                        const Linearised* thinned = nullptr);

}  // namespace axiscal::effects

#endif  // AXISCAL_CORE_EFFECTS_CATALOGUE_H_
