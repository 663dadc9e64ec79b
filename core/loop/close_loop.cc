#include "core/loop/close_loop.h"

#include <algorithm>
#include <cmath>

#include "core/identify/noise.h"
#include "core/loop/describe.h"
#include "core/loop/explorer.h"
#include "core/loop/moved_datum.h"
#include "core/loop/settle_classes.h"

namespace axiscal::loop {
namespace {

using identify::Fit;
using instruments::MeasuringRun;
using machine::Machine;

class Loop {
 public:
  Loop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check, const Options& options)
      : machine_(machine),
        whole_progress_(options.progress),
        options_(OwnOptions(options)),
        identify_options_(OptionsOf(options)),
        explorer_(machine, std::move(fit), std::move(check), options_, identify_options_) {}

  absl::StatusOr<Report> Run() {
    RETURN_IF_ERROR(CheckRepeated());
    RETURN_IF_ERROR(CheckClock());
    RETURN_IF_ERROR(CheckBudget());
    ASSIGN_OR_RETURN(Outcome outcome, explorer_.Explore());
    ASSIGN_OR_RETURN(Report report, Finish(&outcome));
    RETURN_IF_ERROR(Simulate(&report));
    return report;
  }

 private:
  // The loop's share of the progress, where a simulation comes after it.
  static constexpr double kLoopShare = 0.3;

  static Options OwnOptions(const Options& options) {
    Options own = options;
    if (!options.monte_carlo || !options.progress) return own;
    own.progress = [progress = options.progress](identify::Progress one) {
      one.fraction *= kLoopShare;
      progress(one);
    };
    return own;
  }

  // A copy of a session under any name: fitted twice it would count twice, and as a check it would prove nothing.
  absl::Status CheckRepeated() const {
    const std::vector<MeasuringRun>&fit = explorer_.fit_runs(), &check = explorer_.check_runs();
    const auto run = [&](size_t i) -> const MeasuringRun& { return i < fit.size() ? fit[i] : check[i - fit.size()]; };
    const auto name = [&](size_t i) {
      return absl::StrCat(i < fit.size() ? "fit" : "check", " session '", run(i).session, "'");
    };
    for (size_t i = 0; i < fit.size() + check.size(); ++i) {
      for (size_t k = 0; k < i; ++k) {
        if (run(i).kind != run(k).kind || run(i).time_s != run(k).time_s || run(i).positions != run(k).positions ||
            run(i).measured_mm != run(k).measured_mm)
          continue;
        return absl::InvalidArgumentError(
            absl::StrCat(name(i), " holds the same readings as ", name(k),
                         i < fit.size() ? ": they would count twice" : ": what was fitted or checked proves nothing"));
      }
    }
    return absl::OkStatus();
  }

  // Fit and check sessions: an effect that drifts is judged in both.
  absl::Status CheckClock() const {
    std::vector<MeasuringRun> first;  // what is compared, without readings
    for (const std::vector<MeasuringRun>* runs : {&explorer_.fit_runs(), &explorer_.check_runs()}) {
      for (const MeasuringRun& run : *runs) {
        MeasuringRun& one = first.emplace_back();
        one.session = run.session;
        one.has_time = run.has_time;
        one.path_readings = run.path_readings;
      }
    }
    return identify::CheckRecorded(machine_, first);
  }

  // Before any work: names of sessions that are not there.
  absl::Status CheckBudget() const {
    if (!options_.monte_carlo) return absl::OkStatus();
    std::vector<std::string> names;
    for (const MeasuringRun& run : explorer_.fit_runs()) names.push_back(run.session);
    return identify::CheckSessions(options_.monte_carlo->budget, names);
  }

  absl::Status Simulate(Report* report) const {
    if (!options_.monte_carlo) return absl::OkStatus();
    identify::MonteCarloOptions simulation = *options_.monte_carlo;
    simulation.cancelled = options_.cancelled;
    simulation.progress = [this, &simulation](double fraction) {
      if (!whole_progress_) return;
      whole_progress_(
          {"simulating", kLoopShare + (1.0 - kLoopShare) * fraction, absl::StrCat(simulation.runs, " runs")});
    };
    ASSIGN_OR_RETURN(report->monte_carlo, identify::MonteCarlo(*report->last_fit, simulation));
    report->budget_json = options_.budget_json;
    return absl::OkStatus();
  }

  static identify::Options OptionsOf(const Options& options) {
    identify::Options out;
    out.cancelled = options.cancelled;
    out.scale_uncertainties = true;
    out.profile_intervals = false;  // of fits on the way, which a model that misses bends
    return out;
  }

  // Fitted sessions that scatter by more than noise may (identify::kMostScatter), and by more than that by chance.
  static std::vector<Unexplained> ScatteringSessions(const Fit& fit) {
    constexpr double kBeyondChance = 6.0, kAtTheLimit = 1.0 - 1e-9;  // standard deviations
    std::vector<Unexplained> sessions;
    for (size_t i = 0; i < fit.problem.runs.size(); ++i) {
      const MeasuringRun& run = fit.problem.runs[i];
      if (fit.problem.noise[i].sigma_mm < kAtTheLimit * identify::kMostScatter * run.sigma_mm) continue;
      const std::vector<bool>& used = fit.problem.is_used[i];
      const auto count = static_cast<double>(std::count(used.begin(), used.end(), true));
      if (identify::WhitenedSquaresOf(fit.problem, i, fit.residuals_mm[i]) <=
          count + kBeyondChance * std::sqrt(2.0 * count))
        continue;
      double squares = 0.0;
      for (Eigen::Index k = 0; k < fit.residuals_mm[i].size(); ++k)
        if (used[static_cast<size_t>(k)]) squares += std::pow(fit.residuals_mm[i].data()[k], 2);
      sessions.push_back(
          {Unexplained::kScatter, "t", run.time_s.front(), run.time_s.back(), run.session, std::sqrt(squares / count)});
    }
    return sessions;
  }

  absl::StatusOr<Report> Finish(Outcome* outcome) const {
    Report& report = outcome->attempt.report;
    RETURN_IF_ERROR(SettleClasses(outcome->fit, options_.search, identify_options_, &outcome->attempt.extension));
    Describe(machine_, explorer_.RunsOf(*outcome), outcome->attempt.extension, outcome->fit, options_.search, &report);
    explorer_.KeepFitResiduals(outcome->fit, &SessionResiduals::after_mm, &report);
    ASSIGN_OR_RETURN(const std::vector<reports::WarningFacts> datum,
                     ProposeDatum(outcome->fit, outcome->attempt.extension, identify_options_));
    report.fitted.warnings.insert(report.fitted.warnings.end(), datum.begin(), datum.end());
    report.last_fit = std::make_shared<Fit>(outcome->fit);
    report.check_after = outcome->check_after;
    report.unexplained.insert(report.unexplained.end(), outcome->unexplained_sessions.begin(),
                              outcome->unexplained_sessions.end());
    const std::vector<Unexplained> scattering = ScatteringSessions(outcome->fit);
    report.unexplained.insert(report.unexplained.end(), scattering.begin(), scattering.end());
    if (!report.unexplained.empty()) report.verdict = Verdict::kUnexplained;
    return std::move(report);
  }

  const Machine& machine_;
  const std::function<void(const identify::Progress&)> whole_progress_;
  const Options options_;  // its progress is that of the loop alone
  const identify::Options identify_options_;
  Explorer explorer_;
};

}  // namespace

absl::StatusOr<Report> CloseLoop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check,
                                 const Options& options) {
  return Loop(machine, std::move(fit), std::move(check), options).Run();
}

}  // namespace axiscal::loop
