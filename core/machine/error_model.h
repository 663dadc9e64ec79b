// What a machine's model holds: error terms (axis x component x shape) with their amplitudes, and their sum at a state.
#ifndef AXISCAL_CORE_MACHINE_ERROR_MODEL_H_
#define AXISCAL_CORE_MACHINE_ERROR_MODEL_H_

#include <absl/status/status.h>

#include <array>
#include <string>
#include <vector>

#include "core/machine/chain.h"
#include "core/machine/machine.h"
#include "core/shapes/shape.h"

namespace axiscal::machine {

// Terms whose shape is along the approach of a touch (shapes/lobe.h) have joint tool_joint() and component kX; for them
// the component has no meaning.
struct ErrorTerm {
  int joint = 0;  // an axis, or the machine's tool_joint() or work_joint()
  Component component = Component::kX;
  shapes::Shape shape = shapes::Constant{};
  // Per basis function of the shape, mm or rad (per the shape's reference: metre, hour, degree C ...).
  std::array<double, shapes::kMaxBasisCount> amplitude = {};
  // Of a free curve (shapes::IsFree): amplitude i ~ N(0, (prior_sigma x shapes::PriorRoot(shape, i))^2), so that this
  // is the standard deviation of the curve where nothing was measured, mm or rad. 0: the amplitudes are free.
  double prior_sigma = 0.0;

  bool operator==(const ErrorTerm&) const = default;
};

struct ErrorModel {
  std::vector<ErrorTerm> terms;
};

// The position of an axis as a factor, in the unit that files have of it: per metre or per radian.
shapes::Times TimesPositionOf(const Machine& machine, int axis);
// The component along or about which an axis itself moves: X of EXX, C of ECC.
Component PositioningOf(const Machine& machine, int axis);
// The constant term of a symbol. DEMANDs that the machine has the joint.
ErrorTerm ConstantTerm(const Machine& machine, const ErrorSymbol& symbol, double amplitude = 0.0);
// The declared constant errors, all zero.
ErrorModel DeclaredModel(const Machine& machine);
// Not a local defect (shapes::Bump): structure without a name is nothing to compensate.
bool HasName(const ErrorTerm& term);
// What is written and corrected of a model: terms with a name.
ErrorModel NamedErrors(ErrorModel model);

// "EX0C" for a constant term, "EXC" for the others; "ERT" along the approach of a touch (R: as the probe radiates).
std::string SymbolOf(const Machine& machine, const ErrorTerm& term);
// A unique readable name: "EX0C", "EXX:backlash", "EBB:harmonic(45)", with the variable where it is not the term's own
// axis: "EZT:thermal", "EBY:linear(Z)".
std::string NameOf(const Machine& machine, const ErrorTerm& term);
// Of every term of a model: that name, the second one of a name with "#2" behind it. Two terms of one component that
// warm up at two rates have one name.
std::vector<std::string> NamesOf(const Machine& machine, const ErrorModel& model);

inline constexpr char kAlongApproachSymbol[] = "ERT";
// A term of the tool along the approach of a touch, amplitudes zero.
ErrorTerm AlongApproachTerm(const Machine& machine, const shapes::Shape& shape);
// Derivative of a reading by the unit value of such a term, made of its derivatives by the tool's translations (x, y, z
// at `by_translation`, `stride` apart).
inline double AlongApproach(const shapes::Approach& approach, const double* by_translation, long stride) {
  return -(by_translation[0] * approach.direction[0] + by_translation[stride] * approach.direction[1] +
           by_translation[2 * stride] * approach.direction[2]);
}

// Adds one term to the errors of its joint; `basis` holds the `count` basis functions of its shape at that state.
inline void AddErrors(const ErrorTerm& term, int count, const double* basis, const shapes::State& state,
                      JointErrors<double>* errors) {
  if (shapes::IsAlongApproach(term.shape)) {
    double value = 0.0;
    for (int i = 0; i < count; ++i) value += term.amplitude[i] * basis[i];
    for (int c = 0; c < 3; ++c) (*errors)[term.joint][c] -= value * state.approach.direction[c];
    return;
  }
  double& error = (*errors)[term.joint][static_cast<int>(term.component)];
  for (int i = 0; i < count; ++i) error += term.amplitude[i] * basis[i];
}
inline void AddErrors(const ErrorTerm& term, const shapes::State& state, JointErrors<double>* errors) {
  double basis[shapes::kMaxBasisCount];
  shapes::Basis(term.shape, state, basis);
  AddErrors(term, shapes::BasisCount(term.shape), basis, state, errors);
}

// Sum of all terms at a state, one error vector per joint.
JointErrors<double> ErrorsAt(const Machine& machine, const ErrorModel& model, const shapes::State& state);

// How far, one standard deviation, a term is unknown at a state beyond what its readings reached: a free curve beyond
// its span, a late warmth beyond the temperatures seen; mm or rad. What is known there is in the covariance of its
// numbers.
double UnknownAt(const ErrorTerm& term, const shapes::State& state);

// INVALID_ARGUMENT naming column and error where a term depends on what was not recorded: the clock (column t_s) or the
// temperature of a channel; `channels` by column, "temp_C", "T_spindle_C".
absl::Status RequireState(const Machine& machine, const ErrorTerm& term, bool has_time,
                          const std::vector<std::string>& channels);

// True when a term depends on something other than axis positions: sense, speed, time or temperature.
bool DependsOnMoreThanPosition(const ErrorTerm& term);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_ERROR_MODEL_H_
