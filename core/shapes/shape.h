// The registry of shapes: an error term is joint x component x shape. A new shape is one header with the same members
// and one entry in this variant; other rooms reach shapes through the functions below (docs/architecture.md, "A
// shape", lists the few files that name one).
#ifndef AXISCAL_CORE_SHAPES_SHAPE_H_
#define AXISCAL_CORE_SHAPES_SHAPE_H_

#include <optional>
#include <string>
#include <variant>

#include "core/shapes/acceleration.h"
#include "core/shapes/backlash.h"
#include "core/shapes/bump.h"
#include "core/shapes/constant.h"
#include "core/shapes/curve.h"
#include "core/shapes/drift.h"
#include "core/shapes/drift_exp.h"
#include "core/shapes/harmonic.h"
#include "core/shapes/lag.h"
#include "core/shapes/last_move.h"
#include "core/shapes/linear.h"
#include "core/shapes/lobe.h"
#include "core/shapes/play.h"
#include "core/shapes/quadratic.h"
#include "core/shapes/reversal.h"
#include "core/shapes/state.h"
#include "core/shapes/tabulated.h"
#include "core/shapes/thermal.h"
#include "core/shapes/thermal_lag.h"

namespace axiscal::shapes {

using Shape = std::variant<Constant, Linear, Quadratic, Harmonic, Backlash, Reversal, Drift, DriftExp, Thermal, Lag,
                           Bump, Tabulated, PreTravel, Lobe, ThermalLag, Curve, TimeCurve, Crossed, Acceleration,
                           BacklashCurve, Play, LastMove>;

// "harmonic", "drift-exp": the name in files.
std::string Name(const Shape& shape);
// Number of amplitudes that the term has (a harmonic has a cosine and a sine).
int BasisCount(const Shape& shape);
// One cosine and one sine: files have them as amplitude and phase.
inline bool HasPhase(const Shape& shape) {
  return std::holds_alternative<Harmonic>(shape) || std::holds_alternative<Lobe>(shape);
}
// Free curves, whose amplitudes have a prior: standard deviation ErrorTerm::prior_sigma x PriorRoot(shape, i) of
// amplitude i; the squares of the roots add up to 1.
bool IsFree(const Shape& shape);
double PriorRoot(const Shape& shape, int basis);
// The curve over the position of an axis that a shape is or has; nullptr of others.
const Curve* CurveOf(const Shape& shape);
// Curves of one axis and span: the functions of `coarse` are the first ones of `fine`.
bool IsBeginningOf(const Shape& coarse, const Shape& fine);
Curve* CurveOf(Shape& shape);
// The position that multiplies all of a shape's functions beside its own variable; nullptr of shapes that know none.
const Times* TimesOf(const Shape& shape);
Times* TimesOf(Shape& shape);
// Its value at a state; 1 without one.
double FactorAt(const Shape& shape, const State& state);
// The share of a free curve that is known at a state, 1 where the readings reach; 1 of other shapes.
double KeptAt(const Shape& shape, const State& state);
// True for shapes that move the tool point back along the approach of a touch, instead of one component.
inline bool IsAlongApproach(const Shape& shape) {
  return std::holds_alternative<PreTravel>(shape) || std::holds_alternative<Lobe>(shape);
}
// The axis that a shape looks at, or nothing (constant, time, temperature); the first of two.
std::optional<int> VariableAxis(const Shape& shape);
// The other axis of a shape that looks at two.
std::optional<int> SecondAxis(const Shape& shape);
// The non-linear parameter (decay length, time constant, a free frequency), or nullptr.
double* NonlinearParameter(Shape& shape);
const double* NonlinearParameter(const Shape& shape);
// The non-linear parameter is a length of the shape's axis, mm or rad.
bool HasLength(const Shape& shape);

// basis[0 .. BasisCount): the error is the sum of amplitude[i] * basis[i].
void Basis(const Shape& shape, const State& state, double* basis);
// d basis[i] / d (non-linear parameter); zero for shapes without one.
void BasisSlope(const Shape& shape, const State& state, double* slope);

}  // namespace axiscal::shapes

#endif  // AXISCAL_CORE_SHAPES_SHAPE_H_
