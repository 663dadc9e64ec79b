#include "server/jobs/identify_job.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/session/check_machine.h"
#include "proto/convert/job_params.h"
#include "server/handlers/job_inputs.h"

namespace axiscal::jobs {
namespace {

using json = nlohmann::ordered_json;

// Share of the progress bar of the fit without machine errors, which comes first.
constexpr double kBeforeShare = 0.2;

struct Inputs {
  storage::MachineRecord record;
  machine::Machine machine;
  std::vector<session::Session> sessions;
  base::UtcTime measured_at;  // of the newest session
};

void Rename(const std::string& name, session::Session* session) {
  for (session::HeaderEntry& entry : session->header) {
    if (entry.key == "session") entry.value = name;
  }
}

absl::StatusOr<Inputs> Load(storage::Database& database, const convert::IdentifyParams& params, JobContext& context) {
  Inputs inputs;
  ASSIGN_OR_RETURN(inputs.record, database.GetMachine(params.machine));
  ASSIGN_OR_RETURN(inputs.machine, machine::MachineFromJson(inputs.record.description_json));
  inputs.measured_at = base::UtcTime::min();
  std::map<std::string, int> uses;
  std::vector<storage::SessionRecord> records;
  for (const SessionId& id : params.sessions) {
    ASSIGN_OR_RETURN(records.emplace_back(), database.GetSession(id));
    ++uses[records.back().name];
  }
  for (const storage::SessionRecord& record : records) {
    if (context.cancelled()) return absl::CancelledError("stopped");
    ASSIGN_OR_RETURN(session::Session session, database.ReadSession(record.id));
    const std::string name = absl::StrCat(record.name, "#", record.id.number());
    // The machine may have been described anew since the upload.
    RETURN_IF_ERROR(base::Within("session " + name, session::CheckAgainstMachine(session, inputs.machine)));
    // A machine is measured again under the same names: each measurement is a session, and a set-up, of its own.
    if (uses[record.name] > 1) Rename(name, &session);
    inputs.sessions.push_back(std::move(session));
    inputs.measured_at = std::max(inputs.measured_at, record.measured_at.value_or(record.created_at));
  }
  return inputs;
}

identify::Options EngineOptions(JobContext& context, double from, double to) {
  identify::Options options;
  options.cancelled = [&context] { return context.cancelled(); };
  options.progress = [&context, from, to](const identify::Progress& progress) {
    context.ReportProgress(progress.stage, from + (to - from) * progress.fraction, progress.detail);
  };
  return options;
}

// The store knows um and urad; what is per a reference says so in its name: "EXX:linear/m".
std::optional<storage::Estimate> ToRecord(const identify::Estimate& estimate) {
  storage::Estimate record;
  const bool is_angle = estimate.unit.rfind("urad", 0) == 0;
  if (!is_angle && estimate.unit.rfind("um", 0) != 0) return std::nullopt;  // a decay length, a time constant
  record.symbol = estimate.name + estimate.unit.substr(is_angle ? 4 : 2);
  record.unit = is_angle ? storage::EstimateUnit::kUrad : storage::EstimateUnit::kUm;
  record.identifiable = estimate.identifiable && std::isfinite(estimate.value);
  if (!record.identifiable) return record;
  record.value = estimate.value / estimate.factor;
  if (std::isfinite(estimate.sigma)) record.sigma = estimate.sigma / estimate.factor;
  return record;
}

// The engine's report with the residual before: setups fitted, no machine error.
std::string ReportJson(const identify::Result& before, const identify::Result& after) {
  json report = json::parse(identify::ToJson(after));
  report["before"] = {{"rms_um", before.fit.rms_mm * base::kUmPerMm},
                      {"max_um", before.fit.max_mm * base::kUmPerMm},
                      {"chi2_per_dof", before.fit.chi2_per_dof}};
  return report.dump(1) + "\n";
}

std::optional<double> IfFinite(double value) { return std::isfinite(value) ? std::optional(value) : std::nullopt; }

storage::NewCalibration MakeCalibration(const convert::IdentifyParams& params, const storage::JobRecord& job,
                                        const Inputs& inputs, const identify::Result& before,
                                        const identify::Result& after) {
  storage::NewCalibration calibration;
  calibration.machine = params.machine;
  calibration.machine_revision = inputs.record.revision;
  calibration.sessions = params.sessions;
  calibration.measured_at = inputs.measured_at;
  calibration.model_json = machine::WriteErrors(after.model, inputs.machine);
  calibration.options_json = json({{"declared", params.declared}}).dump();
  calibration.report_json = ReportJson(before, after);
  calibration.engine_version = AXISCAL_VERSION;
  calibration.rank = after.rank;
  calibration.condition = IfFinite(after.condition);
  calibration.chi2_per_dof = IfFinite(after.fit.chi2_per_dof);
  calibration.rms_before_um = IfFinite(before.fit.rms_mm * base::kUmPerMm);
  calibration.rms_after_um = IfFinite(after.fit.rms_mm * base::kUmPerMm);
  for (const identify::Estimate& estimate : after.estimates) {
    const std::optional<storage::Estimate> record = ToRecord(estimate);
    if (record) calibration.estimates.push_back(*record);
  }
  calibration.created_by = job.created_by;
  return calibration;
}

absl::StatusOr<storage::JobProduct> Run(storage::Database& database, const storage::JobRecord& job,
                                        JobContext& context) {
  ASSIGN_OR_RETURN(const convert::JobParams any_params, convert::ParseJobParams(job.params));
  const auto& params = std::get<convert::IdentifyParams>(any_params);
  context.ReportProgress("read sessions", 0.0, "");
  ASSIGN_OR_RETURN(const Inputs inputs, Load(database, params, context));

  identify::Options options = EngineOptions(context, 0.0, kBeforeShare);
  options.model = machine::ErrorModel{};
  ASSIGN_OR_RETURN(const identify::Result before, identify::Identify(inputs.machine, inputs.sessions, options));
  options = EngineOptions(context, kBeforeShare, 1.0);
  ASSIGN_OR_RETURN(options.model, handlers::DeclaredModel(inputs.machine, params.declared));
  ASSIGN_OR_RETURN(const identify::Result after, identify::Identify(inputs.machine, inputs.sessions, options));

  storage::JobProduct product;
  product.calibration = MakeCalibration(params, job, inputs, before, after);
  product.result = product.calibration->report_json;
  return product;
}

}  // namespace

JobFunction IdentifyJob(storage::Database& database) {
  return [&database](const storage::JobRecord& job, JobContext& context) { return Run(database, job, context); };
}

}  // namespace axiscal::jobs
