#include "core/toolsetter/plan.h"

#include <algorithm>
#include <numbers>

#include "core/base/units.h"

namespace axiscal::toolsetter {
namespace {

absl::Status InRange(const char* name, int value, int least, int most) {
  if (value >= least && value <= most) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat(name, " = ", value, ", expected ", least, " to ", most));
}

}  // namespace

absl::StatusOr<RodSession> PlanRods(RodSession session, const std::string& turned, int holders, int readouts) {
  RETURN_IF_ERROR(InRange("readouts", readouts, 1, 100));
  RETURN_IF_ERROR(InRange("holders", holders, 2, 360));
  std::vector<MeasuredRod> rods;
  for (const MeasuredRod& rod : session.rods) {
    const int positions = rod.name == turned ? holders : 1;
    for (int i = 0; i < positions; ++i) {
      const double angle_deg = 360.0 * i / holders;
      rods.push_back(rod);
      rods.back().rod.holder_rad += angle_deg * base::kRadPerDeg;
      if (i > 0) absl::StrAppend(&rods.back().name, absl::StrFormat("@%g", angle_deg));
      ASSIGN_OR_RETURN(const Trigger trigger, TriggerOf(rods.back().rod, session.beam));
      rods.back().readouts_mm.assign(readouts, rod.rod.length_mm + trigger.height_mm);
    }
  }
  const bool is_there = turned.empty() || std::any_of(session.rods.begin(), session.rods.end(),
                                                      [&](const MeasuredRod& rod) { return rod.name == turned; });
  if (!is_there) return absl::InvalidArgumentError("'" + turned + "' is no rod of session " + session.session);
  session.rods = std::move(rods);
  return session;
}

absl::StatusOr<CurveSession> PlanStarts(CurveSession session, int starts) {
  RETURN_IF_ERROR(Validate(session.cutter, session.run));
  RETURN_IF_ERROR(InRange("starts", starts, session.cutter.inserts + 2, 360));
  session.starts_rad.clear();
  for (int i = 0; i < starts; ++i) session.starts_rad.push_back(2.0 * std::numbers::pi * i / starts);
  ASSIGN_OR_RETURN(
      const auto curve,
      ComputeCurve(session.cutter, session.run, std::vector<double>(session.cutter.inserts, 0.0), session.starts_rad));
  session.lengths_mm.clear();
  for (const CurvePoint& point : curve) session.lengths_mm.push_back(point.height_mm);
  return session;
}

}  // namespace axiscal::toolsetter
