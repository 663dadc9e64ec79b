#include "server/jobs/identify_job.h"

#include "core/identify/identify.h"
#include "core/identify/monte_carlo.h"
#include "core/identify/report.h"
#include "core/predict/box_poses.h"
#include "proto/convert/job_params.h"
#include "server/inputs/job_inputs.h"
#include "server/jobs/asked_json.h"
#include "server/jobs/job_sessions.h"
#include "server/jobs/new_calibration.h"

namespace axiscal::jobs {
namespace {

// Share of the progress bar of the fit without machine errors, which comes first.
constexpr double kBeforeShare = 0.2;

identify::Options IdentifyOptions(JobContext& context, double from, double to) {
  identify::Options options;
  options.cancelled = [&context] { return context.cancelled(); };
  options.progress = [&context, from, to](const identify::Progress& progress) {
    context.ReportProgress(progress.stage, from + (to - from) * progress.fraction, progress.detail);
  };
  return options;
}

// The simulation's share of it, where one was asked for: it comes last.
constexpr double kMonteCarloShare = 0.7;

// Nothing where no simulation was asked for.
absl::StatusOr<std::optional<identify::MonteCarloResult>> Simulate(const records::IdentifyParams& params,
                                                                   const std::optional<identify::Budget>& budget,
                                                                   const identify::Fit& fit, JobContext& context) {
  if (!params.monte_carlo_runs) return std::nullopt;
  identify::MonteCarloOptions options;
  options.runs = *params.monte_carlo_runs;
  options.seed = params.monte_carlo_seed;
  options.budget = budget.value_or(identify::Budget{});
  options.for_each = [&context](int count, const auto& body) { context.ForEach(count, body); };
  options.cancelled = [&context] { return context.cancelled(); };
  options.progress = [&context, &options](double fraction) {
    context.ReportProgress("simulating", 1.0 - kMonteCarloShare + kMonteCarloShare * fraction,
                           absl::StrCat(options.runs, " runs"));
  };
  ASSIGN_OR_RETURN(identify::MonteCarloResult result, identify::MonteCarlo(fit, options));
  return result;
}

absl::StatusOr<storage::JobProduct> RunIdentify(storage::Database& database, const records::JobRecord& job,
                                                JobContext& context) {
  ASSIGN_OR_RETURN(const records::JobParams any_params, convert::ParseJobParams(job.params));
  const auto& params = std::get<records::IdentifyParams>(any_params);
  context.ReportProgress("read sessions", 0.0, "");
  ASSIGN_OR_RETURN(const MachineInput input, LoadMachine(database, params.machine));
  ASSIGN_OR_RETURN(MeasuredSessions sessions, LoadSessions(database, params.sessions, input.machine, context));

  ASSIGN_OR_RETURN(const std::optional<identify::Budget> budget, inputs::BudgetOf(input.machine, params));
  ASSIGN_OR_RETURN(const inputs::IdentifyErrors errors, inputs::ErrorsOf(database, input.machine, params));

  const double fitted = params.monte_carlo_runs ? 1.0 - kMonteCarloShare : 1.0;
  identify::Options options = IdentifyOptions(context, 0.0, kBeforeShare * fitted);
  options.budget = budget;
  options.held_errors = errors.held;
  options.model = machine::ErrorModel{};
  ASSIGN_OR_RETURN(const identify::Fit before, identify::FitMeasured(input.machine, sessions.runs, options));
  options = IdentifyOptions(context, kBeforeShare * fitted, fitted);
  options.budget = budget;
  options.held_errors = errors.held;
  options.model = errors.fitted;
  ASSIGN_OR_RETURN(const identify::Fit fit, identify::FitMeasured(input.machine, std::move(sessions.runs), options));
  identify::Result after = fit.result;
  if (errors.held) {  // the calibration is of the whole machine
    const std::vector<machine::ErrorTerm>& held = errors.held->model.terms;
    after.model.terms.insert(after.model.terms.begin(), held.begin(), held.end());
  }
  ASSIGN_OR_RETURN(const auto monte_carlo, Simulate(params, budget, fit, context));

  storage::JobProduct product;
  reports::Identification report = identify::ReportOf(after);
  report.before = identify::BeforeOf(before.result);
  report.fitted.measured = predict::RangesOf(input.machine, predict::MeasuredBox(fit.problem.runs));
  report.fitted.budget_json = params.budget_json;
  if (monte_carlo) report.fitted.monte_carlo = identify::ReportOf(*monte_carlo);
  product.result = reports::ToJson(report);
  product.calibration = MakeCalibration(input, sessions, before.result.fit, after, job);
  product.calibration->report_json = product.result;
  product.calibration->options_json = AskedJson(params);
  return product;
}

}  // namespace

JobFunction IdentifyJob(storage::Database& database) {
  return
      [&database](const records::JobRecord& job, JobContext& context) { return RunIdentify(database, job, context); };
}

}  // namespace axiscal::jobs
