// What a fit must not claim, judged at the fitted point: the null space of the nominal machine (solver.h) knows neither
// where a set-up stood in the end, nor what only a weak prior says, nor how far the problem bends.
#ifndef AXISCAL_CORE_IDENTIFY_HONESTY_H_
#define AXISCAL_CORE_IDENTIFY_HONESTY_H_

#include <string>
#include <vector>

#include "core/identify/identify.h"
#include "core/identify/reduction.h"
#include "core/identify/solver.h"

namespace axiscal::identify {

// An error of this size (um, urad, um/m ... as in files) is plausible of any machine: what holding one costs is judged
// by it, and what is left uncertain by a third of it is not told.
inline constexpr double kPlausible = 300.0;

// A solution with what it left open.
struct Stand {
  // Of the null space those errors are held that nothing shows at the solution either. The others do change readings
  // there (an artefact that stands aside is touched off the middle of its faces): held at zero they would be fitted by
  // errors that are identified. They are freed, but get no number: that they show is owed to where a set-up happened to
  // stand.
  NullSpace holding;
  // More than one where the problem bends: then it may have a second minimum (a face that was touched in its middle
  // hardly tells a turn of its artefact from the turn the other way) and is solved again with turns of set-ups
  // reversed.
  std::vector<Solution> best_first;
  bool is_bent = false;
};
// From a solution that holds `null_space` on. CANCELLED as Solve().
absl::StatusOr<Stand> StandOf(const Problem& problem, Solution solution, const std::vector<Parameter>& parameters,
                              const NullSpace& null_space, const Options& options);

// Errors whose numbers are owed to weak priors of the set-up: these at least halve the variance that readings alone
// leave, and what remains is still more than a third of kPlausible.
struct OwedToPriors {
  std::vector<bool> involved;               // per error
  std::vector<Eigen::VectorXd> directions;  // each in units of the errors (mm, rad), as NullSpace::directions
};
OwedToPriors FindOwedToPriors(const Problem& problem, const Solution& solution,
                              const std::vector<Parameter>& parameters, const NullSpace& null_space,
                              const std::vector<int>& held);

// Errors whose interval would not be what linear propagation says, because the problem bends too much over it: moved by
// two standard uncertainties either way, all others refitted, an error must raise chi-square by about four; and those
// which a second minimum that chi-square hardly refuses puts elsewhere. CANCELLED as Solve().
absl::StatusOr<std::vector<bool>> FindWithoutInterval(const Problem& problem, const Solution& solution,
                                                      const Stand& stand, const std::vector<Parameter>& parameters,
                                                      double scale, const Options& options);

// Half-width of the 95 % interval in standard uncertainties: of Student's t where their scale was estimated from
// `degrees_of_freedom` readings.
double CoverageFactor(bool is_estimated, int degrees_of_freedom);

// What must be said aloud of a fit: readings that scatter about it by more than twice their stated sigma, or of which
// too many were set aside for chips; errors without an interval (`open`); and errors that have no number but, as
// something had to take up what the readings show, stand in the model at sizes that are not plausible (`open`,
// `unsupported`: per estimate). After the estimates and the model.
std::vector<Warning> WarningsOf(const Result& result, const std::vector<Parameter>& parameters,
                                const std::vector<bool>& open, const std::vector<bool>& unsupported);

// Of each session with a reading column that is rounded to a coarse step (instruments/resolution.h).
std::vector<Warning> CoarseReadings(const Problem& problem);

// The covariance of a fit takes what is held for independent of its readings. It is where the stages have no session in
// common: a set-up that both fit freely carries nothing from one to the other. Not so where the same readings gave
// both, or where errors rest on an offset that both know to a stated sigma: it is off by the same amount in both.
std::vector<Warning> SharedWithHeld(const Problem& problem, const Covariance& covariance,
                                    const std::vector<MeasuredIn>& held_from);

// The errors that the model holds at values which readings do not support: owed to weak priors, of directions that were
// freed because they show where a set-up happened to stand, or carriers of a combination that is left uncertain by a
// third of kPlausible.
std::vector<bool> FindUnsupported(const Solution& solution, const std::vector<Parameter>& parameters,
                                  const OwedToPriors& owed, const NullSpace& null_space, const std::vector<int>& held,
                                  const Covariance& covariance);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_HONESTY_H_
