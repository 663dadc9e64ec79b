// Smooth random functions of one variable, in the fitted form and in others.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/synthetic/forms.h"

namespace axiscal::synthetic {
namespace {

// Terms beyond this share of the first one's deviation change nothing that a reading shows.
constexpr double kLeastDeviation = 1e-4;
constexpr int kMostTerms = 400;

struct Sines {
  double from = 0.0, spacing = 0.0;  // phi_j = sin(j spacing (q - from))
  std::vector<double> weights;
};

Function FourierSeries(double length, base::Random* random) {
  std::vector<std::pair<double, double>> weights;  // of cos nq and sin nq, n = 1 ...
  for (int n = 1; n <= kMostTerms; ++n) {
    const double deviation = MaternDeviation(n, length) / MaternDeviation(1.0, length);
    if (deviation < kLeastDeviation) break;
    const double cosine = deviation * random->Normal(), sine = deviation * random->Normal();
    weights.emplace_back(cosine, sine);
  }
  return [weights](double q) {
    double sum = 0.0;
    for (size_t i = 0; i < weights.size(); ++i) {
      const double angle = (static_cast<double>(i) + 1.0) * q;
      sum += weights[i].first * std::cos(angle) + weights[i].second * std::sin(angle);
    }
    return sum;
  };
}

// ---- forms that are not fitted

struct Bump {
  double at = 0.0, width = 1.0, height = 0.0;
};

// Heights at bumps a length apart or less; around a turn they are von Mises bumps, which close.
Function Bumps(const Range& range, double length, bool is_rotary, base::Random* random) {
  const double width = is_rotary ? std::min(length, 1.0) : length;
  const double low = is_rotary ? 0.0 : range.low - width;
  const double span = is_rotary ? 2.0 * std::numbers::pi : range.length() + 2.0 * width;
  const int count = std::clamp(static_cast<int>(std::ceil(1.5 * span / width)), 3, kMostTerms);
  std::vector<Bump> bumps(count);
  for (Bump& bump : bumps) {
    bump.at = low + span * random->Uniform();
    bump.width = width * (0.7 + 0.6 * random->Uniform());
    bump.height = random->Normal();
  }
  return [bumps, is_rotary](double q) {
    double sum = 0.0;
    for (const Bump& bump : bumps) {
      const double off = q - bump.at;
      const double exponent =
          is_rotary ? (std::cos(off) - 1.0) / (bump.width * bump.width) : -0.5 * off * off / (bump.width * bump.width);
      sum += bump.height * std::exp(exponent);
    }
    return sum;
  };
}

// Through random knots a length apart, slopes of central differences. Beyond the ends it goes on straight; around a
// turn it closes.
Function Spline(const Range& range, double length, bool is_rotary, base::Random* random) {
  const double low = is_rotary ? 0.0 : range.low;
  const double span = is_rotary ? 2.0 * std::numbers::pi : range.length();
  const int pieces = std::clamp(static_cast<int>(std::lround(span / length)), 3, kMostTerms);
  std::vector<double> knots(is_rotary ? pieces : pieces + 1);
  for (double& knot : knots) knot = random->Normal();
  const double spacing = span / pieces;
  return [=](double q) {
    const int count = static_cast<int>(knots.size());
    const auto knot = [&](int i) {
      return knots[is_rotary ? ((i % count) + count) % count : std::clamp(i, 0, count - 1)];
    };
    const auto slope = [&](int i) { return 0.5 * (knot(i + 1) - knot(i - 1)); };
    double u = (q - low) / spacing;
    if (!is_rotary && u <= 0.0) return knot(0) + slope(0) * u;
    if (!is_rotary && u >= pieces) return knot(pieces) + slope(pieces) * (u - pieces);
    const double floor = std::floor(u);
    const int i = static_cast<int>(std::fmod(floor, 1e9));
    u -= floor;
    const double v = 1.0 - u;
    return (1.0 + 2.0 * u) * v * v * knot(i) + u * v * v * slope(i) + u * u * (3.0 - 2.0 * u) * knot(i + 1) -
           u * u * v * slope(i + 1);
  };
}

// Rahimi and Recht 2007: cosines of random frequencies, a squared exponential kernel; around a turn of the point
// (cos q, sin q).
Function FourierFeatures(double length, bool is_rotary, base::Random* random) {
  struct Feature {
    double along, across, phase, weight;
  };
  std::vector<Feature> features(60);
  for (Feature& feature : features) {
    feature.along = random->Normal() / length;
    feature.across = random->Normal() / length;
    feature.phase = 2.0 * std::numbers::pi * random->Uniform();
    feature.weight = random->Normal();
  }
  return [features, is_rotary](double q) {
    double sum = 0.0;
    for (const Feature& feature : features) {
      const double angle = is_rotary ? feature.along * std::cos(q) + feature.across * std::sin(q) : feature.along * q;
      sum += feature.weight * std::cos(angle + feature.phase);
    }
    return sum;
  };
}

}  // namespace

double MaternDeviation(double frequency, double length) {
  return std::pow(5.0 / (length * length) + frequency * frequency, -1.5);
}

Function OwnFunction(const Range& range, double length, bool is_rotary, base::Random* random) {
  if (is_rotary) return FourierSeries(length, random);
  const double wide = 1.4 * range.length();
  Sines sines{range.low - 0.2 * range.length(), std::numbers::pi / wide, {}};
  for (int j = 1; j <= kMostTerms; ++j) {
    const double deviation = MaternDeviation(j * sines.spacing, length) / MaternDeviation(sines.spacing, length);
    if (deviation < kLeastDeviation) break;
    sines.weights.push_back(deviation * random->Normal());
  }
  return [sines](double q) {
    double sum = 0.0;
    for (size_t j = 0; j < sines.weights.size(); ++j)
      sum += sines.weights[j] * std::sin((static_cast<double>(j) + 1.0) * sines.spacing * (q - sines.from));
    return sum;
  };
}

Function IndependentFunction(const Range& range, double length, bool is_rotary, base::Random* random) {
  const double which = random->Uniform();
  if (which < 1.0 / 3.0) return Bumps(range, length, is_rotary, random);
  if (which < 2.0 / 3.0) return Spline(range, length, is_rotary, random);
  return FourierFeatures(length, is_rotary, random);
}

}  // namespace axiscal::synthetic
