#include <cmath>
#include <set>

#include "core/base/units.h"
#include "core/toolsetter/reference.h"

namespace axiscal::toolsetter {
namespace {

using base::kDegPerRad;
using base::kUmPerMm;

// Z in mm, angles in deg.
reports::BeamParameter ParameterOf(const Fitted& fitted, bool is_angle) {
  reports::BeamParameter parameter;
  if (!fitted.is_identifiable) return parameter;
  const double unit = is_angle ? kDegPerRad : 1.0;
  if (!fitted.is_free) {
    parameter.stated = fitted.estimate * unit;
    return parameter;
  }
  parameter.estimate = fitted.estimate * unit;
  parameter.sigma = fitted.sigma * unit;
  parameter.identifiable = true;
  return parameter;
}

reports::Unseen UnseenOf(const Eigen::Vector3d& unseen) {
  constexpr double kTakesPart = 1e-9;
  // Per mm of Z where Z takes part, else per rad.
  const bool with_z = std::abs(unseen[kReferenceZ]) > kTakesPart;
  const double by = with_z ? unseen[kReferenceZ] : unseen.cwiseAbs().maxCoeff();
  const Eigen::Vector3d direction = unseen / by;
  const double per = std::abs(direction[0]) > kTakesPart ? 1e3 : 1.0;  // urad per um
  reports::Unseen change;
  if (std::abs(direction[0]) > kTakesPart) change.z_um = 1.0;
  if (std::abs(direction[1]) > kTakesPart) change.yaw_urad = direction[1] * per;
  if (std::abs(direction[2]) > kTakesPart) change.pitch_urad = direction[2] * per;
  return change;
}

}  // namespace

reports::BeamReference ReportOf(const RodSession& session, const Reference& reference) {
  reports::BeamReference report;
  report.session = session.session;
  const Fitted& z = reference.parameters[kReferenceZ];
  report.reference_mm = ParameterOf(z, false);
  report.yaw_deg = ParameterOf(reference.parameters[kReferenceYaw], true);
  report.pitch_deg = ParameterOf(reference.parameters[kReferencePitch], true);
  report.range_um = reference.range_mm * kUmPerMm;
  report.between_rods_um = reference.between_rods_mm * kUmPerMm;
  report.chi2 = reference.chi2;
  report.degrees_of_freedom = reference.degrees_of_freedom;
  report.coverage_factor = reference.coverage_factor;
  reports::BeamParameter* const parameters[] = {&report.reference_mm, &report.yaw_deg, &report.pitch_deg};
  reports::NoFreedom warning;
  for (int i = 0; i < kReferenceParameters; ++i) {
    const Fitted& fitted = reference.parameters[i];
    if (!fitted.is_free || !fitted.is_identifiable) continue;
    const char* const name = ParameterName(static_cast<ReferenceParameter>(i));
    absl::StrAppend(&warning.unknowns, warning.unknowns.empty() ? "" : ", ", name);
    if (reference.has_interval[i]) continue;
    parameters[i]->sigma = reports::kNoNumber;
    warning.without_sigma.push_back(name);
  }
  if (reference.degrees_between_rods == 0 && !warning.unknowns.empty()) {
    std::set<std::string> bodies;
    for (const RodAnswer& rod : reference.rods) bodies.insert(rod.name.substr(0, rod.name.find('@')));
    warning.readings = absl::StrCat(bodies.size(), bodies.size() == 1 ? " rod" : " rods");
    warning.what_to_do =
        "state how well the length of each rod is known (rod_sigma), or measure more rods than there are unknowns";
    report.warnings.push_back(reports::InWords(warning));
  }
  for (const RodAnswer& rod : reference.rods) {
    report.rods.push_back({.rod = rod.name,
                           .readouts = rod.readouts,
                           .mean_mm = rod.mean_mm,
                           .range_um = rod.range_mm * kUmPerMm,
                           .trigger_height_mm = rod.trigger.height_mm,
                           .reference_mm = rod.reference_mm,
                           .sigma_um = rod.sigma_mm * kUmPerMm,
                           .residual_um = z.is_identifiable ? (rod.reference_mm - z.estimate) * kUmPerMm
                                                            : reports::kNoNumber});
  }
  for (const Eigen::Vector3d& unseen : reference.unseen) report.not_told_apart.push_back(UnseenOf(unseen));
  if (!reference.next) return report;
  reports::RodProposal& next = report.next_measurement.emplace();
  next.rod = reference.next->rod;
  for (const double holder_rad : reference.next->holder_rad) next.theta_th_deg.push_back(holder_rad * kDegPerRad);
  next.sigma_um = reference.next->sigma[kReferenceZ] * kUmPerMm;
  next.yaw_sigma_deg = reference.next->sigma[kReferenceYaw] * kDegPerRad;
  next.pitch_sigma_deg = reference.next->sigma[kReferencePitch] * kDegPerRad;
  return report;
}

}  // namespace axiscal::toolsetter
