#include "core/toolsetter/cutter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/units.h"

namespace axiscal::toolsetter {
namespace {

using base::kDegPerRad;
using base::kRadPerDeg;

constexpr int kMaxInserts = 24;

struct Limit {
  const char* name;
  double number, min, max;
  const char* unit;
};

absl::Status Check(const Limit& limit) {
  if (limit.number >= limit.min && limit.number <= limit.max) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrFormat("%s = %g, expected %g to %g %s", limit.name, limit.number, limit.min, limit.max, limit.unit));
}

}  // namespace

double Cutter::InsertAngle(int k) const {
  return insert_angles_rad.empty() ? kTurn * k / inserts : insert_angles_rad[k];
}

absl::Status Validate(const Cutter& cutter) {
  const Limit limits[] = {
      {"tool_radius_mm", cutter.tool_radius_mm, 0.1, 500.0, "mm"},
      {"insert_radius_mm", cutter.insert_radius_mm, 0.1, 100.0, "mm"},
      {"inserts", static_cast<double>(cutter.inserts), 1.0, kMaxInserts, ""},
      {"radial_angle_deg", cutter.radial_rad * kDegPerRad, -45.0, 45.0, "deg"},
      {"axial_angle_deg", cutter.axial_rad * kDegPerRad, -45.0, 45.0, "deg"},
      {"theta_t_deg", cutter.theta_t_rad * kDegPerRad, -3600.0, 3600.0, "deg"},
      {"clearance_deg", cutter.clearance_rad * kDegPerRad, 0.0, 45.0, "deg"},
      {"insert_thickness_mm", cutter.insert_thickness_mm, 0.0, 50.0, "mm"},
  };
  for (const Limit& limit : limits) RETURN_IF_ERROR(Check(limit));
  if (cutter.insert_thickness_mm * std::tan(cutter.clearance_rad) >= cutter.insert_radius_mm) {
    return absl::InvalidArgumentError(
        absl::StrFormat("clearance_deg = %g, the flank of an insert of %g mm ends in a point",
                        cutter.clearance_rad * kDegPerRad, cutter.insert_thickness_mm));
  }
  const std::vector<double>& angles = cutter.insert_angles_rad;
  if (angles.empty()) return absl::OkStatus();
  if (static_cast<int>(angles.size()) != cutter.inserts) {
    return absl::InvalidArgumentError(absl::StrFormat("insert_angles_deg: %d angles, expected %d: one per insert",
                                                      static_cast<int>(angles.size()), cutter.inserts));
  }
  for (size_t i = 0; i < angles.size(); ++i) {
    if (!std::isfinite(angles[i])) return absl::InvalidArgumentError("insert_angles_deg: an angle is no number");
    for (size_t j = 0; j < i; ++j) {
      constexpr double kApartRad = 1.0 * kRadPerDeg;
      if (std::abs(std::remainder(angles[i] - angles[j], kTurn)) >= kApartRad) continue;
      return absl::InvalidArgumentError(absl::StrFormat(
          "insert_angles_deg: inserts %d and %d stand at %g and %g deg, expected one insert per angle",
          static_cast<int>(j + 1), static_cast<int>(i + 1), angles[j] * kDegPerRad, angles[i] * kDegPerRad));
    }
  }
  if (angles[0] == 0.0) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrFormat(
      "insert_angles_deg: insert 1 at %g deg, expected 0: angles count from insert 1", angles[0] * kDegPerRad));
}

absl::Status Validate(const Cutter& cutter, const CutterRun& run) {
  RETURN_IF_ERROR(Validate(cutter));
  const Limit limits[] = {
      {"offset_d_mm", run.offset_mm, -600.0, 600.0, "mm"},
      {"beam_radius_mm", run.beam_radius_mm, 1e-3, 5.0, "mm"},
      {"spindle_rpm", run.spindle_rpm, 1.0, 1e6, "rpm"},
      {"feed_mm_min", run.feed_mm_min, 1e-3, kMaxFeedMmMin, "mm/min"},
      {"start_height_mm", run.start_height_mm, -100.0, 1000.0, "mm"},
  };
  for (const Limit& limit : limits) RETURN_IF_ERROR(Check(limit));
  if (run.beam_radius_mm > 0.2 * cutter.insert_radius_mm) {
    return absl::InvalidArgumentError(
        absl::StrFormat("beam_radius_mm = %g, expected at most a fifth of insert_radius_mm = %g: a smaller insert does "
                        "not shade the beam "
                        "with one edge",
                        run.beam_radius_mm, cutter.insert_radius_mm));
  }
  return absl::OkStatus();
}

absl::Status ValidateWear(const Cutter& cutter, const std::vector<double>& wear_mm) {
  if (static_cast<int>(wear_mm.size()) != cutter.inserts) {
    return absl::InvalidArgumentError(absl::StrFormat("wear_mm: %d numbers, expected %d: one per insert",
                                                      static_cast<int>(wear_mm.size()), cutter.inserts));
  }
  for (size_t i = 0; i < wear_mm.size(); ++i) {
    if (wear_mm[i] >= 0.0 && wear_mm[i] < cutter.insert_radius_mm) continue;
    return absl::InvalidArgumentError(absl::StrFormat(
        "wear_mm: %g of insert %d, expected 0 or more and less than the insert's radius of %g mm (wear stands the edge "
        "higher)",
        wear_mm[i], static_cast<int>(i + 1), cutter.insert_radius_mm));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::toolsetter
