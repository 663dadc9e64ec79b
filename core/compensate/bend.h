// How much an error term can bend along a move: what decides whether the move must be looked at for splitting.
#ifndef AXISCAL_CORE_COMPENSATE_BEND_H_
#define AXISCAL_CORE_COMPENSATE_BEND_H_

#include "core/compensate/compensator.h"
#include "core/machine/error_model.h"

namespace axiscal::compensate {

// Largest magnitude of a term along a move, of its slope and of its curvature, mm or rad; the move's parameter runs
// from 0 to 1.
struct Bend {
  double size = 0, slope = 0, curvature = 0;
};

// The least distance of a map's node to its neighbours along `axis`, mm or rad.
double GapOf(const shapes::Tabulated& map, int axis);

// A travel over which a function of a free curve of an order (shapes::Span::OrderOf) hardly bends, mm or rad.
double SmoothTravel(const shapes::Span& span, int order);

// For a term that is not constant; all axes move linearly from `from` to `to`.
Bend BendOf(const machine::ErrorTerm& term, const AxisValues& from, const AxisValues& to);

}  // namespace axiscal::compensate

#endif  // AXISCAL_CORE_COMPENSATE_BEND_H_
