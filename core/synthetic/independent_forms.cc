// Effects by other formulas than the fitted ones: other kernels, operators and integrators for the same physics.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/synthetic/forms.h"

namespace axiscal::synthetic {
namespace {

Function AnyFunction(const Drawing& drawing, base::Random* random) {
  return IndependentFunction(drawing.range, drawing.effect.length, IsTurning(drawing.machine, drawing.effect.axis),
                             random);
}

template <typename At>
Values EveryMoment(At at) {
  return [at](const History& history) {
    std::vector<double> values(history.size());
    for (size_t k = 0; k < values.size(); ++k) values[k] = at(history, k);
    return values;
  };
}

// A wave that is no pure sine: cos E of Kepler's equation E - e sin E = w q + phase. Its second harmonic is e / 2 of
// the first, and so on.
Values SkewedRipple(const Effect& effect, base::Random* random) {
  constexpr double kEccentricity = 0.1;
  const double phase = 2.0 * std::numbers::pi * random->Uniform();
  return EveryMoment([effect, phase](const History& history, size_t k) {
    const double mean = effect.frequency * history.PositionsOf(k)[effect.axis] + phase;
    double anomaly = mean;
    for (int i = 0; i < 30; ++i) anomaly = mean + kEccentricity * std::sin(anomaly);  // contracts by e each
    return std::cos(anomaly);
  });
}

// A joint of finite, hardening stiffness: x + 0.15 x^3 = load. On a linear axis the overhanging body bends as a
// cantilever besides: load x overhang / 2 under its weight at the end, and x overhang^2 / 6 under its own.
Values Compliance(const Drawing& drawing, base::Random* random) {
  constexpr double kFarMm = 250.0;
  const Eigen::Vector3d centre_mm = kFarMm * Eigen::Vector3d(random->Normal(), random->Normal(), random->Normal());
  const int body = BodyOf(drawing.machine, drawing.effect);
  const bool is_guide =
      drawing.effect.joint < drawing.machine.axis_count() && !IsTurning(drawing.machine, drawing.effect.joint);
  return EveryMoment([machine = drawing.machine, surroundings = drawing.surroundings, effect = drawing.effect, body,
                      centre_mm, is_guide](const History& history, size_t k) {
    const bool is_turned = machine::IsAngle(effect.component);
    constexpr double kReferenceMm = 500.0;  // a lever at which the stiffness has hardened by 15 %
    const double load =
        Load(machine, surroundings, effect, body, centre_mm, history.PositionsOf(k)) / (is_turned ? kReferenceMm : 1.0);
    double deflection = load;
    for (int i = 0; i < 50; ++i) {
      const double off = deflection + 0.15 * deflection * deflection * deflection - load;
      deflection -= off / (1.0 + 0.45 * deflection * deflection);
    }
    if (is_guide) {
      const double overhang = std::abs(load);
      deflection += 0.3 * load * (overhang / 2.0 + overhang * overhang / 6.0);
    }
    return deflection;
  });
}

// Products of random functions of the two axes: one, and another half as large.
Values Products(const Drawing& drawing, base::Random* random) {
  const Effect& effect = drawing.effect;
  struct Product {
    Function of_first, of_second;
    double weight;
  };
  std::vector<Product> products;
  for (const double weight : {1.0, 0.5}) {
    Product product;
    product.weight = weight;
    product.of_first =
        IndependentFunction(drawing.range, IsTurning(drawing.machine, effect.axis) ? 1.0 : drawing.range.length() / 2.0,
                            IsTurning(drawing.machine, effect.axis), random);
    product.of_second =
        IndependentFunction(drawing.second_range,
                            IsTurning(drawing.machine, effect.second_axis) ? 1.0 : drawing.second_range.length() / 2.0,
                            IsTurning(drawing.machine, effect.second_axis), random);
    products.push_back(product);
  }
  return EveryMoment([effect, products](const History& history, size_t k) {
    double sum = 0.0;
    for (const Product& product : products)
      sum += product.weight * product.of_first(history.PositionsOf(k)[effect.axis]) *
             product.of_second(history.PositionsOf(k)[effect.second_axis]);
    return sum;
  });
}

// Two bodies that exchange heat, the first with the surroundings too (Runge-Kutta of fourth order in small steps):
//   dF1/dt = (T - F1) / tau + (F2 - F1) / (2 tau),   dF2/dt = (F1 - F2) / (3 tau),   error = F1 + 0.3 F2.
class TwoNodes {
 public:
  TwoNodes(double tau_s, double celsius) : tau_s_(tau_s), first_(celsius), second_(celsius) {}

  // Surroundings that go linearly from `from` to `to`.
  void Go(double elapsed_s, double from, double to) {
    constexpr double kForgottenAfter = 100.0;  // time constants: what was before is gone
    if (elapsed_s > kForgottenAfter * tau_s_) {
      from += (to - from) * (1.0 - kForgottenAfter * tau_s_ / elapsed_s);
      elapsed_s = kForgottenAfter * tau_s_;
      first_ = second_ = from;
    }
    const int steps = std::max(1, static_cast<int>(std::ceil(elapsed_s / (0.05 * tau_s_))));
    const double step_s = elapsed_s / steps;
    for (int i = 0; i < steps; ++i) {
      const double t0 = from + (to - from) * i / steps, t1 = from + (to - from) * (i + 1.0) / steps;
      const double mid = 0.5 * (t0 + t1);
      const auto [a1, a2] = Slope(first_, second_, t0);
      const auto [b1, b2] = Slope(first_ + 0.5 * step_s * a1, second_ + 0.5 * step_s * a2, mid);
      const auto [c1, c2] = Slope(first_ + 0.5 * step_s * b1, second_ + 0.5 * step_s * b2, mid);
      const auto [d1, d2] = Slope(first_ + step_s * c1, second_ + step_s * c2, t1);
      first_ += step_s / 6.0 * (a1 + 2.0 * b1 + 2.0 * c1 + d1);
      second_ += step_s / 6.0 * (a2 + 2.0 * b2 + 2.0 * c2 + d2);
    }
  }
  double Value() const { return first_ + 0.3 * second_; }

 private:
  std::pair<double, double> Slope(double first, double second, double around) const {
    return {((around - first) + 0.5 * (second - first)) / tau_s_, (first - second) / (3.0 * tau_s_)};
  }

  double tau_s_, first_, second_;
};

Values Warming(const Effect& effect) {
  return [effect](const History& history) {
    std::vector<double> values(history.size());
    if (values.empty()) return values;
    const bool is_time = effect.channel == kTimeChannel;
    const std::vector<double>* celsius = is_time ? nullptr : &history.celsius.at(effect.channel);
    // By time: switched on at the clock's zero.
    TwoNodes nodes(effect.tau_s, is_time ? 0.0 : celsius->front() - shapes::kReferenceTemperatureCelsius);
    if (is_time && history.time_s[0] > 0.0) nodes.Go(history.time_s[0], 1.0, 1.0);
    for (size_t k = 0; k < values.size(); ++k) {
      if (k > 0) {
        const double elapsed_s = history.time_s[k] - history.time_s[k - 1];
        const double from = is_time ? 1.0 : (*celsius)[k - 1] - shapes::kReferenceTemperatureCelsius;
        const double to = is_time ? 1.0 : (*celsius)[k] - shapes::kReferenceTemperatureCelsius;
        if (elapsed_s > 0.0) nodes.Go(elapsed_s, from, to);
      }
      values[k] = nodes.Value();
      if (effect.axis >= 0) values[k] *= history.PositionsOf(k)[effect.axis];
    }
    return values;
  };
}

// Bouc 1967 and Wen 1976, by steps of at most a tenth of the length x:
//   dz = (dq / x) (1 - |z|^n (0.5 + 0.5 sign(z dq))),   -1 <= z <= 1.
class BoucWen {
 public:
  BoucWen(double length, double exponent) : length_(length), exponent_(exponent) {}

  double Move(double change) {
    constexpr int kMostSteps = 400;  // 40 lengths: z stands at its end long before
    const double most = 0.1 * length_;
    const int steps = std::min(kMostSteps, static_cast<int>(std::ceil(std::abs(change) / most)));
    const double step = steps == 0 ? 0.0 : std::copysign(std::min(std::abs(change) / steps, most), change) / length_;
    for (int i = 0; i < steps; ++i) {
      const double against = z_ * step > 0.0 ? 1.0 : 0.0;
      z_ = std::clamp(z_ + step * (1.0 - std::pow(std::abs(z_), exponent_) * against), -1.0, 1.0);
    }
    return z_;
  }

 private:
  double length_, exponent_, z_ = 0.0;
};

double ChangeOf(const History& history, size_t k, int axis) {
  return k == 0 ? 0.0 : history.PositionsOf(k)[axis] - history.PositionsOf(k - 1)[axis];
}

// A sense that takes 1/500 of the range to turn over, times a function of the position.
Values WornBacklash(const Drawing& drawing, base::Random* random) {
  const int axis = drawing.effect.axis;
  const double turns_over = drawing.range.length() / 500.0;
  const Function worn = AnyFunction(drawing, random);
  constexpr int kPoints = 50;
  std::vector<double> along(kPoints);
  for (int i = 0; i < kPoints; ++i) along[i] = worn(drawing.range.low + drawing.range.length() * i / (kPoints - 1.0));
  const double rms = RmsAboutMean(along), scale = rms > 0.0 ? 0.5 / rms : 0.0;
  const double middle = along[kPoints / 2];
  return [axis, turns_over, worn, scale, middle](const History& history) {
    std::vector<double> values(history.size());
    BoucWen sense(turns_over, 1.0);
    // The axis came from behind: the sense of its first motion.
    if (!values.empty()) sense.Move(history.AxisAt(0, axis).sense * 20.0 * turns_over);
    for (size_t k = 0; k < values.size(); ++k)
      values[k] =
          sense.Move(ChangeOf(history, k, axis)) * (1.0 + scale * (worn(history.PositionsOf(k)[axis]) - middle));
    return values;
  };
}

// Dahl 1968 with exponent 1.5 in place of 1: dz/dq = (2 / x) |1 - z sign(dq)|^1.5 / 2^0.5, by small steps.
Values DahlWindUp(const Effect& effect) {
  return [effect](const History& history) {
    std::vector<double> values(history.size());
    double z = values.empty() ? 0.0 : history.AxisAt(0, effect.axis).sense;
    for (size_t k = 0; k < values.size(); ++k) {
      const double change = ChangeOf(history, k, effect.axis), sign = change > 0.0 ? 1.0 : -1.0;
      const int steps = std::min(2000, static_cast<int>(std::ceil(std::abs(change) / (0.02 * effect.length))));
      for (int i = 0; i < steps; ++i) {
        const double ahead = std::max(0.0, 1.0 - z * sign);
        z += sign * (std::abs(change) / steps / effect.length) * std::pow(ahead, 1.5) / std::sqrt(2.0);
        z = std::clamp(z, -1.0, 1.0);
      }
      values[k] = z;
    }
    return values;
  };
}

// Two Bouc-Wen elements of different lengths and sharpness.
Values TwoElements(const Effect& effect, base::Random* random) {
  const double share = 0.3 + 0.4 * random->Uniform();
  return [effect, share](const History& history) {
    std::vector<double> values(history.size());
    BoucWen stiff(effect.length / 8.0, 1.3), soft(effect.length, 2.0);
    for (size_t k = 0; k < values.size(); ++k) {
      const double change = ChangeOf(history, k, effect.axis);
      const double of_stiff = stiff.Move(change), of_soft = soft.Move(change);
      values[k] = share * of_stiff + (1.0 - share) * of_soft;
    }
    return values;
  };
}

// The last move settles with its size: sign x (1 - exp(-|move| / length)).
Values SettledMove(const Effect& effect) {
  return [effect](const History& history) {
    std::vector<double> values(history.size(), 0.0);
    double move = 0.0;
    for (size_t k = 0; k < values.size(); ++k) {
      const double change = ChangeOf(history, k, effect.axis);
      if (change != 0.0) move = change;
      values[k] = std::copysign(1.0 - std::exp(-std::abs(move) / effect.length), move);
    }
    return values;
  };
}

// A servo of second order, damping 0.7, integrated along the path in small steps; the error is y - q:
//   of speed         y'' + 2 d w y' + w^2 y = w^2 q,           late by 2 d / w
//   of acceleration  y'' + 2 d w (y' - q') + w^2 (y - q) = 0,  late by 1 / w^2 times the acceleration
Values Servo(const Effect& effect) {
  return [effect](const History& history) {
    constexpr double kDamping = 0.7;
    const double w = effect.is_of_speed ? 2.0 * kDamping / effect.delay_s : 1.0 / effect.delay_s;
    const Path path(history, effect.axis);
    std::vector<double> values(history.size(), 0.0);
    double off = 0.0, off_speed = 0.0;  // e = y - q and e'
    const auto slope = [&](size_t from, double time_s, double e, double e_speed) {
      const Path::Point q = path.At(from, time_s);
      return -q.acceleration - 2.0 * kDamping * w * (e_speed + (effect.is_of_speed ? q.speed : 0.0)) - w * w * e;
    };
    for (size_t k = 0; k < values.size(); ++k) {
      if (history.BeginsSession(k)) {  // steady at the speed with which the session begins
        off = effect.is_of_speed ? -effect.delay_s * path.SpeedOf(k) : 0.0;
        off_speed = 0.0;
      } else {
        const double from_s = history.time_s[k - 1], elapsed_s = history.time_s[k] - from_s;
        constexpr double kMostSteps = 20000.0;  // a pause of a quarter of an hour: the servo has settled
        const int steps = static_cast<int>(std::min(kMostSteps, std::ceil(elapsed_s * w * 8.0)));
        const double h = steps > 0 ? std::min(elapsed_s / steps, 0.25 / w) : 0.0;
        const double start_s = history.time_s[k] - h * steps;
        for (int i = 0; i < steps; ++i) {
          const double t = start_s + i * h;
          const double a = slope(k - 1, t, off, off_speed), u = off_speed + 0.5 * h * a;
          const double b = slope(k - 1, t + 0.5 * h, off + 0.5 * h * off_speed, u), v = off_speed + 0.5 * h * b;
          const double c = slope(k - 1, t + 0.5 * h, off + 0.5 * h * u, v), x = off_speed + h * c;
          const double d = slope(k - 1, t + h, off + h * v, x);
          off += h / 6.0 * (off_speed + 2.0 * u + 2.0 * v + x);
          off_speed += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
      }
      values[k] = off;
    }
    return values;
  };
}

}  // namespace

Values IndependentValues(const Drawing& drawing, base::Random* random) {
  const Effect& effect = drawing.effect;
  switch (effect.kind) {
    case EffectKind::kCurve: {
      const Function curve = AnyFunction(drawing, random);
      return EveryMoment([axis = effect.axis, curve](const History& history, size_t k) {
        return curve(history.PositionsOf(k)[axis]);
      });
    }
    case EffectKind::kTimeCurve: {
      const Function drift = IndependentFunction(drawing.range, effect.length, false, random);
      return EveryMoment([drift, range = drawing.range](const History& history, size_t k) {
        return drift(std::clamp(history.time_s[k], range.low, range.high));
      });
    }
    case EffectKind::kRipple:
      return SkewedRipple(effect, random);
    case EffectKind::kGravity:
      return Compliance(drawing, random);
    case EffectKind::kCrossed:
      return Products(drawing, random);
    case EffectKind::kHeat:
      return Warming(effect);
    case EffectKind::kBacklash:
      return WornBacklash(drawing, random);
    case EffectKind::kWindUp:
      return DahlWindUp(effect);
    case EffectKind::kFriction:
      return TwoElements(effect, random);
    case EffectKind::kLastMove:
      return SettledMove(effect);
    case EffectKind::kFollowing:
      return Servo(effect);
  }
  return {};
}

}  // namespace axiscal::synthetic
