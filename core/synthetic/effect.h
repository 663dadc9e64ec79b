// Errors of real machines beyond the terms of errors.json, as simulations draw them. An effect acts on one component
// of one joint, E(symbol) = factor x value(history); the one chain (core/machine/chain.h) does the rest. Its value has
// two forms:
//   own          the formula that is (or shall be) fitted: docs/formats.md, "Scenario"
//   independent  another formula of the same physics (other kernels, operators and integrators), which shares no code
//                with it: what a fit makes of physics that nobody modelled exactly
// `factor` is set once, so that over the readings of the plan the error's rms about its mean is what was asked for.
#ifndef AXISCAL_CORE_SYNTHETIC_EFFECT_H_
#define AXISCAL_CORE_SYNTHETIC_EFFECT_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/base/status.h"
#include "core/machine/error_model.h"
#include "core/synthetic/history.h"

namespace axiscal::synthetic {

enum class Form { kOwn, kIndependent };

enum class EffectKind {
  kCurve,      // smooth, of the position of an axis
  kTimeCurve,  // smooth, of the time: a slow drift without a temperature; after the plan it stays
  kRipple,     // periodic in the position of an axis, of any order or period
  kGravity,    // the compliance of a joint under the weight of a body beyond it
  kCrossed,    // of the positions of two axes
  kHeat,       // a temperature, or the time since the start, that acts late; also times a position
  kBacklash,   // the sense of motion times a smooth function of the position
  kWindUp,     // what a joint winds up after a reversal
  kFriction,   // several elements that stick and slide
  kLastMove,   // sign and size of the last move, point to point
  kFollowing,  // a servo that follows late: speed or acceleration
};
// "curve", "time-curve" ... in the enumeration's order, ended by nullptr.
const char* const* EffectWords();

struct Effect {
  EffectKind kind = EffectKind::kCurve;
  int joint = 0;  // an axis, T or W
  machine::Component component = machine::Component::kX;
  double rms = 0.0;      // mm or rad, about the mean, over the plan's readings
  int axis = -1;         // the variable; of thermal: the axis whose position multiplies, -1 for none
  int second_axis = -1;  // of crossed
  // Correlation length of curves, decay length of wind-up, largest play of friction, size at which a last move
  // saturates: mm or rad (s of a time curve); 0: a fraction of the plan's range.
  double length = 0.0;
  double frequency = 0.0;   // of ripple: rad per rad, or rad per mm
  std::string channel;      // of thermal: a temperature's name, or kTimeChannel
  double tau_s = 0.0;       // of thermal: the time constant
  double delay_s = 0.02;    // of following: how late the servo is
  bool is_of_speed = true;  // of following; false: of acceleration
  int body = -1;            // of gravity: the joint that carries the mass, beyond or at `joint`; -1: its branch's end
};

// The bed's "down", unit: the direction of gravity in the machine frame.
struct Surroundings {
  Eigen::Vector3d gravity_direction = Eigen::Vector3d(0, 0, -1);
};

// An effect as it was drawn; its random functions stay the same for every history.
struct DrawnEffect {
  int joint = 0;
  machine::Component component = machine::Component::kX;
  double factor = 1.0;  // mm or rad per unit of value
  std::function<std::vector<double>(const History&)> value;
  // The term of errors.json that is this effect, where there is one (of own forms).
  std::optional<machine::ErrorTerm> term;

  // mm or rad at every moment.
  std::vector<double> Errors(const History& history) const;
};

// Draws the effect for the plan's history. INVALID_ARGUMENT where the effect does not vary over the plan (the axis
// rests, there is no such temperature): it could have no size.
absl::StatusOr<DrawnEffect> DrawEffect(const machine::Machine& machine, const Surroundings& surroundings,
                                       const Effect& effect, Form form, const History& plan, base::Random* random);

// "EYX:curve(X)", "ECC:ripple(C,45)", "EXX:ripple(X,10mm)", "EBY:crossed(Y,Z)": for messages and truth files.
std::string NameOf(const machine::Machine& machine, const Effect& effect);

// Root mean square about the mean.
double RmsAboutMean(const std::vector<double>& values);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_EFFECT_H_
