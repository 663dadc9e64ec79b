// The values of effects in both forms (effect.h), before they are scaled. Within this library.
#ifndef AXISCAL_CORE_SYNTHETIC_FORMS_H_
#define AXISCAL_CORE_SYNTHETIC_FORMS_H_

#include <functional>
#include <vector>

#include "core/synthetic/effect.h"

namespace axiscal::synthetic {

// A rotary axis; -1 is none.
inline bool IsTurning(const machine::Machine& machine, int axis) {
  return axis >= 0 && machine.axes[axis].kind == machine::AxisKind::kRotary;
}

using Values = std::function<std::vector<double>(const History&)>;

// What both forms are drawn from: the effect with its defaults filled in for the plan.
struct Drawing {
  const machine::Machine& machine;
  const Surroundings& surroundings;
  const Effect& effect;
  Range range, second_range;  // of the variable (or time) and of the second axis, over the plan
};

// May set `term` of errors.json: value = the term's basis with the amplitudes of the term.
Values OwnValues(const Drawing& drawing, base::Random* random, std::optional<machine::ErrorTerm>* term);
Values IndependentValues(const Drawing& drawing, base::Random* random);

// A smooth random function of one variable.
using Function = std::function<double(double)>;
// Square root of a Matern 5/2 kernel's spectral density at a frequency, rad per unit of `length`, up to a factor.
double MaternDeviation(double frequency, double length);
// Reduced-rank Gaussian process with a Matern 5/2 kernel (Solin and Saerkkae 2020, eq 60): sines on a range 20 % wider
// on both sides, or cos nq and sin nq about a full turn.
Function OwnFunction(const Range& range, double length, bool is_rotary, base::Random* random);
// One of three by chance: Gaussian bumps, a natural cubic spline through random knots (straight beyond its ends), or
// random Fourier features of a squared exponential. Around a turn they do not close, as no curve must over less.
Function IndependentFunction(const Range& range, double length, bool is_rotary, base::Random* random);

// Signed moment about the error's own axis (angles) or force along it (shifts) of one unit weight at `centre_mm` (home,
// machine frame) that joint `body` carries; mm or 1. Errors of joints turn nothing here.
double Load(const machine::Machine& machine, const Surroundings& surroundings, const Effect& effect, int body,
            const Eigen::Vector3d& centre_mm, const double* positions);
// The joint that carries the mass.
int BodyOf(const machine::Machine& machine, const Effect& effect);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_FORMS_H_
