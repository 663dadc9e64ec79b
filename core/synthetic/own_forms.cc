// Effects by the formulas that are fitted (docs/formats.md, "Scenario").
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/synthetic/forms.h"

namespace axiscal::synthetic {
namespace {

// A shape of errors.json: its one definition is in core/shapes.
Values OfTerm(const Drawing& drawing, const shapes::Shape& shape,
              const std::array<double, shapes::kMaxBasisCount>& amplitude, std::optional<machine::ErrorTerm>* term) {
  *term = machine::ErrorTerm{drawing.effect.joint, drawing.effect.component, shape, amplitude};
  return [shape, amplitude](const History& history) {
    std::vector<double> values(history.size(), 0.0);
    const int count = shapes::BasisCount(shape);
    for (size_t k = 0; k < values.size(); ++k) {
      double basis[shapes::kMaxBasisCount] = {};
      shapes::Basis(shape, history.StateOf(k), basis);
      for (int i = 0; i < count; ++i) values[k] += amplitude[i] * basis[i];
    }
    return values;
  };
}

shapes::Span SpanOf(const Drawing& drawing, int axis, const Range& range) {
  if (IsTurning(drawing.machine, axis)) return {.is_turn = true};
  return {range.low, range.high};
}

// Weights of a random curve: as its prior has them, less of what is finer than the effect's length.
std::array<double, shapes::kMaxBasisCount> Weights(const shapes::Shape& shape, const shapes::Span& span, int first,
                                                   double length, base::Random* random) {
  std::array<double, shapes::kMaxBasisCount> weights{};
  for (int i = 0; i < shapes::BasisCount(shape); ++i) {
    const int order = span.OrderOf(i, first);
    const double per_length = span.is_turn ? order : std::numbers::pi * order / (span.high - span.low);
    weights[i] = random->Normal() * shapes::PriorRoot(shape, i) * MaternDeviation(per_length, length);
  }
  return weights;
}

Values Gravity(const Drawing& drawing, base::Random* random) {
  constexpr double kFarMm = 250.0;  // of the mass centre: as bodies of machine tools are large
  const Eigen::Vector3d centre_mm(kFarMm * random->Normal(), kFarMm * random->Normal(), kFarMm * random->Normal());
  const int body = BodyOf(drawing.machine, drawing.effect);
  return [machine = drawing.machine, surroundings = drawing.surroundings, effect = drawing.effect, body,
          centre_mm](const History& history) {
    std::vector<double> values(history.size());
    for (size_t k = 0; k < values.size(); ++k)
      values[k] = Load(machine, surroundings, effect, body, centre_mm, history.PositionsOf(k));
    return values;
  };
}

// Sum of products of the first functions of two curves, each product with a weight of its own.
Values Crossed(const Drawing& drawing, base::Random* random, std::optional<machine::ErrorTerm>* term) {
  const Effect& effect = drawing.effect;
  const shapes::Crossed crossed{effect.axis, effect.second_axis, SpanOf(drawing, effect.axis, drawing.range),
                                SpanOf(drawing, effect.second_axis, drawing.second_range)};
  std::array<double, shapes::kMaxBasisCount> weights{};
  for (int i = 0; i < crossed.Count(); ++i) weights[i] = random->Normal() * shapes::PriorRoot(crossed, i);
  return OfTerm(drawing, crossed, weights, term);
}

Values Heat(const Drawing& drawing, std::optional<machine::ErrorTerm>* term) {
  const Effect& effect = drawing.effect;
  const shapes::Times times =
      effect.axis < 0 ? shapes::Times{} : machine::TimesPositionOf(drawing.machine, effect.axis);
  if (effect.channel == kTimeChannel) return OfTerm(drawing, shapes::DriftExp{effect.tau_s, times}, {1.0, 0.0}, term);
  // No session needs to have recorded the channel: no term of errors.json.
  const shapes::ThermalLag lag{effect.channel, effect.tau_s, times};
  return [lag](const History& history) {
    const shapes::Temperatures temperatures(history.time_s, {{lag.channel, history.celsius.at(lag.channel)}});
    std::vector<double> values(history.size());
    for (size_t k = 0; k < values.size(); ++k) {
      shapes::State state = history.StateOf(k);
      state.temperatures = &temperatures;
      shapes::Basis(lag, state, &values[k]);
    }
    return values;
  };
}

Values Backlash(const Drawing& drawing, base::Random* random) {
  const int axis = drawing.effect.axis;
  const Function worn = OwnFunction(drawing.range, drawing.effect.length, IsTurning(drawing.machine, axis), random);
  double square = 0.0;
  constexpr int kPoints = 50;
  for (int i = 0; i < kPoints; ++i) {
    const double value = worn(drawing.range.low + drawing.range.length() * i / (kPoints - 1.0));
    square += value * value / kPoints;
  }
  const double scale = square > 0.0 ? 0.5 / std::sqrt(square) : 0.0;  // wear is half of the backlash
  return [axis, worn, scale](const History& history) {
    std::vector<double> values(history.size());
    for (size_t k = 0; k < values.size(); ++k) {
      const shapes::AxisState& state = history.AxisAt(k, axis);
      values[k] = state.sense * (1.0 + scale * worn(state.position));
    }
    return values;
  };
}

// Dahl: after a reversal the joint winds up over a length.
Values WindUp(const Effect& effect) {
  return [effect](const History& history) {
    std::vector<double> values(history.size());
    for (size_t k = 0; k < values.size(); ++k) {
      const shapes::AxisState& state = history.AxisAt(k, effect.axis);
      values[k] = state.sense * (1.0 - 2.0 * std::exp(-state.travel_since_reversal / effect.length));
    }
    return values;
  };
}

// Prandtl-Ishlinskii: sum of w (q - p), p a play operator of radius r; radii on a logarithmic grid up to the length.
Values Friction(const Effect& effect, base::Random* random) {
  constexpr int kElements = 4;
  std::array<double, kElements> radius, weight;
  for (int i = 0; i < kElements; ++i) {
    radius[i] = effect.length * std::pow(4.0, i - kElements + 1);
    weight[i] = (0.2 + random->Uniform()) / radius[i];
  }
  return [effect, radius, weight](const History& history) {
    std::vector<double> values(history.size(), 0.0);
    for (int i = 0; i < kElements; ++i) {
      double play = history.size() == 0 ? 0.0 : history.PositionsOf(0)[effect.axis];
      for (size_t k = 0; k < values.size(); ++k) {
        const double q = history.PositionsOf(k)[effect.axis];
        play = std::min(std::max(play, q - radius[i]), q + radius[i]);
        values[k] += weight[i] * (q - play);
      }
    }
    return values;
  };
}

// Sign of the last move of the axis, and half as much again in proportion to its size.
Values LastMove(const Effect& effect) {
  return [effect](const History& history) {
    std::vector<double> values(history.size(), 0.0);
    double move = 0.0;
    for (size_t k = 0; k < values.size(); ++k) {
      const double change =
          k == 0 ? 0.0 : history.PositionsOf(k)[effect.axis] - history.PositionsOf(k - 1)[effect.axis];
      if (change != 0.0) move = change;
      values[k] = (move > 0.0) - (move < 0.0) + 0.5 * move / effect.length;
    }
    return values;
  };
}

// E = - delay x speed, or - delay^2 x acceleration.
Values Following(const Drawing& drawing, std::optional<machine::ErrorTerm>* term) {
  const Effect& effect = drawing.effect;
  if (effect.is_of_speed) return OfTerm(drawing, shapes::Lag{effect.axis}, {-effect.delay_s, 0.0}, term);
  return OfTerm(drawing, shapes::Acceleration{effect.axis}, {-effect.delay_s * effect.delay_s, 0.0}, term);
}

}  // namespace

Values OwnValues(const Drawing& drawing, base::Random* random, std::optional<machine::ErrorTerm>* term) {
  const Effect& effect = drawing.effect;
  switch (effect.kind) {
    case EffectKind::kCurve: {
      const shapes::Curve curve{effect.axis, SpanOf(drawing, effect.axis, drawing.range)};
      return OfTerm(drawing, curve, Weights(curve, curve.span, shapes::Curve::kFirst, effect.length, random), term);
    }
    case EffectKind::kTimeCurve: {
      const shapes::TimeCurve curve{{drawing.range.low, drawing.range.high}};
      const auto weights = Weights(curve, curve.span, shapes::TimeCurve::kFirst, effect.length, random);
      // After the plan it stays where it ended; a term of errors.json is not known there.
      return [curve, weights](const History& history) {
        std::vector<double> values(history.size(), 0.0);
        for (size_t k = 0; k < values.size(); ++k) {
          shapes::State state = history.StateOf(k);
          state.time_s = std::clamp(state.time_s, curve.span.low, curve.span.high);
          double basis[shapes::kMaxBasisCount] = {};
          shapes::Basis(curve, state, basis);
          for (int i = 0; i < curve.functions; ++i) values[k] += weights[i] * basis[i];
        }
        return values;
      };
    }
    case EffectKind::kRipple: {
      const double phase = 2.0 * std::numbers::pi * random->Uniform();
      return OfTerm(drawing, shapes::Harmonic{effect.axis, effect.frequency}, {std::cos(phase), std::sin(phase)}, term);
    }
    case EffectKind::kGravity:
      return Gravity(drawing, random);
    case EffectKind::kCrossed:
      return Crossed(drawing, random, term);
    case EffectKind::kHeat:
      return Heat(drawing, term);
    case EffectKind::kBacklash:
      return Backlash(drawing, random);
    case EffectKind::kWindUp:
      return WindUp(effect);
    case EffectKind::kFriction:
      return Friction(effect, random);
    case EffectKind::kLastMove:
      return LastMove(effect);
    case EffectKind::kFollowing:
      return Following(drawing, term);
  }
  return {};
}

}  // namespace axiscal::synthetic
