#include <cmath>
#include <map>

#include "core/base/units.h"
#include "core/instruments/touch/sphere_fit.h"
#include "core/instruments/touch/touch_bind.h"
#include "core/instruments/touch/touch_model.h"

namespace axiscal::touch {
namespace {

using instruments::MeasuringRun;

absl::StatusOr<double> GateMm(const session::Session& session, const char* key) {
  const std::optional<std::string> text = session::FindHeader(session, key);
  if (!text) return kDefaultGateMm;
  double gate_um = 0.0;
  if (!absl::SimpleAtod(*text, &gate_um) || !std::isfinite(gate_um) || gate_um <= 0.0) {
    return absl::InvalidArgumentError(
        absl::StrCat("header '", key, ": ", *text, "', expected a number of micrometres above 0"));
  }
  return gate_um * base::kMmPerUm;
}

// Touches of one feature at one rotary pose, in time order.
std::map<std::vector<double>, std::vector<int>> Groups(const machine::Machine& machine, const MeasuringRun& run) {
  std::map<std::vector<double>, std::vector<int>> groups;
  for (int k = 0; k < run.reading_count(); ++k) {
    std::vector<double> key = {static_cast<double>(run.touches.feature_of[k])};
    for (int i = 0; i < run.axis_count; ++i) {
      constexpr double kSamePoseRad = 1e-6;
      if (machine.axes[i].kind != machine::AxisKind::kRotary) continue;
      key.push_back(std::round(run.PositionsOf(k)[i] / kSamePoseRad));
    }
    groups[key].push_back(k);
  }
  return groups;
}

absl::Status GateRepeats(const MeasuringRun& run, const std::vector<int>& group,
                         const std::vector<Eigen::Vector3d>& stylus_mm, double gate_mm) {
  constexpr double kSamePlaceMm = 0.010;  // across the approach: what a control's positioning leaves
  for (size_t i = 0; i < group.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const Eigen::Vector3d& approach = run.touches.approach[group[i]];
      if ((approach - run.touches.approach[group[j]]).norm() > 1e-6) continue;
      const Eigen::Vector3d apart_mm = stylus_mm[i] - stylus_mm[j];
      const double along_mm = apart_mm.dot(approach);
      if ((apart_mm - along_mm * approach).norm() > kSamePlaceMm || std::abs(along_mm) <= gate_mm) continue;
      return absl::InvalidArgumentError(absl::StrFormat(
          "session '%s': readings %d and %d repeat one touch of '%s' but differ by %.1f um, expected within "
          "repeat_gate_um = %g",
          run.session, group[j] + 1, group[i] + 1, run.touches.features[run.touches.feature_of[group[i]]].name,
          std::abs(along_mm) / base::kMmPerUm, gate_mm / base::kMmPerUm));
    }
  }
  return absl::OkStatus();
}

absl::Status GateFeature(const machine::Machine& machine, const MeasuringRun& run, int reading) {
  const double no_setup[instruments::kMaxSetupParameters] = {};
  double gap_mm = 0.0;
  Predict<double>(machine, run, reading, run.PositionsOf(reading), {}, no_setup, &gap_mm);
  const std::string& name = run.touches.features[run.touches.feature_of[reading]].name;
  if (std::abs(gap_mm) > kWrongFeatureMm) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "session '%s': reading %d stands %.3f mm off feature '%s', expected a touch within %g mm: is it a touch of "
        "another feature, are tool_tip_mm and stylus_radius_mm right?",
        run.session, reading + 1, gap_mm, name, kWrongFeatureMm));
  }
  const double cosine = run.touches.approach[reading].dot(NominalNormal(machine, run, reading));
  // 60 deg: no probe is sent that far off the normal, and another face of a block stands at 90.
  if (cosine < -0.5) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "session '%s': reading %d approaches feature '%s' at %.0f deg to its inward normal, expected within 60: is it a "
      "touch of another feature, or nx, ny, nz of the other sign?",
      run.session, reading + 1, name, std::acos(std::clamp(-cosine, -1.0, 1.0)) / base::kRadPerDeg));
}

}  // namespace

absl::Status GateTouches(const machine::Machine& machine, const session::Session& session, const MeasuringRun& run) {
  for (int k = 0; k < run.reading_count(); ++k) RETURN_IF_ERROR(GateFeature(machine, run, k));
  ASSIGN_OR_RETURN(const double radius_gate_mm, GateMm(session, "radius_gate_um"));
  ASSIGN_OR_RETURN(const double repeat_gate_mm, GateMm(session, "repeat_gate_um"));
  for (const auto& [key, group] : Groups(machine, run)) {
    const Feature& feature = run.touches.features[run.touches.feature_of[group[0]]];
    std::vector<Eigen::Vector3d> in_table_mm, in_bed_mm;
    for (const int k : group) {
      const auto pose = machine::EvaluateChain<double>(machine, run.PositionsOf(k), {});
      in_bed_mm.push_back(pose.bed_from_tool * run.tip_mm);
      in_table_mm.push_back(pose.bed_from_table.Inverse() * in_bed_mm.back());
    }
    RETURN_IF_ERROR(GateRepeats(run, group, in_bed_mm, repeat_gate_mm));
    if (!feature.is_sphere) continue;
    const std::optional<Sphere> sphere = FitSphere(in_table_mm);
    const double expected_mm = feature.radius_mm + run.touches.stylus_radius_mm;
    if (!sphere || std::abs(sphere->radius_mm - expected_mm) <= radius_gate_mm) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "session '%s': the %d touches of sphere '%s' from reading %d lie on a radius of %.4f mm, expected %.4f "
        "(sphere %g + stylus_radius_mm %g) within radius_gate_um = %g: was it measured with another stylus?",
        run.session, group.size(), feature.name, group[0] + 1, sphere->radius_mm, expected_mm, feature.radius_mm,
        run.touches.stylus_radius_mm, radius_gate_mm / base::kMmPerUm));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::touch
