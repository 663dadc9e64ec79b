// Core computes in mm, rad, s and degrees Celsius. Micrometres, microradians, arc seconds and degrees appear only where
// text, wire messages or tables are read or written, and only through these factors: value_mm = value_um * kMmPerUm.
#ifndef AXISCAL_CORE_BASE_UNITS_H_
#define AXISCAL_CORE_BASE_UNITS_H_

#include <numbers>

namespace axiscal::base {

inline constexpr double kMmPerUm = 1e-3;
inline constexpr double kUmPerMm = 1e3;
inline constexpr double kRadPerUrad = 1e-6;
inline constexpr double kUradPerRad = 1e6;
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr double kDegPerRad = 180.0 / std::numbers::pi;
inline constexpr double kRadPerArcsec = kRadPerDeg / 3600.0;
inline constexpr double kArcsecPerRad = 3600.0 * kDegPerRad;

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_UNITS_H_
