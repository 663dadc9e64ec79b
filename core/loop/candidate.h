// An effect that the model may lack.
#ifndef AXISCAL_CORE_LOOP_CANDIDATE_H_
#define AXISCAL_CORE_LOOP_CANDIDATE_H_

#include <string>

#include "core/instruments/run.h"
#include "core/machine/error_model.h"

namespace axiscal::loop {

// Each family has a penalty for looking: the more members it has, the more evidence each of them needs.
enum class Family {
  kConstant,
  kLinear,
  kQuadratic,
  kHarmonic,
  kFineHarmonic,
  kPitch,
  kCross,
  kBacklash,
  kReversal,
  kDrift,
  kDriftExp,
  kThermal,
  kLag,
  kLobe,  // pre-travel of a touch probe
  // Of core/effects only: the dictionary has none.
  kThermalLag,
  kCurve,
  kCrossed,
  kHysteresis,  // the size of the last move
  kTimeCurve,
  kBump,        // unnamed structure along an axis
  kStep,        // unnamed: artefact or probe slipped in one session
  kInstrument,  // an instrument at fault, in all its sessions
};

// Amplitudes of an effect of the dictionary.
inline constexpr int kMostAmplitudes = 2;

// No error of the machine that has a name.
inline bool IsUnnamed(Family family) { return family >= Family::kBump; }
// Wide families, which a plain name rivals.
inline bool IsFurther(Family family) { return family >= Family::kThermalLag && family <= Family::kTimeCurve; }
// A term of the error model.
inline bool IsTerm(Family family) { return family < Family::kStep; }

struct Candidate {
  Family family = Family::kConstant;
  machine::ErrorTerm term;          // where IsTerm()
  int run = -1, first_reading = 0;  // kStep: from this reading on what `carrier` bears stands elsewhere
  int earliest = 0, latest = 0;     // kStep, once found: the first reading that may be the first_reading, the last one
  instruments::Carrier carrier = instruments::Carrier::kTable;  // kStep
  bool may_be_other = false;                                    // kStep, once found: the other carrier is as likely
  instruments::Distortion distortion = {};                      // kInstrument
};

// Without the times and temperatures that readings saw of it, which are no part of its name.
shapes::Shape Everywhere(shapes::Shape shape);

// The same component, shape and variable; decay lengths and time constants may differ, pitches by a twentieth.
bool IsSameEffect(const machine::ErrorTerm& a, const machine::ErrorTerm& b);

// Simpler first: of candidates that the data cannot tell apart, the one with the lowest number is reported.
int Complexity(const machine::Machine& machine, const Candidate& candidate);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_CANDIDATE_H_
