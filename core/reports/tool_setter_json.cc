#include "core/reports/tool_setter.h"

#include "core/reports/fitted_json.h"
#include "core/reports/report_json.h"

namespace axiscal::reports {

template <typename Io>
void Members(Io& io, base::Like<Io, BeamParameter> parameter) {
  io.Member("stated", parameter.stated);
  if (parameter.stated) return;
  io.Member("estimate", parameter.estimate);
  io.Member("sigma", parameter.sigma);
  io.Required("identifiable", parameter.identifiable);
}

template <typename Io>
void Members(Io& io, base::Like<Io, RodAnswer> rod) {
  io.Required("rod", rod.rod);
  io.Member("readouts", rod.readouts);
  io.Member("mean_mm", rod.mean_mm);
  io.Member("range_um", rod.range_um);
  io.Member("trigger_height_mm", rod.trigger_height_mm);
  io.Member("reference_mm", rod.reference_mm);
  io.Member("sigma_um", rod.sigma_um);
  io.Member("residual_um", rod.residual_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Unseen> unseen) {
  io.Member("Z_um", unseen.z_um);
  io.Member("yaw_urad", unseen.yaw_urad);
  io.Member("pitch_urad", unseen.pitch_urad);
}

template <typename Io>
void Members(Io& io, base::Like<Io, RodProposal> next) {
  io.Required("rod", next.rod);
  io.Member("theta_th_deg", next.theta_th_deg);
  io.Member("sigma_um", next.sigma_um);
  io.Member("yaw_sigma_deg", next.yaw_sigma_deg);
  io.Member("pitch_sigma_deg", next.pitch_sigma_deg);
}

template <typename Io>
void Members(Io& io, base::Like<Io, BeamReference> report) {
  io.Member("session", report.session);
  io.Required("reference_mm", report.reference_mm);
  io.Required("yaw_deg", report.yaw_deg);
  io.Required("pitch_deg", report.pitch_deg);
  io.Member("range_um", report.range_um);
  io.Member("between_rods_um", report.between_rods_um);
  io.Member("chi2", report.chi2);
  io.Member("degrees_of_freedom", report.degrees_of_freedom);
  io.Member("coverage_factor", report.coverage_factor);
  io.Member("warnings", report.warnings);
  io.Member("rods", report.rods);
  io.Member("not_told_apart", report.not_told_apart);
  io.Member("next_measurement", report.next_measurement);
}

template <typename Io>
void Members(Io& io, base::Like<Io, InsertWear> insert) {
  io.Required("insert", insert.insert);
  io.Member("identifiable", insert.identifiable);
  io.Member("wear_um", insert.wear_um);
  io.Member("sigma_um", insert.sigma_um);
  io.Member("at_least_um", insert.at_least_um);
  io.Member("readings", insert.readings);
  io.Member("fires_first_deg", insert.fires_first_deg);
  io.Member("unseen_from_um", insert.unseen_from_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, CurveReading> reading) {
  io.Member("start_deg", reading.start_deg);
  io.Member("length_mm", reading.length_mm);
  io.Member("residual_um", reading.residual_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, FeedProposal> next) {
  io.Member("feed_mm_min", next.feed_mm_min);
  io.Member("spindle_rpm", next.spindle_rpm);
  io.Member("sees_up_to_um", next.sees_up_to_um);
}

template <typename Io>
void Members(Io& io, base::Like<Io, Wear> report) {
  io.Member("session", report.session);
  io.Member("length_mm", report.length_mm);
  io.Member("length_sigma_um", report.length_sigma_um);
  io.Member("phase_deg", report.phase_deg);
  io.Member("phase_sigma_deg", report.phase_sigma_deg);
  io.Required("inserts", report.inserts);
  io.Group("fit", [&](auto& fit) {
    fit.Member("rms_um", report.rms_um);
    fit.Member("chi2", report.chi2);
    fit.Member("degrees_of_freedom", report.degrees_of_freedom);
    fit.Member("coverage_factor", report.coverage_factor);
  });
  io.Member("warnings", report.warnings);
  io.Member("longest_reading_mm", report.longest_reading_mm);
  io.Member("readings", report.readings);
  io.Member("next_measurement", report.next_measurement);
}

std::string ToJson(const BeamReference& report) { return base::WriteMembers(report); }

std::string ToJson(const Wear& report) { return base::WriteMembers(report); }

std::string ToJson(const ToolSetter& report) {
  return std::visit([](const auto& of_a_kind) { return ToJson(of_a_kind); }, report);
}

absl::StatusOr<ToolSetter> ReadToolSetter(const std::string& text) {
  ASSIGN_OR_RETURN(const nlohmann::ordered_json document, ParseReport(text));
  if (document.is_object() && document.contains("inserts")) return ReadReport<Wear>(document);
  return ReadReport<BeamReference>(document);
}

}  // namespace axiscal::reports
