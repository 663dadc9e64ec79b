#include "server/jobs/identify_job.h"

#include <nlohmann/json.hpp>

#include "core/base/units.h"
#include "core/identify/identify.h"
#include "proto/convert/job_params.h"
#include "server/handlers/job_inputs.h"
#include "server/jobs/job_sessions.h"
#include "server/jobs/new_calibration.h"

namespace axiscal::jobs {
namespace {

using json = nlohmann::ordered_json;

// Share of the progress bar of the fit without machine errors, which comes first.
constexpr double kBeforeShare = 0.2;

identify::Options EngineOptions(JobContext& context, double from, double to) {
  identify::Options options;
  options.cancelled = [&context] { return context.cancelled(); };
  options.progress = [&context, from, to](const identify::Progress& progress) {
    context.ReportProgress(progress.stage, from + (to - from) * progress.fraction, progress.detail);
  };
  return options;
}

// The engine's report with the residual before: setups fitted, no machine error.
std::string ReportJson(const identify::Result& before, const identify::Result& after) {
  json report = json::parse(identify::ToJson(after));
  report["before"] = {{"rms_um", before.fit.rms_mm * base::kUmPerMm},
                      {"max_um", before.fit.max_mm * base::kUmPerMm},
                      {"chi2_per_dof", before.fit.chi2_per_dof}};
  return report.dump(1) + "\n";
}

absl::StatusOr<storage::JobProduct> Run(storage::Database& database, const storage::JobRecord& job,
                                        JobContext& context) {
  ASSIGN_OR_RETURN(const convert::JobParams any_params, convert::ParseJobParams(job.params));
  const auto& params = std::get<convert::IdentifyParams>(any_params);
  context.ReportProgress("read sessions", 0.0, "");
  ASSIGN_OR_RETURN(const MachineInput inputs, LoadMachine(database, params.machine));
  ASSIGN_OR_RETURN(const StoredSessions sessions, LoadSessions(database, params.sessions, inputs.machine, context));

  identify::Options options = EngineOptions(context, 0.0, kBeforeShare);
  options.model = machine::ErrorModel{};
  ASSIGN_OR_RETURN(const identify::Result before, identify::Identify(inputs.machine, sessions.sessions, options));
  options = EngineOptions(context, kBeforeShare, 1.0);
  ASSIGN_OR_RETURN(options.model, handlers::DeclaredModel(inputs.machine, params.declared));
  ASSIGN_OR_RETURN(const identify::Result after, identify::Identify(inputs.machine, sessions.sessions, options));

  storage::JobProduct product;
  product.result = ReportJson(before, after);
  product.calibration = MakeCalibration(inputs, sessions, before.fit, after, job);
  product.calibration->report_json = product.result;
  product.calibration->options_json = json({{"declared", params.declared}}).dump();
  return product;
}

}  // namespace

JobFunction IdentifyJob(storage::Database& database) {
  return [&database](const storage::JobRecord& job, JobContext& context) { return Run(database, job, context); };
}

}  // namespace axiscal::jobs
