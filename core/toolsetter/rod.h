// Cylindrical measuring rods with a slightly tilted end face and a rounded edge in a tool setter (Fang 2022, ch. 2).
// End face: normal n = (cos phi cos tau, cos phi sin tau, sin phi) in the holder's frame; the holder stands at theta_th
// in the spindle. Zd is the height of the rod's bottom centre (where end face and axis meet) above the beam's reference
// point when the trigger fires, so that the reference point stands at  mO_z = Z'_s - L_r - Zd  (2.38), Z'_s the
// spindle's Z.
//
// Shadow: a rolling-ball fillet is the rod eroded by R_f and grown by a ball of R_f, and projection commutes with that.
// With rho = R_r - R_f, delta = tau + theta_th - yaw, b = pitch:
//   A = |sin b + cos b cot phi cos delta|      B = cos b cot phi sin delta
//   core(Y) = cos b (Zd + R_f / sin phi) - A sqrt(rho^2 - Y^2) - B Y       lower edge of the projected eroded rod
//   edge: y = Y + R_f g/h, z = core(Y) - R_f/h, g = core'(Y), h = sqrt(1 + g^2)
#ifndef AXISCAL_CORE_TOOLSETTER_ROD_H_
#define AXISCAL_CORE_TOOLSETTER_ROD_H_

#include <array>
#include <numbers>

#include "core/toolsetter/beam.h"
#include "core/toolsetter/half_shade.h"

namespace axiscal::toolsetter {

struct Rod {
  double radius_mm = 0.0;                    // R_r
  double fillet_mm = 0.0;                    // R_f, 0: a sharp edge
  double face_rad = 0.5 * std::numbers::pi;  // phi: elevation of the end face's normal, pi/2 where it is not tilted
  double azimuth_rad = 0.0;                  // tau
  double length_mm = 0.0;                    // L_r; only the reference point needs it
  double holder_rad = 0.0;                   // theta_th
};

inline constexpr double kMaxRodRadiusMm = 100.0;
inline constexpr double kMinFaceDeg = 45.0;  // a more tilted face is an angle of another convention

// INVALID_ARGUMENT naming field, value and rule: among them a normal that is not given by its elevation (0 for 90, or
// more than 90: it points the other way up).
absl::Status Validate(const Rod& rod);

// What Zd depends on, in the order of its derivatives.
enum TriggerInput { kBeamRadius, kYaw, kPitch, kRodRadius, kFillet, kFace, kAzimuth, kTriggerInputs };

struct Trigger {
  double height_mm = 0.0;  // Zd
  double area_mm2 = 0.0;   // shaded there: pi R_l^2 / 2
  // dZd per mm or rad. Where A is 0 (a face that the beam sees edge on) Zd has a kink; the side of A > 0 stands.
  std::array<double, kTriggerInputs> by_input = {};
};

// Exact to 1e-12 mm. INVALID_ARGUMENT as above, or when the rod is so narrow that it never shades half of the beam.
absl::StatusOr<Trigger> TriggerOf(const Rod& rod, const Beam& beam);

// Edge through the beam's centre plus its curvature, a start for the exact solution:
//   Zd = (A rho + R_f sqrt(1 + B^2)) / cos b - R_f / sin phi - A R_l^2 / (6 rho cos b)
// Within 1.1e-8 mm for the published rods; the error grows with R_f and tilt.
double ClosedFormHeightMm(const Rod& rod, const Beam& beam);

// The lower edge of a rod's shadow at Zd = 0.
class RodEdge {
 public:
  RodEdge(const Rod& rod, const Beam& beam);
  const ShadowEdge& shadow() const { return shadow_; }
  EdgePoint At(double y_mm) const { return shadow_.At(y_mm); }
  // d(z at the y to which the foot belongs) per input, Zd held; the beam's radius has none.
  std::array<double, kTriggerInputs> ByInput(double foot_mm) const;

 private:
  ShadowEdge shadow_;
  double cos_pitch_, sin_pitch_, cot_face_, sin_face_, cos_delta_, sin_delta_, a_sign_;
};

}  // namespace axiscal::toolsetter

#endif  // AXISCAL_CORE_TOOLSETTER_ROD_H_
