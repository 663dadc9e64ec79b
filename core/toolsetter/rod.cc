#include "core/toolsetter/rod.h"

#include "core/base/units.h"
#include "core/toolsetter/narrow_shade.h"

namespace axiscal::toolsetter {
namespace {

using base::kDegPerRad;

absl::Status Refuse(const std::string& what) { return absl::InvalidArgumentError("rod: " + what); }

// Rods wider than this many beams reach across the disc with an edge that 16 points integrate.
constexpr double kWide = 1.5;

}  // namespace

absl::Status Validate(const Rod& rod) {
  if (!(rod.radius_mm > 0.0 && rod.radius_mm <= kMaxRodRadiusMm)) {
    return Refuse(
        absl::StrFormat("R_r = %g mm, expected a radius above 0 and at most %g mm", rod.radius_mm, kMaxRodRadiusMm));
  }
  if (!(rod.fillet_mm >= 0.0 && rod.fillet_mm < rod.radius_mm)) {
    return Refuse(
        absl::StrFormat("R_f = %g mm, expected 0 or more and less than R_r = %g mm", rod.fillet_mm, rod.radius_mm));
  }
  const double face_deg = rod.face_rad * kDegPerRad;
  if (!(face_deg >= kMinFaceDeg && face_deg <= 90.0 + 1e-9)) {
    return Refuse(
        absl::StrFormat("phi = %g deg, expected %g to 90: the elevation of the end face's normal above the face of the "
                        "holder, 90 where "
                        "the face is square to the axis (a normal that points the other way up has phi and tau turned "
                        "round: -phi, tau + "
                        "180)",
                        face_deg, kMinFaceDeg));
  }
  if (!std::isfinite(rod.azimuth_rad) || !std::isfinite(rod.holder_rad)) return Refuse("tau or theta_th is no number");
  constexpr double kMaxLengthMm = 2000.0;
  if (!(rod.length_mm >= 0.0 && rod.length_mm <= kMaxLengthMm))
    return Refuse(absl::StrFormat("L_r = %g mm, expected 0 to %g mm", rod.length_mm, kMaxLengthMm));
  return absl::OkStatus();
}

RodEdge::RodEdge(const Rod& rod, const Beam& beam) {
  const double delta = rod.azimuth_rad + rod.holder_rad - beam.yaw_rad;
  cos_pitch_ = std::cos(beam.pitch_rad);
  sin_pitch_ = std::sin(beam.pitch_rad);
  sin_face_ = std::sin(rod.face_rad);
  // A face of 90 deg is square exactly, not by the 6e-17 that pi/2 lacks.
  cot_face_ = rod.face_rad == 0.5 * std::numbers::pi ? 0.0 : std::cos(rod.face_rad) / sin_face_;
  cos_delta_ = std::cos(delta);
  sin_delta_ = std::sin(delta);
  const double a = sin_pitch_ + cos_pitch_ * cot_face_ * cos_delta_;
  a_sign_ = a < 0.0 ? -1.0 : 1.0;
  shadow_.rho_mm = rod.radius_mm - rod.fillet_mm;
  shadow_.fillet_mm = rod.fillet_mm;
  shadow_.a = std::abs(a);
  shadow_.b = cos_pitch_ * cot_face_ * sin_delta_;
  shadow_.level_mm = cos_pitch_ * rod.fillet_mm / sin_face_;
}

std::array<double, kTriggerInputs> RodEdge::ByInput(double foot_mm) const {
  // By the envelope theorem the edge moves, at y, as the core does at its foot.
  const double rho_mm = shadow_.rho_mm, fillet_mm = shadow_.fillet_mm;
  const double w = std::sqrt(std::max(0.0, rho_mm * rho_mm - foot_mm * foot_mm));
  const double g = shadow_.a * foot_mm / w - shadow_.b;
  const double a_by_pitch = a_sign_ * (cos_pitch_ - sin_pitch_ * cot_face_ * cos_delta_);
  const double b_by_pitch = -sin_pitch_ * cot_face_ * sin_delta_;
  const double a_by_delta = -a_sign_ * cos_pitch_ * cot_face_ * sin_delta_;
  const double b_by_delta = cos_pitch_ * cot_face_ * cos_delta_;
  const double cot_by_face = -1.0 / (sin_face_ * sin_face_);
  const double cos_face = cot_face_ * sin_face_;
  std::array<double, kTriggerInputs> by = {};
  const double by_delta = -a_by_delta * w - b_by_delta * foot_mm;
  by[kYaw] = -by_delta;
  by[kAzimuth] = by_delta;
  by[kPitch] = -sin_pitch_ * fillet_mm / sin_face_ - a_by_pitch * w - b_by_pitch * foot_mm;
  by[kRodRadius] = -shadow_.a * rho_mm / w;
  by[kFillet] = cos_pitch_ / sin_face_ + shadow_.a * rho_mm / w - std::sqrt(1.0 + g * g);
  by[kFace] = -cos_pitch_ * fillet_mm * cos_face / (sin_face_ * sin_face_) -
              cot_by_face * cos_pitch_ * (a_sign_ * cos_delta_ * w + sin_delta_ * foot_mm);
  return by;
}

double ClosedFormHeightMm(const Rod& rod, const Beam& beam) {
  const double delta = rod.azimuth_rad + rod.holder_rad - beam.yaw_rad;
  const double cos_pitch = std::cos(beam.pitch_rad), cot_face = 1.0 / std::tan(rod.face_rad);
  const double a = std::abs(std::sin(beam.pitch_rad) + cos_pitch * cot_face * std::cos(delta));
  const double b = cos_pitch * cot_face * std::sin(delta);
  const double rho = rod.radius_mm - rod.fillet_mm;
  return (a * rho + rod.fillet_mm * std::sqrt(1.0 + b * b) - a * beam.radius_mm * beam.radius_mm / (6.0 * rho)) /
             cos_pitch -
         rod.fillet_mm / std::sin(rod.face_rad);
}

absl::StatusOr<Trigger> TriggerOf(const Rod& rod, const Beam& beam) {
  RETURN_IF_ERROR(Validate(beam));
  RETURN_IF_ERROR(Validate(rod));
  const RodEdge edge(rod, beam);
  const double cos_pitch = std::cos(beam.pitch_rad);
  Trigger trigger;
  std::array<double, kTriggerInputs> edge_by_input = {};  // the mean over the shadow's width
  const auto add = [&](double foot_mm, double share) {
    const std::array<double, kTriggerInputs> by = edge.ByInput(foot_mm);
    for (int input = kYaw; input < kTriggerInputs; ++input) edge_by_input[input] += by[input] * share;
  };
  std::optional<HalfShade> half;
  if (edge.shadow().rho_mm > kWide * beam.radius_mm) half = HalfShadeHeight(edge.shadow(), beam.radius_mm);
  double width_mm = 0.0, arc_rad = 0.0;
  if (half) {
    trigger.height_mm = half->height_mm / cos_pitch;
    trigger.area_mm2 = half->area_mm2;
    width_mm = half->width_mm;
    arc_rad = half->arc_rad;
    ForEdgePoints(edge.shadow(), half->foot_from_mm, half->foot_to_mm,
                  [&](double foot_mm, const FootPoint&, double weight_mm) { add(foot_mm, weight_mm / width_mm); });
  } else {
    const std::optional<NarrowHalfShade> narrow = NarrowHalfShadeHeight(edge, beam.radius_mm, rod.radius_mm);
    if (!narrow) {
      const double share = StripMm2(beam.radius_mm, rod.radius_mm) / (2.0 * HalfDiscMm2(beam.radius_mm));
      return Refuse(
          absl::StrFormat("R_r = %g mm shades at most %.1f %% of a beam of radius %g mm, the trigger fires at half: "
                          "expected a thicker rod",
                          rod.radius_mm, 100.0 * share, beam.radius_mm));
    }
    trigger.height_mm = narrow->height_mm / cos_pitch;
    trigger.area_mm2 = narrow->shade.area_mm2;
    width_mm = narrow->shade.WidthMm();
    arc_rad = narrow->shade.arc_rad;
    constexpr int kPanels = 200;  // the edge is steep where the shadow ends
    for (int i = 0; i < narrow->shade.span_count; ++i) {
      const auto [from_mm, to_mm] = narrow->shade.spans_mm[i];
      const double panel_mm = (to_mm - from_mm) / kPanels;
      for (int k = 0; k < kPanels; ++k) {
        ForGaussPoints(from_mm + k * panel_mm, from_mm + (k + 1) * panel_mm, [&](double y_mm, double weight_mm) {
          add(edge.shadow().FootMm(y_mm), weight_mm / width_mm);
        });
      }
    }
  }
  for (int input = kYaw; input < kTriggerInputs; ++input) trigger.by_input[input] = -edge_by_input[input] / cos_pitch;
  // The edge is lifted by Zd cos b, which pitch changes too.
  trigger.by_input[kPitch] += trigger.height_mm * std::tan(beam.pitch_rad);
  trigger.by_input[kBeamRadius] = beam.radius_mm * (arc_rad - std::numbers::pi) / (width_mm * cos_pitch);
  return trigger;
}

}  // namespace axiscal::toolsetter
