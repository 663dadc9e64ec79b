// The slow obvious twin of half_shade.h and of the edges of rods and inserts: everything is bisected or searched for,
// from the geometry. A lower edge is any function z(y) at height 0, mm.
#ifndef AXISCAL_CORE_TOOLSETTER_TESTING_SLOW_HALF_SHADE_H_
#define AXISCAL_CORE_TOOLSETTER_TESTING_SLOW_HALF_SHADE_H_

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "core/toolsetter/beam.h"
#include "core/toolsetter/cutter.h"
#include "core/toolsetter/half_shade.h"
#include "core/toolsetter/rod.h"

namespace axiscal::toolsetter {

using LowerEdge = std::function<double(double y_mm)>;

// Where is_low turns from true to false between `low` and `high`.
template <typename IsLow>
double Bisect(double low, double high, const IsLow& is_low) {
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (is_low(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// The height at which what lies above the edge covers half of the disc. The edge crosses the circle once on each side.
// `panels` of 16 Gauss points each integrate it.
inline double SlowHalfShadeHeight(const LowerEdge& edge, double radius_mm, int panels = 6) {
  const auto shaded_mm2 = [&](double height_mm) {
    double ends_mm[2], area_mm2 = 0.0;
    for (const int right : {0, 1}) {
      const double side = right == 1 ? 1.0 : -1.0;
      // Angle from the disc's lowest point: on the circle, below the edge at 0, above it at pi.
      const double t = Bisect(0.0, std::numbers::pi, [&](double at) {
        return -radius_mm * std::cos(at) < edge(side * radius_mm * std::sin(at)) + height_mm;
      });
      ends_mm[right] = side * radius_mm * std::sin(t);
      // Between the arc above the crossing and z = 0: its integral of z.
      area_mm2 += 0.5 * radius_mm * radius_mm * (std::numbers::pi - t - std::sin(t) * std::cos(t));
    }
    // Less what lies between the edge and z = 0.
    for (int i = 0; i < panels; ++i) {
      const double width_mm = (ends_mm[1] - ends_mm[0]) / panels, from_mm = ends_mm[0] + i * width_mm;
      area_mm2 -= Integrate(from_mm, from_mm + width_mm, [&](double y_mm) { return edge(y_mm) + height_mm; });
    }
    return area_mm2;
  };
  const double middle_mm = -edge(0.0);
  return Bisect(middle_mm - 0.9 * radius_mm, middle_mm + 0.9 * radius_mm,
                [&](double height_mm) { return shaded_mm2(height_mm) > HalfDiscMm2(radius_mm); });
}

// A rod's edge: the rim of the rod's core (thinner and higher by the fillet's ball), projected, then the ball.
inline LowerEdge SlowRodEdge(const Rod& rod, const Beam& beam) {
  const double azimuth = rod.azimuth_rad + rod.holder_rad, phi = rod.face_rad, rho_mm = rod.radius_mm - rod.fillet_mm;
  const auto core_mm = [=](double y_mm) {
    double lowest_mm = 1e9;
    const double asin = std::asin(std::clamp(y_mm / rho_mm, -1.0, 1.0));
    for (const double angle : {asin, std::numbers::pi - asin}) {
      const double X = rho_mm * std::cos(angle + beam.yaw_rad), Y = rho_mm * std::sin(angle + beam.yaw_rad);
      const double Z = rod.fillet_mm / std::sin(phi) -
                       std::cos(phi) / std::sin(phi) * (X * std::cos(azimuth) + Y * std::sin(azimuth));
      const double along_mm = X * std::cos(beam.yaw_rad) + Y * std::sin(beam.yaw_rad);
      lowest_mm = std::min(lowest_mm, std::cos(beam.pitch_rad) * Z - std::sin(beam.pitch_rad) * along_mm);
    }
    return lowest_mm;
  };
  return [=](double y_mm) {
    if (rod.fillet_mm == 0.0) return core_mm(y_mm);
    const auto ball_mm = [&](double at_mm) {
      const double off_mm = y_mm - at_mm;
      return core_mm(at_mm) - std::sqrt(std::max(0.0, rod.fillet_mm * rod.fillet_mm - off_mm * off_mm));
    };
    double low = std::max(-rho_mm, y_mm - rod.fillet_mm), high = std::min(rho_mm, y_mm + rod.fillet_mm);
    for (int i = 0; i < 60; ++i) {  // one minimum: thirds
      const double first = low + (high - low) / 3.0, second = high - (high - low) / 3.0;
      (ball_mm(first) > ball_mm(second) ? low : high) = ball_mm(first) > ball_mm(second) ? first : second;
    }
    return ball_mm(0.5 * (low + high));
  };
}

// An insert's edge: the points of its cutting circle that are seen at y, one on each half.
inline LowerEdge SlowInsertEdge(const Cutter& cutter, double offset_mm, double psi_rad) {
  const double cr = std::cos(cutter.radial_rad), sr = std::sin(cutter.radial_rad);
  const double ca = std::cos(cutter.axial_rad), sa = std::sin(cutter.axial_rad), R = cutter.insert_radius_mm;
  struct Point {
    double y_mm, z_mm;
  };
  const auto at = [=](double x) {
    const double along = R * std::cos(x) - R, up = R - R * std::sin(x);  // in the insert's own plane
    const double X = cutter.tool_radius_mm + cr * along + sr * sa * up, Y = -sr * along + cr * sa * up;
    return Point{std::sin(psi_rad) * X + std::cos(psi_rad) * Y - offset_mm, ca * up};
  };
  // The angles at which the projected circle reaches farthest to either side.
  double most = 0.0;
  for (int i = 0; i < 3600; ++i) {
    const double x = i * std::numbers::pi / 1800.0;
    if (at(x).y_mm > at(most).y_mm) most = x;
  }
  double low = most - 0.01, high = most + 0.01;
  for (int i = 0; i < 60; ++i) {
    const double first = low + (high - low) / 3.0, second = high - (high - low) / 3.0;
    (at(first).y_mm < at(second).y_mm ? low : high) = at(first).y_mm < at(second).y_mm ? first : second;
  }
  const double right = 0.5 * (low + high), left = right + std::numbers::pi;
  return [=](double y_mm) {
    const double there = Bisect(right, left, [&](double x) { return at(x).y_mm > y_mm; });
    const double back = Bisect(left, left + std::numbers::pi, [&](double x) { return at(x).y_mm < y_mm; });
    return std::min(at(there).z_mm, at(back).z_mm);
  };
}

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_TESTING_SLOW_HALF_SHADE_H_
