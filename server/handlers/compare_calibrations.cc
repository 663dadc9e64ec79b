#include "server/handlers/compare_calibrations.h"

#include <cmath>

#include "core/base/units.h"
#include "proto/convert/field.h"
#include "server/handlers/axis_spans.h"
#include "server/inputs/compared.h"

namespace axiscal::handlers {
namespace {

using records::CalibrationRecord;

v1::DifferenceVerdict ToProto(compare::Verdict verdict) {
  switch (verdict) {
    case compare::Verdict::kAgrees:
      return v1::DIFFERENCE_VERDICT_AGREES;
    case compare::Verdict::kMayDiffer:
      return v1::DIFFERENCE_VERDICT_MAY_DIFFER;
    case compare::Verdict::kDiffers:
      return v1::DIFFERENCE_VERDICT_DIFFERS;
    case compare::Verdict::kNotDetermined:
      return v1::DIFFERENCE_VERDICT_NOT_DETERMINED;
    case compare::Verdict::kOnlyOne:
      return v1::DIFFERENCE_VERDICT_ONLY_ONE;
    case compare::Verdict::kNoUncertainty:
      return v1::DIFFERENCE_VERDICT_NO_UNCERTAINTY;
  }
  return v1::DIFFERENCE_VERDICT_UNSPECIFIED;
}

void SetDifference(const compare::Difference& one, v1::CalibrationDifference* message) {
  message->set_name(one.name);
  message->set_unit(one.unit);
  if (std::isfinite(one.first)) message->set_other(one.first);
  if (std::isfinite(one.second)) message->set_value(one.second);
  if (std::isfinite(one.difference)) message->set_difference(one.difference);
  if (std::isfinite(one.sigma)) message->set_sigma(one.sigma);
  if (std::isfinite(one.probability)) message->set_probability(one.probability);
  message->set_verdict(ToProto(one.verdict));
  message->set_reason(one.reason);
  if (std::isfinite(one.rms_mm)) message->set_tool_point_rms_um(one.rms_mm * base::kUmPerMm);
}

void SetChange(const machine::Machine& machine, const compare::Size& size, v1::ToolPointChange* message) {
  message->set_rms_um(size.rms_mm * base::kUmPerMm);
  message->set_max_um(size.max_mm * base::kUmPerMm);
  for (size_t i = 0; i < size.where.positions.size(); ++i)
    message->add_largest_at_mm_or_deg(size.where.positions[i] / UnitOf(machine.axes[i]));
  for (const double mm : size.where.difference_mm) message->add_largest_um(mm * base::kUmPerMm);
  for (const std::string& name : size.where.by) message->add_by(name);
  if (std::isfinite(size.chance_rms_mm)) message->set_chance_rms_um(size.chance_rms_mm * base::kUmPerMm);
  if (std::isfinite(size.chance_max_mm)) message->set_chance_max_um(size.chance_max_mm * base::kUmPerMm);
}

}  // namespace

absl::StatusOr<v1::CompareCalibrationsResponse> CompareCalibrations(Core& core, const Call& call,
                                                                    const v1::CompareCalibrationsRequest& request) {
  storage::Database& database = core.database;
  ASSIGN_OR_RETURN(const CalibrationRecord second, database.GetCalibration(CalibrationId(request.calibration_id())));
  ASSIGN_OR_RETURN(const CalibrationRecord first,
                   request.has_with_calibration_id()
                       ? database.GetCalibration(CalibrationId(request.with_calibration_id()))
                       : database.GetApprovedCalibration(second.content.machine));
  if (first.content.machine != second.content.machine) {
    return convert::FieldError("with_calibration_id",
                               absl::StrCat(first.id.number(), " is of machine ", first.content.machine.text(),
                                            ", must be of machine ", second.content.machine.text()));
  }
  ASSIGN_OR_RETURN(inputs::Compared compared, inputs::SidesOf(database, first, second, call.is_cancelled));
  std::optional<predict::Workspace>& workspace = compared.workspace;
  if (workspace) {
    ASSIGN_OR_RETURN(workspace->box, BoxOf(compared.machine, workspace->box, request.box()));
  } else if (request.box_size() > 0) {
    return convert::FieldError("box", "no readings with positions are left that tell the tool point");
  }
  ASSIGN_OR_RETURN(const compare::Comparison made,
                   compare::Compare(compared.machine, compared.first, compared.second, workspace));
  v1::CompareCalibrationsResponse response;
  response.set_calibration_id(second.id.number());
  response.set_with_calibration_id(first.id.number());
  for (const compare::Difference& one : made.errors) SetDifference(one, response.add_errors());
  for (const compare::Difference& one : made.combinations) SetDifference(one, response.add_combinations());
  for (const std::string& direction : made.not_comparable) response.add_not_comparable(direction);
  if (made.joint.degrees_of_freedom > 0) response.set_probability(made.joint.probability);
  for (const std::string& note : made.notes) response.add_notes(note);
  if (!made.tool_point) return response;
  SetSpans(compared.machine, workspace->box, response.mutable_box());
  response.set_poses(made.tool_point->poses);
  SetChange(compared.machine, made.tool_point->as_programmed, response.mutable_as_programmed());
  SetChange(compared.machine, made.tool_point->set_anew, response.mutable_set_anew());
  for (const std::string& direction : made.tool_point->unknown) response.add_unknown(direction);
  return response;
}

}  // namespace axiscal::handlers
