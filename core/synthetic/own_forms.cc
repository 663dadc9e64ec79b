// Effects by the formulas that are fitted (docs/formats.md, "Scenario").
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/synthetic/forms.h"

namespace axiscal::synthetic {
namespace {

Values OfPosition(int axis, Function function) {
  return [axis, function](const History& history) {
    std::vector<double> values(history.size());
    for (size_t k = 0; k < values.size(); ++k) values[k] = function(history.PositionsOf(k)[axis]);
    return values;
  };
}

// A shape of errors.json: its one definition is in core/shapes.
Values OfTerm(const Drawing& drawing, const shapes::Shape& shape, std::array<double, 2> amplitude,
              std::optional<machine::ErrorTerm>* term) {
  *term = machine::ErrorTerm{drawing.effect.joint, drawing.effect.component, shape, amplitude};
  return [shape, amplitude](const History& history) {
    std::vector<double> values(history.size());
    for (size_t k = 0; k < values.size(); ++k) {
      double basis[shapes::kMaxBasisCount] = {};
      shapes::Basis(shape, history.StateOf(k), basis);
      values[k] = amplitude[0] * basis[0] + amplitude[1] * basis[1];
    }
    return values;
  };
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
Values Crossed(const Drawing& drawing, base::Random* random) {
  constexpr int kFunctions = 4;
  struct Basis {
    int axis;
    bool is_rotary;
    Range range;
    double At(int j, double q) const {
      if (is_rotary) return j % 2 == 0 ? std::cos((j / 2 + 1) * q) : std::sin((j / 2 + 1) * q);
      const double wide = 1.4 * range.length();
      return std::sin(std::numbers::pi * (j + 1) * (q - range.low + 0.2 * range.length()) / wide);
    }
  };
  const Basis first{drawing.effect.axis, IsTurning(drawing.machine, drawing.effect.axis), drawing.range};
  const Basis second{drawing.effect.second_axis, IsTurning(drawing.machine, drawing.effect.second_axis),
                     drawing.second_range};
  std::array<std::array<double, kFunctions>, kFunctions> weights;
  for (int i = 0; i < kFunctions; ++i) {
    for (int j = 0; j < kFunctions; ++j) weights[i][j] = random->Normal() / ((1.0 + i) * (1.0 + j));
  }
  return [first, second, weights](const History& history) {
    std::vector<double> values(history.size(), 0.0);
    for (size_t k = 0; k < values.size(); ++k) {
      for (int i = 0; i < kFunctions; ++i) {
        const double at_first = first.At(i, history.PositionsOf(k)[first.axis]);
        for (int j = 0; j < kFunctions; ++j)
          values[k] += weights[i][j] * at_first * second.At(j, history.PositionsOf(k)[second.axis]);
      }
    }
    return values;
  };
}

// dF/dt = (T - F) / tau, T linear between readings, F = T at the first reading; exact.
std::vector<double> Lagged(const std::vector<double>& time_s, const std::vector<double>& celsius, double tau_s) {
  std::vector<double> lagged(celsius);
  for (size_t k = 1; k < lagged.size(); ++k) {
    const double elapsed_s = time_s[k] - time_s[k - 1], change = celsius[k] - celsius[k - 1];
    if (!(elapsed_s > 0.0)) {
      lagged[k] = lagged[k - 1];
      continue;
    }
    const double keeps = std::exp(-elapsed_s / tau_s);
    lagged[k] =
        lagged[k - 1] * keeps + celsius[k] - celsius[k - 1] * keeps - change * (tau_s / elapsed_s) * (1.0 - keeps);
  }
  return lagged;
}

Values Heat(const Drawing& drawing, std::optional<machine::ErrorTerm>* term) {
  const Effect& effect = drawing.effect;
  if (effect.channel == kTimeChannel && effect.axis < 0)
    return OfTerm(drawing, shapes::DriftExp{effect.tau_s}, {1.0, 0.0}, term);
  return [effect](const History& history) {
    std::vector<double> values(history.size());
    if (effect.channel == kTimeChannel) {
      for (size_t k = 0; k < values.size(); ++k) values[k] = 1.0 - std::exp(-history.time_s[k] / effect.tau_s);
    } else {
      values = Lagged(history.time_s, history.celsius.at(effect.channel), effect.tau_s);
      for (double& value : values) value -= shapes::kReferenceTemperatureCelsius;
    }
    for (size_t k = 0; effect.axis >= 0 && k < values.size(); ++k) values[k] *= history.PositionsOf(k)[effect.axis];
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

// E = - delay x speed, or - delay^2 x acceleration, both from differences of the readings.
Values Following(const Drawing& drawing, std::optional<machine::ErrorTerm>* term) {
  const Effect& effect = drawing.effect;
  if (effect.is_of_speed) return OfTerm(drawing, shapes::Lag{effect.axis}, {-effect.delay_s, 0.0}, term);
  return [effect](const History& history) {
    std::vector<double> values(history.size(), 0.0);
    for (size_t k = 1; k < values.size(); ++k) {
      const double elapsed_s = history.time_s[k] - history.time_s[k - 1];
      if (history.BeginsSession(k) || !(elapsed_s > 0.0)) continue;
      const double change = history.AxisAt(k, effect.axis).speed - history.AxisAt(k - 1, effect.axis).speed;
      values[k] = -effect.delay_s * effect.delay_s * change / elapsed_s;
    }
    return values;
  };
}

}  // namespace

Values OwnValues(const Drawing& drawing, base::Random* random, std::optional<machine::ErrorTerm>* term) {
  const Effect& effect = drawing.effect;
  switch (effect.kind) {
    case EffectKind::kCurve:
      return OfPosition(effect.axis,
                        OwnFunction(drawing.range, effect.length, IsTurning(drawing.machine, effect.axis), random));
    case EffectKind::kTimeCurve: {
      const Function drift = OwnFunction(drawing.range, effect.length, false, random);
      return [drift, range = drawing.range](const History& history) {
        std::vector<double> values(history.size());
        for (size_t k = 0; k < values.size(); ++k)
          values[k] = drift(std::clamp(history.time_s[k], range.low, range.high));
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
      return Crossed(drawing, random);
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
