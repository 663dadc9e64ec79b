#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/toolsetter/reference.h"

namespace axiscal::toolsetter {
namespace {

using base::kDegPerRad;
using base::kUmPerMm;
using Json = nlohmann::ordered_json;

// Z in mm with um beside it, angles in deg.
Json ParameterJson(const Fitted& fitted, bool is_angle) {
  if (!fitted.is_identifiable) return {{"estimate", nullptr}, {"sigma", nullptr}, {"identifiable", false}};
  const double estimate = is_angle ? fitted.estimate * kDegPerRad : fitted.estimate;
  if (!fitted.is_free) return {{"stated", estimate}};
  const double sigma = is_angle ? fitted.sigma * kDegPerRad : fitted.sigma;
  return {{"estimate", estimate}, {"sigma", sigma}, {"identifiable", true}};
}

}  // namespace

std::string ToJson(const RodSession& session, const Reference& reference) {
  Json json;
  json["session"] = session.session;
  json["reference_mm"] = ParameterJson(reference.parameters[kReferenceZ], false);
  json["yaw_deg"] = ParameterJson(reference.parameters[kReferenceYaw], true);
  json["pitch_deg"] = ParameterJson(reference.parameters[kReferencePitch], true);
  json["range_um"] = reference.range_mm * kUmPerMm;
  json["between_rods_um"] = reference.between_rods_mm * kUmPerMm;
  json["chi2"] = reference.chi2;
  json["degrees_of_freedom"] = reference.degrees_of_freedom;
  json["rods"] = Json::array();
  const Fitted& z = reference.parameters[kReferenceZ];
  for (const RodAnswer& rod : reference.rods) {
    Json row = {{"rod", rod.name},
                {"readouts", rod.readouts},
                {"mean_mm", rod.mean_mm},
                {"range_um", rod.range_mm * kUmPerMm},
                {"trigger_height_mm", rod.trigger.height_mm},
                {"reference_mm", rod.reference_mm},
                {"sigma_um", rod.sigma_mm * kUmPerMm}};
    row["residual_um"] = z.is_identifiable ? Json((rod.reference_mm - z.estimate) * kUmPerMm) : Json();
    json["rods"].push_back(std::move(row));
  }
  json["not_told_apart"] = Json::array();
  for (const Eigen::Vector3d& unseen : reference.unseen) {
    // Per mm of Z where Z takes part, else per rad.
    const double by = std::abs(unseen[kReferenceZ]) > 1e-9 ? unseen[kReferenceZ] : unseen.cwiseAbs().maxCoeff();
    const Eigen::Vector3d direction = unseen / by;
    Json row = Json::object();
    if (std::abs(direction[0]) > 1e-9) row["Z_um"] = 1.0;
    const double per = std::abs(direction[0]) > 1e-9 ? 1e3 : 1.0;  // urad per um
    if (std::abs(direction[1]) > 1e-9) row["yaw_urad"] = direction[1] * per;
    if (std::abs(direction[2]) > 1e-9) row["pitch_urad"] = direction[2] * per;
    json["not_told_apart"].push_back(std::move(row));
  }
  if (!reference.next) return json.dump(1) + "\n";
  Json angles = Json::array();
  for (const double holder_rad : reference.next->holder_rad) angles.push_back(holder_rad * kDegPerRad);
  json["next_measurement"] = {{"rod", reference.next->rod},
                              {"theta_th_deg", angles},
                              {"sigma_um", reference.next->sigma[kReferenceZ] * kUmPerMm},
                              {"yaw_sigma_deg", reference.next->sigma[kReferenceYaw] * kDegPerRad},
                              {"pitch_sigma_deg", reference.next->sigma[kReferencePitch] * kDegPerRad}};
  return json.dump(1) + "\n";
}

}  // namespace axiscal::toolsetter
