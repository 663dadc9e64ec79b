// What a machine's model holds: error terms (axis x component x shape) with their amplitudes, and their sum at a state.
#ifndef AXISCAL_CORE_MACHINE_ERROR_MODEL_H_
#define AXISCAL_CORE_MACHINE_ERROR_MODEL_H_

#include <array>
#include <string>
#include <vector>

#include "core/machine/chain.h"
#include "core/machine/machine.h"
#include "core/shapes/shape.h"

namespace axiscal::machine {

struct ErrorTerm {
  int joint = 0;  // an axis, or the machine's tool_joint() or work_joint()
  Component component = Component::kX;
  shapes::Shape shape = shapes::Constant{};
  // Per basis function of the shape, mm or rad (per the shape's reference: metre, hour, degree C ...).
  std::array<double, shapes::kMaxBasisCount> amplitude = {0.0, 0.0};

  bool operator==(const ErrorTerm&) const = default;
};

struct ErrorModel {
  std::vector<ErrorTerm> terms;
};

// The constant term of a symbol. DEMANDs that the machine has the joint.
ErrorTerm ConstantTerm(const Machine& machine, const ErrorSymbol& symbol, double amplitude = 0.0);
// The declared constant errors, all zero.
ErrorModel DeclaredModel(const Machine& machine);

// "EX0C" for a constant term, "EXC" for the others.
std::string SymbolOf(const Machine& machine, const ErrorTerm& term);
// A unique readable name: "EX0C", "EXX:backlash", "EBB:harmonic(45)", with the variable where it is not the term's own
// axis: "EZT:thermal", "EBY:linear(Z)".
std::string NameOf(const Machine& machine, const ErrorTerm& term);

// Sum of all terms at a state, one error vector per joint.
JointErrors<double> ErrorsAt(const Machine& machine, const ErrorModel& model, const shapes::State& state);

// True when a term depends on something other than axis positions: sense, speed, time or temperature.
bool DependsOnMoreThanPosition(const ErrorTerm& term);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_ERROR_MODEL_H_
