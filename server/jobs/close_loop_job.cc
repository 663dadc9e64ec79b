#include "server/jobs/close_loop_job.h"

#include <algorithm>
#include <atomic>
#include <memory>

#include "core/decide/close_loop.h"
#include "proto/convert/job_params.h"
#include "server/inputs/job_inputs.h"
#include "server/jobs/asked_json.h"
#include "server/jobs/job_sessions.h"
#include "server/jobs/new_calibration.h"

namespace axiscal::jobs {
namespace {

absl::StatusOr<decide::Options> CloseLoopOptions(const machine::Machine& machine,
                                                 const records::CloseLoopParams& params, JobContext& context) {
  decide::Options options;
  options.max_effects = params.max_effects;
  options.cancelled = [&context] { return context.cancelled(); };
  // A backward step takes an effect out again; the job's progress does not fall for it.
  // A simulation reports from every worker.
  options.progress = [&context,
                      furthest = std::make_shared<std::atomic<double>>(0.0)](const identify::Progress& progress) {
    double before = furthest->load();
    while (before < progress.fraction && !furthest->compare_exchange_weak(before, progress.fraction)) {
    }
    context.ReportProgress(progress.stage, std::max(before, progress.fraction), progress.detail);
  };
  if (!params.monte_carlo_runs) return options;
  ASSIGN_OR_RETURN(const std::optional<identify::Budget> budget, inputs::BudgetOf(machine, params));
  options.monte_carlo.emplace();
  options.monte_carlo->runs = *params.monte_carlo_runs;
  options.monte_carlo->seed = params.monte_carlo_seed;
  options.monte_carlo->budget = budget.value_or(identify::Budget{});
  options.monte_carlo->for_each = [&context](int count, const auto& body) { context.ForEach(count, body); };
  options.budget_json = params.budget_json;
  return options;
}

// All that the errors were fitted to.
MeasuredSessions Both(MeasuredSessions fit, const MeasuredSessions& check) {
  fit.records.insert(fit.records.end(), check.records.begin(), check.records.end());
  fit.measured_at = std::max(fit.measured_at, check.measured_at);
  return fit;
}

absl::StatusOr<storage::JobProduct> RunCloseLoop(storage::Database& database, const records::JobRecord& job,
                                                 JobContext& context) {
  ASSIGN_OR_RETURN(const records::JobParams any_params, convert::ParseJobParams(job.params));
  const auto& params = std::get<records::CloseLoopParams>(any_params);
  context.ReportProgress("read sessions", 0.0, "");
  ASSIGN_OR_RETURN(const MachineInput input, LoadMachine(database, params.machine));
  ASSIGN_OR_RETURN(MeasuredSessions fit, LoadSessions(database, params.fit, input.machine, context));
  ASSIGN_OR_RETURN(MeasuredSessions check, LoadSessions(database, params.check, input.machine, context));
  ASSIGN_OR_RETURN(const decide::Options options, CloseLoopOptions(input.machine, params, context));
  ASSIGN_OR_RETURN(const loop::Report report,
                   decide::CloseLoop(input.machine, std::move(fit.runs), std::move(check.runs), options));

  storage::JobProduct product;
  product.result = reports::ToJson(loop::ReportOf(input.machine, report));
  product.calibration =
      MakeCalibration(input, report.is_check_fitted ? Both(fit, check) : fit, report.fit_before, report.fitted, job);
  product.calibration->report_json = product.result;
  product.calibration->options_json = AskedJson(params, fit.records, check.records);
  return product;
}

}  // namespace

JobFunction CloseLoopJob(storage::Database& database) {
  return
      [&database](const records::JobRecord& job, JobContext& context) { return RunCloseLoop(database, job, context); };
}

}  // namespace axiscal::jobs
