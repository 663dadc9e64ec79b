// What a display rounds to: the largest step of which all readings of a session are multiples.
#ifndef AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_
#define AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_

#include "core/instruments/run.h"

namespace axiscal::instruments {

// Of one reading column; 0 where it is finer than a hundredth of the stated sigma, or where too few readings tell it
// from chance. Unit mm.
double ResolutionOf(const MeasuringRun& run, int row);

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_RESOLUTION_H_
