#include "client/cli/record_output.h"

#include <cmath>

#include "client/cli/loop_text.h"

namespace axiscal::cli {

using records::CalibrationState;
using records::JobState;
using records::SessionState;

const char* StateName(SessionState state) {
  switch (state) {
    case SessionState::kOpen:
      return "open";
    case SessionState::kComplete:
      return "complete";
    case SessionState::kAborted:
      return "aborted";
    case SessionState::kExpired:
      return "expired";
  }
  return "unknown";
}

const char* StateName(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return "queued";
    case JobState::kRunning:
      return "running";
    case JobState::kSucceeded:
      return "succeeded";
    case JobState::kFailed:
      return "failed";
    case JobState::kCancelled:
      return "cancelled";
    case JobState::kDead:
      return "dead";
  }
  return "unknown";
}

const char* StateName(CalibrationState state) {
  switch (state) {
    case CalibrationState::kCandidate:
      return "candidate";
    case CalibrationState::kApproved:
      return "approved";
    case CalibrationState::kRetired:
      return "retired";
  }
  return "unknown";
}

const char* UnitName(records::EstimateUnit unit) { return unit == records::EstimateUnit::kUm ? "um" : "urad"; }

Json Embedded(const std::string& json_text) {
  Json parsed = Json::parse(json_text, nullptr, false);
  return parsed.is_discarded() ? Json(json_text) : parsed;
}

Json ToJson(const records::MachineRecord& record) {
  Json json = {{"id", record.id.text()},
               {"revision", record.revision},
               {"created", TimeJson(record.created_at)},
               {"updated", TimeJson(record.updated_at)}};
  if (!record.description_json.empty()) json["description"] = Embedded(record.description_json);
  return json;
}

Json ToJson(const records::SessionRecord& record) {
  return {{"id", record.id.number()},
          {"machine", record.machine.text()},
          {"session", record.name},
          {"instrument", record.instrument},
          {"state", StateName(record.state)},
          {"readings", record.reading_count},
          {"measured", TimeJson(record.measured_at)},
          {"created", TimeJson(record.created_at)},
          {"created_by", record.created_by},
          {"hash", record.hash}};
}

Json ToJson(const records::JobRecord& record) {
  Json programs = Json::array();
  for (const ProgramId& id : record.programs) programs.push_back(id.number());
  Json json = {{"id", record.id.number()},
               {"kind", record.kind},
               {"machine", record.machine ? Json(record.machine->text()) : Json(nullptr)},
               {"state", StateName(record.state)},
               {"attempt", record.attempt},
               {"progress", record.progress.fraction},
               {"stage", record.progress.stage},
               {"detail", record.progress.detail},
               {"calibration", record.calibration ? Json(record.calibration->number()) : Json(nullptr)},
               {"programs", programs},
               {"created", TimeJson(record.created_at)},
               {"started", TimeJson(record.started_at)},
               {"ended", TimeJson(record.ended_at)},
               {"created_by", record.created_by}};
  if (record.error) {
    json["error"] = {{"code", absl::StatusCodeToString(record.error->code)},
                     {"reason", record.error->reason},
                     {"message", record.error->message}};
  }
  return json;
}

Json ToJson(const records::Estimate& estimate) {
  return {{"symbol", estimate.symbol},
          {"identifiable", estimate.identifiable},
          {"value", NumberJson(estimate.value)},
          {"sigma", NumberJson(estimate.sigma)},
          {"unit", UnitName(estimate.unit)}};
}

Json ToJson(const records::CalibrationRecord& record) {
  const records::NewCalibration& content = record.content;
  Json sessions = Json::array(), estimates = Json::array();
  for (const SessionId& id : content.sessions) sessions.push_back(id.number());
  for (const records::Estimate& estimate : content.estimates) estimates.push_back(ToJson(estimate));
  Json json = {{"id", record.id.number()},
               {"machine", content.machine.text()},
               {"version", record.version},
               {"state", StateName(record.state)},
               {"etag", record.etag},
               {"sessions", sessions},
               {"rank", content.rank},
               {"condition", NumberJson(content.condition)},
               {"chi2_per_dof", NumberJson(content.chi2_per_dof)},
               {"rms_before_um", NumberJson(content.rms_before_um)},
               {"rms_after_um", NumberJson(content.rms_after_um)},
               {"estimates", estimates},
               {"measured", TimeJson(content.measured_at)},
               {"created", TimeJson(record.created_at)},
               {"created_by", content.created_by},
               {"approved", TimeJson(record.approved_at)},
               {"approved_by", record.approved_by},
               {"machine_revision", content.machine_revision},
               {"engine_version", content.engine_version}};
  if (record.job) json["job"] = record.job->number();
  if (!content.options_json.empty()) json["options"] = Embedded(content.options_json);
  if (!content.model_json.empty()) json["model"] = Embedded(content.model_json);
  if (!content.report_json.empty()) json["report"] = Embedded(content.report_json);
  return json;
}

Json ToJson(const records::ProgramRecord& record) {
  return {{"id", record.id.number()},       {"kind", record.kind},     {"name", record.name},
          {"bytes", record.byte_count},     {"sha256", record.sha256}, {"created", TimeJson(record.created_at)},
          {"created_by", record.created_by}};
}

Json ToJson(const records::DriftSeries& series) {
  Json points = Json::array();
  for (const records::DriftPoint& point : series.points) {
    points.push_back({{"from", TimeJson(point.first_at)},
                      {"to", TimeJson(point.last_at)},
                      {"count", point.count},
                      {"min", point.min},
                      {"mean", point.mean},
                      {"max", point.max},
                      {"sigma", NumberJson(point.sigma)},
                      {"calibration", point.last_calibration.number()}});
  }
  return {{"symbol", series.symbol},
          {"unit", UnitName(series.unit)},
          {"not_identifiable", series.not_identifiable_count},
          {"points", points}};
}

Json ToJson(const records::FleetRow& row) {
  Json estimates = Json::array();
  for (const records::LatestEstimate& latest : row.latest) {
    Json json = ToJson(latest.estimate);
    json["measured"] = TimeJson(latest.measured_at);
    json["calibration"] = latest.calibration.number();
    estimates.push_back(std::move(json));
  }
  return {{"machine", row.machine.text()}, {"estimates", estimates}};
}

namespace {

// Errors that were held, as rows of the errors' table, and whether their uncertainty is in what is stated.
std::string HeldRows(const Json& report, std::vector<std::vector<std::string>>* rows) {
  const Json held = report.is_object() ? report.value("held", Json::object()) : Json::object();
  std::string unknown, known;
  for (const Json& error : held.value("errors", Json::array())) {
    const std::string name = error.value("name", error.value("symbol", ""));
    const Json sigma = error.value("sigma", Json());
    rows->push_back({name, NumberText(error.value("value", NAN)), sigma.is_number() ? NumberText(sigma) : "-",
                     error.value("unit", ""), "held"});
    std::string& list = sigma.is_number() ? known : unknown;
    absl::StrAppend(&list, list.empty() ? "" : ", ", name);
  }
  std::string text;
  if (!known.empty()) absl::StrAppend(&text, "the uncertainty of the held ", known, " is part of every sigma\n");
  if (!unknown.empty()) {
    absl::StrAppend(&text, "the uncertainty of the held ", unknown,
                    " is not known: every sigma holds for exactly these values\n");
  }
  return text;
}

// What a report of identify::ToJson says beyond the single errors: lines for people.
std::string ReportText(const Json& report) {
  std::string text;
  for (const Json& name : report.value("not_separable", Json::array())) {
    const std::string direction = name.get<std::string>();
    const bool is_single = direction.find(' ') == std::string::npos;
    absl::StrAppend(&text, is_single ? "the sessions do not show: " : "the sessions cannot tell apart: ", direction,
                    "\n");
  }
  for (const Json& warning : report.value("warnings", Json::array())) {
    if (warning.value("kind", "") != "scatter")  // PoorFitText says it, also where there is no report
      absl::StrAppend(&text, "warning: ", warning.value("text", ""), "\n");
  }
  for (const Json& combination : report.value("determined", Json::array())) {
    absl::StrAppend(&text, "they determine: ", combination.value("name", ""), " = ",
                    NumberText(combination.value("value", NAN)), " +- ", NumberText(combination.value("sigma", NAN)),
                    " ", combination.value("unit", ""), "\n");
  }
  for (const Json& outlier : report.value("outliers", Json::array())) {
    if (outlier.contains("gate")) {
      absl::StrAppend(&text, absl::StrFormat("rejected touch: session %s, row %d is %s um off its %s, gate %s um\n",
                                             outlier.value("session", ""), outlier.value("row", 0),
                                             NumberText(outlier.value("off_um", NAN)),
                                             outlier.value("gate", "") == "sphere" ? "fellows' sphere" : "repeats",
                                             NumberText(outlier.value("limit_um", NAN))));
      continue;
    }
    absl::StrAppend(&text, absl::StrFormat("set aside as a bad reading: session %s, row %d (%s um off)\n",
                                           outlier.value("session", ""), outlier.value("row", 0),
                                           NumberText(outlier.value("residual_um", NAN))));
  }
  return text;
}

std::string PoorFitText(const records::CalibrationRecord& record) {
  constexpr double kPoorFit = 4.0;  // chi-square per degree of freedom: twice the stated sigma
  const std::optional<double>& chi2_per_dof = record.content.chi2_per_dof;
  if (!chi2_per_dof || *chi2_per_dof <= kPoorFit) return "";
  const Json report = Embedded(record.content.report_json);
  const bool is_of_loop = report.is_object() && report.contains("verdict");
  return absl::StrCat("warning: the readings scatter by ", NumberText(std::sqrt(*chi2_per_dof)),
                      " times their stated sigma about this model: it lacks something",
                      is_of_loop ? " that has no name yet" : " (axiscal close-loop looks for it)",
                      ", or a session is bad\n");
}

}  // namespace

std::string MonteCarloText(const Json& report) {
  const Json simulation = report.value("monte_carlo", Json());
  if (!simulation.is_object()) return "";
  std::string text = absl::StrFormat("Monte Carlo, %d runs, seed %d:\n", simulation.value("runs", 0),
                                     simulation.value("seed", uint64_t{0}));
  // Linear propagation: of the readings' noise, and of what is known of held errors.
  const char* const linear = report.contains("held") ? "linear" : "noise alone";
  std::vector<std::vector<std::string>> rows = {{"error", "value", "sigma", "95 % from", "to", "bias", linear, "unit"}};
  for (const Json& error : simulation.value("errors", Json::array())) {
    const double value = error.value("value", NAN);
    rows.push_back({error.value("name", ""), NumberText(value), NumberText(error.value("sigma", NAN)),
                    NumberText(error.value("low", NAN)), NumberText(error.value("high", NAN)),
                    NumberText(error.value("mean", NAN) - value), NumberText(error.value("linear_sigma", NAN)),
                    error.value("unit", "")});
  }
  absl::StrAppend(&text, Table(rows));
  if (const int failed = simulation.value("failed", 0); failed > 0) {
    absl::StrAppend(&text, "warning: ", failed, " of these fits did not converge and are left out\n");
  }
  return text;
}

std::string CalibrationText(const records::CalibrationRecord& record) {
  const records::NewCalibration& content = record.content;
  std::string text = absl::StrCat("calibration ", record.id.number(), ": machine ", content.machine.text(),
                                  ", version ", record.version, ", ", StateName(record.state), "\n");
  std::vector<std::vector<std::string>> rows = {{"error", "value", "sigma", "unit", ""}};
  for (const records::Estimate& estimate : content.estimates) {
    rows.push_back({estimate.symbol, NumberText(estimate.value), NumberText(estimate.sigma), UnitName(estimate.unit),
                    estimate.identifiable ? "" : "not identifiable from these sessions"});
  }
  const Json report = Embedded(content.report_json);
  const std::string held = HeldRows(report, &rows);
  absl::StrAppend(&text, Table(rows), held);
  // Student's t: with few readings an interval is wider than the 1.96 sigma that everybody has in mind.
  if (const double factor = report.is_object() ? report.value("coverage_factor", 0.0) : 0.0; factor > 2.0)
    absl::StrAppend(&text, "sigma was estimated from few readings: 95 % intervals are value +- ", NumberText(factor),
                    " sigma\n");
  const bool is_of_loop = report.is_object() && report.contains("verdict");
  if (is_of_loop) {
    absl::StrAppend(&text, ReportText(report), LoopText(report), MonteCarloText(report));
    return text + PoorFitText(record);
  }
  if (report.is_object()) {
    absl::StrAppend(&text, ReportText(report));
    const auto nominal = report.value(Json::json_pointer("/nominal/rms_um"), NAN);
    absl::StrAppend(&text, "rms: nominal machine ", NumberText(nominal), " um, ");
  } else {
    absl::StrAppend(&text, "rms: ");
  }
  absl::StrAppend(&text, "with the set-ups fitted", held.empty() ? " " : " and the held errors ",
                  NumberText(content.rms_before_um), " um, with these errors too ", NumberText(content.rms_after_um),
                  " um\n");
  return text + MonteCarloText(report) + PoorFitText(record);
}

std::string CautionText(const records::CalibrationRecord& record) {
  return UnexplainedText(Embedded(record.content.report_json)) + PoorFitText(record);
}

}  // namespace axiscal::cli
