// Simulated machines with physics beyond the terms of errors.json, and with instruments and nominal data at fault, by
// kind: what a search is judged on that shall never leave a machine worse than it was. The plans are those of
// simulated_case.h; all else is a drawn scenario (core/synthetic/scenario.h).
#ifndef AXISCAL_TESTS_RATES_PHYSICS_CASE_H_
#define AXISCAL_TESTS_RATES_PHYSICS_CASE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/loop/candidate.h"
#include "core/synthetic/scenario.h"

namespace axiscal::rates {

enum class Physics {
  kNothing,  // declared errors and dirty noise only
  kCurves,   // one to three smooth curves
  kRipple,   // one or two periods, orders that need not be whole
  kGravity,
  kCrossed,
  kHeat,  // lags of a recorded temperature, of one that nobody recorded, of the time; times a position
  kHysteresis,
  kFollowing,
  kInstrument,  // nothing wrong with the machine beyond declared errors
  kNominal,     // the same
  kMixed        // two or three kinds of effects at once
};
// "nothing", "curves" ... in the enumeration's order, ended by nullptr.
const char* const* PhysicsWords();

struct PhysicsCase {
  machine::Machine machine;  // as described
  synthetic::Scenario scenario;
  std::vector<instruments::MeasuringRun> fit, check;
  std::vector<std::string> put_in;  // names of effects, faults and nominal faults
  synthetic::SimulatedCase simulated;
  synthetic::SimulatedCase sound;  // the same with declared errors alone
  synthetic::History poses;        // of the box, with what the machine did there
};

// The case number `seed` of a kind; the same each time. Irregular sampling and dirty noise throughout.
PhysicsCase DrawPhysics(Physics kind, uint64_t seed, synthetic::Form form = synthetic::Form::kIndependent);

// What is left over the box, mm, of one who knows every effect, fault and nominal value exactly and fits what is
// declared to what remains: about the least that anybody can reach with these sessions.
double ErrorOfOneWhoKnows(const PhysicsCase& physics);

// Whether what this term says is of the kind, joint and component of the effect: what one who knows the form, but no
// number, would look for.
bool IsOfTheForm(const synthetic::Effect& effect, const machine::ErrorTerm& term);
// The same of any effect that is there; of a fault of an instrument where one has a fault.
bool IsOfTheForm(const PhysicsCase& physics, const loop::Candidate& candidate);

// Root mean square of the tool point's error over the box that remains when `model` is corrected for, less the best
// work offset and tool centre (tool length among them), mm. An empty model: the machine as it is.
double ErrorOverBox(const PhysicsCase& physics, const machine::ErrorModel& model);

}  // namespace axiscal::rates

#endif  // AXISCAL_TESTS_RATES_PHYSICS_CASE_H_
