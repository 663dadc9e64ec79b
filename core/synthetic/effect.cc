#include "core/synthetic/effect.h"

#include <algorithm>
#include <cmath>

#include "core/synthetic/forms.h"

namespace axiscal::synthetic {
namespace {

// The length where none was asked for, as a share of the plan's range: about as smooth as guides and gears are.
double UsualLength(const Effect& effect, bool is_turning, const Range& range) {
  switch (effect.kind) {
    case EffectKind::kCurve:
    case EffectKind::kBacklash:
      return is_turning ? 0.6 : range.length() / 6.0;
    case EffectKind::kTimeCurve:
      return range.length() / 4.0;
    case EffectKind::kWindUp:
    case EffectKind::kFriction:
      return range.length() / 20.0;
    case EffectKind::kLastMove:
      return range.length() / 5.0;
    default:
      return 0.0;
  }
}

}  // namespace

const char* const* EffectWords() {
  static const char* const kWords[] = {"curve",    "time-curve", "ripple",   "gravity",   "crossed",   "thermal",
                                       "backlash", "wind-up",    "friction", "last-move", "following", nullptr};
  return kWords;
}

double RmsAboutMean(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  double mean = 0.0, square = 0.0;
  for (const double value : values) mean += value / static_cast<double>(values.size());
  for (const double value : values) square += (value - mean) * (value - mean);
  return std::sqrt(square / static_cast<double>(values.size()));
}

std::string NameOf(const machine::Machine& machine, const Effect& effect) {
  const std::string symbol =
      machine::ToString({effect.component, machine::JointName(machine, effect.joint), /*is_constant=*/false});
  std::string of;
  if (!effect.channel.empty()) of = effect.channel;
  for (const int axis : {effect.axis, effect.second_axis}) {
    if (axis >= 0) absl::StrAppend(&of, of.empty() ? "" : ",", machine.axes[axis].name);
  }
  if (effect.kind == EffectKind::kRipple) {
    if (machine.axes[effect.axis].kind == machine::AxisKind::kRotary)
      absl::StrAppendFormat(&of, ",%.5g", effect.frequency);
    else
      absl::StrAppendFormat(&of, ",%.5gmm", 2.0 * std::numbers::pi / effect.frequency);
  }
  return absl::StrCat(symbol, ":", EffectWords()[static_cast<int>(effect.kind)], of.empty() ? "" : "(" + of + ")");
}

std::vector<double> DrawnEffect::Errors(const History& history) const {
  std::vector<double> errors = value(history);
  for (double& error : errors) error *= factor;
  return errors;
}

absl::StatusOr<DrawnEffect> DrawEffect(const machine::Machine& machine, const Surroundings& surroundings,
                                       const Effect& asked, Form form, const History& plan, base::Random* random) {
  const auto refuse = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat(NameOf(machine, asked), ": ", what));
  };
  Effect effect = asked;
  const bool is_turning = IsTurning(machine, effect.axis);
  const Range range = RangeOf(plan, effect.axis);
  const bool needs_range = effect.kind != EffectKind::kGravity && effect.kind != EffectKind::kHeat;
  if (needs_range && !(range.length() > 0.0)) {
    return refuse(effect.axis < 0 ? "the plan's readings have one time, expected t_s that runs on"
                                  : absl::StrCat("axis ", machine.axes[effect.axis].name,
                                                 " rests in all of the plan, expected one that moves"));
  }
  const Range second = effect.second_axis < 0 ? Range() : RangeOf(plan, effect.second_axis);
  if (effect.second_axis >= 0 && !(second.length() > 0.0))
    return refuse(absl::StrCat("axis ", machine.axes[effect.second_axis].name,
                               " rests in all of the plan, expected one that moves"));
  if (effect.kind == EffectKind::kHeat && effect.channel != kTimeChannel && !plan.celsius.contains(effect.channel))
    return refuse(absl::StrCat("the plan has no temperature '", effect.channel, "'"));
  if (effect.length == 0.0) effect.length = UsualLength(effect, is_turning, range);
  const Drawing drawing{machine, surroundings, effect, range, second};
  DrawnEffect drawn;
  drawn.joint = effect.joint;
  drawn.component = effect.component;
  drawn.value = form == Form::kOwn ? OwnValues(drawing, random, &drawn.term) : IndependentValues(drawing, random);
  const std::vector<double> values = drawn.value(plan);
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  const double rms = RmsAboutMean(values);
  constexpr double kRounding = 1e-9, kLeast = 1e-13;  // what is left of sums that cancel; of temperatures that stay
  if (!(rms > kLeast + kRounding * largest) || !std::isfinite(rms))
    return refuse("it is the same at all of the plan's readings, expected a plan over which it varies");
  drawn.factor = effect.rms / rms;
  if (drawn.term) {
    for (double& amplitude : drawn.term->amplitude) amplitude *= drawn.factor;
  }
  return drawn;
}

}  // namespace axiscal::synthetic
