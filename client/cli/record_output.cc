#include "client/cli/record_output.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_join.h"
#include "client/cli/loop_text.h"
#include "core/reports/calibration.h"
#include "core/reports/stated_shares.h"

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

Json ToJson(const records::MachineRecord& record) {
  Json json = {{"id", record.id.text()},
               {"revision", record.revision},
               {"created", TimeJson(record.created_at)},
               {"updated", TimeJson(record.updated_at)}};
  if (!record.description_json.empty()) json["description"] = Json::Document(record.description_json);
  return json;
}

Json ToJson(const records::SessionRecord& record) {
  Json labels = Json::Array();
  if (record.remark)
    for (const std::string& label : record.remark->labels) labels.push_back(label);
  return {{"id", record.id.number()},
          {"machine", record.machine.text()},
          {"session", record.name},
          {"instrument", record.instrument},
          {"state", StateName(record.state)},
          {"readings", record.reading_count},
          {"measured", TimeJson(record.measured_at)},
          {"created", TimeJson(record.created_at)},
          {"created_by", record.created_by},
          {"hash", record.hash},
          {"note", record.remark ? record.remark->note : ""},
          {"labels", labels},
          {"rejected", record.is_rejected()},
          {"reason", record.remark ? record.remark->reason : ""}};
}

Json ToJson(const records::JobRecord& record) {
  Json programs = Json::Array();
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
  Json sessions = Json::Array(), rejected = Json::Array(), estimates = Json::Array(), decisions = Json::Array();
  for (const SessionId& id : content.sessions) sessions.push_back(id.number());
  for (const SessionId& id : record.rejected_sessions) rejected.push_back(id.number());
  for (const records::Estimate& estimate : content.estimates) estimates.push_back(ToJson(estimate));
  for (const records::Decision& decision : record.decisions)
    decisions.push_back({{"at", TimeJson(decision.at)},
                         {"by", decision.by},
                         {"state", StateName(decision.became)},
                         {"reason", decision.reason}});
  Json json = {{"id", record.id.number()},
               {"machine", content.machine.text()},
               {"version", record.version},
               {"state", StateName(record.state)},
               {"etag", record.etag},
               {"sessions", sessions},
               {"rejected_sessions", rejected},
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
  if (!record.decisions.empty()) json["decisions"] = decisions;
  if (!content.options_json.empty()) json["options"] = Json::Document(content.options_json);
  if (!content.model_json.empty()) json["model"] = Json::Document(content.model_json);
  if (!content.report_json.empty()) json["report"] = Json::Document(content.report_json);
  return json;
}

Json ToJson(const records::ProgramRecord& record) {
  return {{"id", record.id.number()},       {"kind", record.kind},     {"name", record.name},
          {"bytes", record.byte_count},     {"sha256", record.sha256}, {"created", TimeJson(record.created_at)},
          {"created_by", record.created_by}};
}

Json ToJson(const records::DriftSeries& series) {
  Json points = Json::Array();
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

const char* DriftKindName(records::DriftKind kind) {
  switch (kind) {
    case records::DriftKind::kStep:
      return "step";
    case records::DriftKind::kRetraction:
      return "retraction";
    case records::DriftKind::kSuspect:
      return "suspect";
    case records::DriftKind::kSlope:
      return "slope";
    case records::DriftKind::kSeason:
      return "season";
    case records::DriftKind::kNoise:
      return "noise";
    case records::DriftKind::kUnstable:
      return "unstable";
  }
  return "";
}

const char* MarkKindName(records::MarkKind kind) {
  switch (kind) {
    case records::MarkKind::kCollision:
      return "collision";
    case records::MarkKind::kService:
      return "service";
    case records::MarkKind::kRefixturing:
      return "re-fixturing";
  }
  return "unknown";
}

Json ToJson(const records::Mark& mark) {
  return {{"id", mark.id.number()},
          {"machine", mark.content.machine.text()},
          {"at", TimeJson(mark.content.at)},
          {"kind", MarkKindName(mark.content.kind)},
          {"symbols", mark.content.symbols},
          {"note", mark.content.note},
          {"created_by", mark.created_by},
          {"created", TimeJson(mark.created_at)},
          {"withdrawn_by", mark.withdrawn_by},
          {"withdrawn", TimeJson(mark.withdrawn_at)}};
}

std::string MarkText(const records::Mark& mark) {
  std::string text =
      absl::StrCat("mark ", mark.id.number(), " of ", mark.content.machine.text(), ": ",
                   MarkKindName(mark.content.kind), " at ", TimeText(mark.content.at), " of ",
                   mark.content.symbols.empty() ? "all errors" : absl::StrJoin(mark.content.symbols, ", "),
                   ", put in by ", mark.created_by);
  if (mark.withdrawn_at) absl::StrAppend(&text, ", withdrawn by ", mark.withdrawn_by);
  if (!mark.content.note.empty()) absl::StrAppend(&text, ": ", mark.content.note);
  return text + "\n";
}

Json ToJson(const records::Event& event) {
  const records::EventContent& content = event.content;
  Json amounts = Json::Array();
  for (const records::DriftAmount& amount : content.amounts) {
    amounts.push_back(
        {{"symbol", amount.symbol}, {"size", amount.size}, {"sigma", amount.sigma}, {"unit", UnitName(amount.unit)}});
  }
  return {{"id", event.id.number()},
          {"machine", event.machine.text()},
          {"kind", records::WordOf(content.kind)},
          {"subject", content.subject},
          {"text", content.text},
          {"advice", content.advice},
          {"amounts", amounts},
          {"certainty", NumberJson(content.certainty)},
          {"calibration", content.calibration ? Json(content.calibration->number()) : Json()},
          {"from", TimeJson(content.from)},
          {"to", TimeJson(content.to)},
          {"raised", TimeJson(event.raised_at)},
          {"cleared", TimeJson(event.cleared_at)},
          {"cleared_why", event.cleared_why},
          {"acknowledged", TimeJson(event.acknowledged_at)},
          {"acknowledged_by", event.acknowledged_by},
          {"acknowledged_note", event.acknowledged_note},
          {"shelved_until", TimeJson(event.shelved_until)},
          {"shelved_by", event.shelved_by},
          {"shelved_note", event.shelved_note}};
}

std::string EventText(const records::Event& event) {
  std::string text = absl::StrCat("event ", event.id.number(), " of ", event.machine.text(), ", ",
                                  records::WordOf(event.content.kind), ", raised ", TimeText(event.raised_at),
                                  " UTC: ", event.content.text, "\n  do: ", event.content.advice, "\n");
  if (event.acknowledged_at) {
    absl::StrAppend(&text, "  acknowledged ", TimeText(event.acknowledged_at), " by ", event.acknowledged_by, ": ",
                    event.acknowledged_note, "\n");
  }
  if (event.shelved_until) {
    absl::StrAppend(&text, "  shelved until ", TimeText(event.shelved_until), " by ", event.shelved_by,
                    event.shelved_note.empty() ? "" : ": ", event.shelved_note, "\n");
  }
  if (event.cleared_at) absl::StrAppend(&text, "  cleared ", TimeText(event.cleared_at), ": ", event.cleared_why, "\n");
  return text;
}

Json ToJson(const records::EventChange& change) {
  return {{"change", change.id}, {"what", records::WordOf(change.what)}, {"at", TimeJson(change.at)}, {"by", change.by},
          {"note", change.note}, {"event", ToJson(change.event)}};
}

std::string ChangeText(const records::EventChange& change) {
  std::string text = absl::StrCat(change.id, " ", TimeText(change.at), " ", change.event.machine.text(), " ",
                                  records::WordOf(change.what), " event ", change.event.id.number(), " (",
                                  records::WordOf(change.event.content.kind), ")");
  if (!change.by.empty()) absl::StrAppend(&text, " by ", change.by);
  return absl::StrCat(text, ": ", change.note.empty() ? change.event.content.text : change.note, "\n");
}

Json ToJson(const records::FleetRow& row) {
  Json estimates = Json::Array();
  for (const records::LatestEstimate& latest : row.latest) {
    Json json = ToJson(latest.estimate);
    json["measured"] = TimeJson(latest.measured_at);
    json["calibration"] = latest.calibration.number();
    json["state"] = StateName(latest.state);
    estimates.push_back(std::move(json));
  }
  return {{"machine", row.machine.text()}, {"estimates", estimates}};
}

namespace {

// Errors that were held, as rows of the errors' table, and whether their uncertainty is in what is stated.
std::string HeldRows(const reports::Held& held, std::vector<std::vector<std::string>>* rows) {
  std::string unknown, known;
  for (const reports::HeldError& error : held.errors) {
    rows->push_back({error.name, NumberText(error.value), NumberText(error.sigma), error.unit, "held"});
    std::string& list = std::isfinite(error.sigma) ? known : unknown;
    absl::StrAppend(&list, list.empty() ? "" : ", ", error.name);
  }
  std::string text;
  if (!known.empty()) absl::StrAppend(&text, "the uncertainty of the held ", known, " is part of every sigma\n");
  if (!unknown.empty()) {
    absl::StrAppend(&text, "the uncertainty of the held ", unknown,
                    " is not known: every sigma holds for exactly these values\n");
  }
  return text;
}

std::string OutlierText(const reports::Outlier& outlier) {
  if (outlier.gate) {
    return absl::StrFormat("rejected touch: session %s, row %d is %s um off its %s, gate %s um\n", outlier.session,
                           outlier.row, NumberText(outlier.gate->off_um),
                           outlier.gate->gate == "sphere" ? "fellows' sphere" : "repeats",
                           NumberText(outlier.gate->limit_um));
  }
  return absl::StrFormat("set aside as a bad reading: session %s, row %d (%s um off)\n", outlier.session, outlier.row,
                         NumberText(outlier.residual_um));
}

// What must be settled before the numbers are read.
std::string FirstText(const reports::Fitted& fitted) {
  std::string text;
  for (const reports::Warning& warning : fitted.warnings) {
    if (reports::ComesFirst(warning.kind)) absl::StrAppend(&text, "warning: ", warning.text, "\n");
  }
  return text;
}

// Constants of work offsets that were set anew, each set-up once.
std::string DatumText(const reports::Fitted& fitted) {
  std::string text, last;
  for (const reports::SessionFit& session : fitted.sessions) {
    const std::string& name = session.in.setup.empty() ? session.in.session : session.in.setup;
    std::string constants;
    for (const auto& [offset, value] : session.setup) {
      if (offset.rfind("datum_", 0) != 0) continue;
      absl::StrAppend(&constants, constants.empty() ? "" : ", ", offset.substr(6), " ",
                      std::isfinite(value.value)
                          ? absl::StrCat(NumberText(value.value), " +- ", NumberText(value.sigma), " ", value.unit)
                          : std::string("not determined"));
    }
    if (constants.empty() || name == last) continue;
    last = name;
    absl::StrAppend(&text, "datum of set-up ", name, " against the commanded positions (no error): ", constants, "\n");
  }
  return text;
}

std::string StatedText(const reports::Fitted& fitted) {
  std::string text;
  for (const reports::StatedShares& fact : reports::StatedSharesOf(fitted)) {
    std::string shares;
    for (const reports::StatedShares::Share& share : fact.shares) {
      absl::StrAppend(&shares, shares.empty() ? "" : ", ", NumberText(share.by), " ", share.unit, " of ", share.error);
    }
    absl::StrAppend(&text, "in the sigmas by the ", fact.of, ": ", shares, "\n");
  }
  return text;
}

// What a report says beyond the single errors: lines for people.
std::string ReportText(const reports::Fitted& fitted) {
  std::string text;
  for (const std::string& direction : fitted.not_separable) {
    const bool is_single = direction.find(' ') == std::string::npos;
    absl::StrAppend(&text, is_single ? "the sessions do not show: " : "the sessions cannot tell apart: ", direction,
                    "\n");
  }
  for (const reports::Warning& warning : fitted.warnings) {
    if (reports::ComesFirst(warning.kind)) continue;
    if (warning.kind != reports::WarningKind::kScatter)  // PoorFitText says it, also where there is no report
      absl::StrAppend(&text, "warning: ", warning.text, "\n");
  }
  for (const reports::Combination& combination : fitted.determined) {
    absl::StrAppend(&text, "they determine: ", combination.name, " = ", NumberText(combination.value), " +- ",
                    NumberText(combination.sigma), " ", combination.unit, "\n");
  }
  text += StatedText(fitted);
  text += DatumText(fitted);
  for (const reports::Outlier& outlier : fitted.outliers) text += OutlierText(outlier);
  return text;
}

// A report that another version wrote, or a damaged one: what it warns of is missing here.
std::string UnreadText(const records::CalibrationRecord& record, const absl::Status& status) {
  if (status.ok() || record.content.report_json.empty()) return "";
  return absl::StrCat("warning: what its report says is not shown (", status.message(), ")\n");
}

std::string PoorFitText(const records::CalibrationRecord& record, bool is_of_loop) {
  const std::optional<double>& chi2_per_dof = record.content.chi2_per_dof;
  if (!chi2_per_dof || *chi2_per_dof <= reports::kPoorFitChi2PerDof) return "";
  return absl::StrCat("warning: ", reports::PoorFitText(*chi2_per_dof, is_of_loop), "\n");
}

}  // namespace

std::string MonteCarloText(const reports::Fitted& fitted, bool with_held) {
  if (!fitted.monte_carlo) return "";
  const reports::MonteCarlo& simulation = *fitted.monte_carlo;
  std::string text = absl::StrFormat("Monte Carlo, %d runs, seed %d:\n", simulation.runs, simulation.seed);
  const char* const linear = with_held ? "linear" : "noise alone";
  std::vector<std::vector<std::string>> rows = {{"error", "value", "sigma", "95 % from", "to", "bias", linear, "unit"}};
  for (const reports::SimulatedError& error : simulation.errors) {
    rows.push_back({error.name, NumberText(error.value), NumberText(error.sigma), NumberText(error.low),
                    NumberText(error.high), NumberText(error.mean - error.value), NumberText(error.linear_sigma),
                    error.unit});
  }
  absl::StrAppend(&text, Table(rows));
  if (simulation.failed > 0) {
    absl::StrAppend(&text, "warning: ", simulation.failed, " of these fits did not converge and are left out\n");
  }
  return text;
}

std::string RejectedText(const records::CalibrationRecord& record) {
  return absl::StrJoin(record.rejected_sessions, ", ",
                       [](std::string* text, SessionId id) { absl::StrAppend(text, id.number()); });
}

std::string CalibrationText(const records::CalibrationRecord& record) {
  const records::NewCalibration& content = record.content;
  std::string text = absl::StrCat("calibration ", record.id.number(), ": machine ", content.machine.text(),
                                  ", version ", record.version, ", ", StateName(record.state), "\n");
  if (!record.rejected_sessions.empty())
    absl::StrAppend(&text, "it counts in no history: rejected was session ", RejectedText(record), "\n");
  for (const records::Decision& decision : record.decisions)
    absl::StrAppend(&text, StateName(decision.became), " ", TimeText(decision.at), " by ", decision.by,
                    decision.reason.empty() ? "" : ": ", decision.reason, "\n");
  std::vector<std::vector<std::string>> rows = {{"error", "value", "sigma", "unit", ""}};
  for (const records::Estimate& estimate : content.estimates) {
    rows.push_back({estimate.symbol, NumberText(estimate.value), NumberText(estimate.sigma), UnitName(estimate.unit),
                    estimate.identifiable ? "" : "not identifiable from these sessions"});
  }
  const absl::StatusOr<reports::CalibrationReport> report = reports::ReadCalibrationReport(content.report_json);
  const auto* const identification = report.ok() ? std::get_if<reports::Identification>(&*report) : nullptr;
  const auto* const loop = report.ok() ? std::get_if<reports::Loop>(&*report) : nullptr;
  const bool with_held = identification != nullptr && identification->held.has_value();
  const std::string held = with_held ? HeldRows(*identification->held, &rows) : "";
  if (report.ok() && loop == nullptr) text += FirstText(reports::FittedOf(*report));  // LoopText says it
  absl::StrAppend(&text, Table(rows), held);
  // Student's t: with few readings an interval is wider than the 1.96 sigma that everybody has in mind.
  if (report.ok() && reports::FittedOf(*report).coverage_factor > 2.0)
    absl::StrAppend(&text, "sigma was estimated from few readings: 95 % intervals are value +- ",
                    NumberText(reports::FittedOf(*report).coverage_factor), " sigma\n");
  if (loop != nullptr) {
    absl::StrAppend(&text, ReportText(loop->fitted), LoopText(*loop), MonteCarloText(loop->fitted, false));
    return text + PoorFitText(record, true);
  }
  if (identification != nullptr) {
    absl::StrAppend(&text, ReportText(identification->fitted), "rms: nominal machine ",
                    NumberText(identification->nominal.rms_um), " um, ");
  } else {
    absl::StrAppend(&text, "rms: ");
  }
  absl::StrAppend(&text, "with the set-ups fitted", held.empty() ? " " : " and the held errors ",
                  NumberText(content.rms_before_um), " um, with these errors too ", NumberText(content.rms_after_um),
                  " um\n");
  if (content.chi2_per_dof)
    absl::StrAppend(&text, "chi-square per degree of freedom: ", NumberText(*content.chi2_per_dof),
                    " (1: what is left scatters as the sessions state)\n");
  if (identification != nullptr && content.estimates.empty())
    text +=
        "no error was fitted: machine.json declares none; name them with --declare or --model, or let axiscal "
        "close-loop look\n";
  if (identification != nullptr) absl::StrAppend(&text, MonteCarloText(identification->fitted, with_held));
  return text + UnreadText(record, report.status()) + PoorFitText(record, false);
}

std::string CautionText(const records::CalibrationRecord& record) {
  const absl::StatusOr<reports::CalibrationReport> report = reports::ReadCalibrationReport(record.content.report_json);
  const auto* const loop = report.ok() ? std::get_if<reports::Loop>(&*report) : nullptr;
  return (loop != nullptr ? UnexplainedText(*loop) : UnreadText(record, report.status())) +
         PoorFitText(record, loop != nullptr);
}

std::string GrantText(const records::Grant& grant) {
  return records::NameOf(grant.role) + " of " + records::TextOf(grant.scope);
}

Json GrantsJson(const std::vector<records::Grant>& grants) {
  Json rows = Json::Array();
  for (const records::Grant& grant : grants) rows.push_back(GrantText(grant));
  return rows;
}

Json ToJson(const records::TokenRecord& token) {
  return {{"id", token.id},
          {"principal", token.principal},
          {"note", token.note},
          {"created_by", token.created_by},
          {"created_utc", TimeJson(token.created_at)},
          {"expires_utc", TimeJson(token.expires_at)},
          {"last_used_utc", TimeJson(token.last_used_at)},
          {"revoked_utc", TimeJson(token.revoked_at)}};
}

Json ToJson(const records::PrincipalRecord& principal) {
  Json tokens = Json::Array();
  for (const records::TokenRecord& token : principal.tokens) tokens.push_back(ToJson(token));
  return {{"name", principal.name},
          {"note", principal.note},
          {"created_by", principal.created_by},
          {"created_utc", TimeJson(principal.created_at)},
          {"revoked_utc", TimeJson(principal.revoked_at)},
          {"roles", GrantsJson(principal.grants)},
          {"tokens", tokens}};
}

Json ToJson(const records::MachineAccess& access) {
  return {{"machine", access.machine.text()}, {"groups", access.groups}, {"four_eyes", access.four_eyes}};
}

Json ToJson(const client::AuditEntry& entry) {
  return {
      {"entry", entry.number},  {"at_utc", TimeJson(entry.at)}, {"principal", entry.principal}, {"peer", entry.peer},
      {"action", entry.action}, {"resource", entry.resource},   {"outcome", entry.outcome},     {"was", entry.was},
      {"became", entry.became}, {"detail", entry.detail}};
}

}  // namespace axiscal::cli
