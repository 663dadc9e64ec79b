// What a display rounds to: the largest step of which all readings of a session are multiples.
#ifndef AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_
#define AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_

#include "core/instruments/run.h"

namespace axiscal::instruments {

// Of one reading column; 0 where it is finer than a hundredth of the stated sigma, or where too few readings tell it
// from chance. Unit mm.
double ResolutionOf(const MeasuringRun& run, int row);

// Above this many stated sigmas a resolution is coarse: neighbouring readings then share what rounding takes from them.
inline constexpr double kCoarse = 2.0;

// The coarsest of the run's columns where it is coarse, 0 where none is. Unit mm.
double CoarseResolutionOf(const MeasuringRun& run);

// What rounding a coarse run's readings scatters them by: resolution / sqrt(12), mm.
double RoundingSigma(const MeasuringRun& run);

// Sigma of one reading, mm: as stated, and that of rounding beside it.
double SigmaWithRounding(const MeasuringRun& run);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_
