// What a display rounds to: the largest step of which all readings of a session are multiples.
#ifndef AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_
#define AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_

#include "core/instruments/run.h"

namespace axiscal::instruments {

// The resolution of one reading column, mm; 0 where it is finer than a hundredth of the stated sigma, or where the
// readings are too few to tell steps from chance.
double ResolutionOf(const MeasuringRun& run, int row);

// A resolution of more than this many stated sigmas is coarse: neighbouring readings then have like rounding errors.
inline constexpr double kCoarse = 2.0;

// The resolution of the run's coarsest column where that is coarse, mm; 0 where none is.
double CoarseResolutionOf(const MeasuringRun& run);

// Standard deviation that rounding gives the readings of a coarse run: resolution / sqrt(12), mm.
double RoundingSigma(const MeasuringRun& run);

// Sigma of one reading, mm: the stated one and that of rounding, combined.
double SigmaWithRounding(const MeasuringRun& run);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_
