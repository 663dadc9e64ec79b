// The dictionary of effects, generated from the machine and the sessions: every component of every joint times every
// shape that the readings can resolve. Only the shapes are listed by hand.
#ifndef AXISCAL_CORE_LOOP_DICTIONARY_H_
#define AXISCAL_CORE_LOOP_DICTIONARY_H_

#include <vector>

#include "core/identify/problem.h"
#include "core/loop/candidate.h"

namespace axiscal::loop {

// How an axis moves in the sessions.
inline constexpr double kStandsStillMm = 1e-3, kStandsStillRad = 1e-5;

struct AxisSpan {
  double lowest = 0.0, highest = 0.0;  // mm or rad
  double finest_step = 0.0;        // median step of the session that samples it finest; 0 for an axis that stands still
  double highest_frequency = 0.0;  // that its positions as a set tell from all lower ones, rad per mm or per rad
  bool has_both_senses = false;
  bool has_speeds = false;  // more than one speed: lag is not just backlash
};

// Median of the steps by which a run moves an axis, mm or rad; 0 when it does not.
double StepOf(const machine::Machine& machine, const instruments::MeasuringRun& run, int axis);

std::vector<AxisSpan> SpansOf(const identify::Problem& problem);

// Frequencies of the pitch scan stand this share of a period (over the measured range) apart.
inline constexpr double kPitchStep = 1.0 / 3.0;
// Of a wave in the measured range, at most: a coarse search takes as long as there are of them.
inline constexpr double kMostPeriods = 100.0;

// Time of the last reading, s; 0 where none has a time.
double LastReadingS(const identify::Problem& problem);

// Time constants of warmings go up to this share of the time of the last reading: what is slower is a drift.
inline constexpr double kSlowestWarming = 0.64;
inline constexpr double kWarmings[] = {0.04, 0.08, 0.16, 0.32, kSlowestWarming};

inline constexpr double kBelowNyquist = 0.9;  // of the frequency at which two readings per period are left
inline constexpr int kHighestOrder = 400;     // of harmonics of a rotary axis

// Neighbouring moments of a slip are alike: so many of them are one look.
inline constexpr int kMomentsPerLook = 4;

// Readings between the moments at which the dictionary looks for a slip in a run.
int StepStride(const instruments::MeasuringRun& run);

// Readings before and after a slip that is looked for, at least.
inline constexpr int kSlipReadings = 6;

// Candidates that `model` does not hold already.
std::vector<Candidate> MakeDictionary(const identify::Problem& problem, const machine::ErrorModel& model);

// Half width beyond which structure along a rotary axis is not a local defect but the form of the axis, which harmonics
// of low order describe. Infinite on linear axes.
double WidestBump(const machine::Machine& machine, int axis);

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_DICTIONARY_H_
