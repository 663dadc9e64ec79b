#include "core/loop/close_loop.h"

#include <algorithm>
#include <cmath>

#include "core/loop/describe.h"
#include "core/loop/fitting.h"
#include "core/loop/growth.h"
#include "core/loop/told_apart.h"
#include "core/loop/validation.h"

namespace axiscal::loop {
namespace {

using identify::Fit;
using instruments::MeasuringRun;
using machine::ErrorModel;
using machine::Machine;

class Loop {
 public:
  Loop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check, const Options& options)
      : machine_(machine),
        runs_(std::move(fit)),
        whole_progress_(options.progress),
        options_(OwnOptions(options)),
        identify_options_(OptionsOf(options)),
        check_(machine, std::move(check), identify_options_) {}

  absl::StatusOr<Report> Run() {
    RETURN_IF_ERROR(CheckBudget());
    ASSIGN_OR_RETURN(Report report, Close());
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

  // Before any work: names of sessions that are not there.
  absl::Status CheckBudget() const {
    if (!options_.monte_carlo) return absl::OkStatus();
    std::vector<std::string> names;
    for (const MeasuringRun& run : runs_) names.push_back(run.session);
    return identify::CheckSessions(options_.monte_carlo->budget, names);
  }

  // A session whose artefact slipped stands in the fit in parts, "CR#1" and so on: what acts in it acts in each.
  static void NameParts(const Fit& fit, identify::Budget* budget) {
    for (identify::Source& source : budget->sources) {
      std::vector<std::string> names;
      for (const MeasuringRun& run : fit.problem.runs) {
        const auto is_of = [&run](const std::string& session) {
          return run.session == session || run.session.rfind(session + "#", 0) == 0;
        };
        if (std::any_of(source.sessions.begin(), source.sessions.end(), is_of)) names.push_back(run.session);
      }
      source.sessions = names;
    }
  }

  absl::Status Simulate(Report* report) const {
    if (!options_.monte_carlo) return absl::OkStatus();
    identify::MonteCarloOptions simulation = *options_.monte_carlo;
    NameParts(*report->last_fit, &simulation.budget);
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

  // Where an attempt ended.
  struct Outcome {
    Attempt attempt;
    Fit fit;
    identify::FitStatistics check_after;
    std::vector<Unexplained> unexplained_sessions;  // of the check sessions
  };

  absl::StatusOr<Report> Close() {
    Way way;
    way.most_effects = options_.max_effects;
    ASSIGN_OR_RETURN(Outcome best, Try(way));
    ASSIGN_OR_RETURN(way.names_first, PreferNames(way, &best));
    RETURN_IF_ERROR(Detour(way, &best));
    // An effect that swallowed two others leads astray: where the check sessions stay unexplained, another beginning
    // is tried, and taken if it explains them better without explaining the fit sessions worse.
    // Where more is left than may be added, a beginning is not what is wrong.
    constexpr int kBeginnings = 3;
    std::optional<Added> first = best.attempt.first;
    bool is_explained = best.unexplained_sessions.empty();
    for (int round = 1;
         round < kBeginnings && !is_explained && !best.attempt.report.has_stopped_early && first.has_value(); ++round) {
      // What was alike leads to the same end.
      way.not_first.push_back(first->candidate);
      way.not_first.insert(way.not_first.end(), first->equivalent.begin(), first->equivalent.end());
      ASSIGN_OR_RETURN(Outcome other, Try(way));
      first = other.attempt.first;
      is_explained = other.unexplained_sessions.empty();
      constexpr double kBetter = 0.98, kNoWorse = 1.02;
      if (other.check_after.rms_mm < kBetter * best.check_after.rms_mm &&
          other.fit.result.fit.rms_mm < kNoWorse * best.fit.result.fit.rms_mm)
        best = std::move(other);
    }
    return Finish(&best);
  }

  // What two effects leave where one of them alone was expected looks like a local defect, which has place and width to
  // bend to it. Where one was found that names come close to, names alone are tried, one more of them than effects so
  // far, and kept if they explain as much. Returns whether they were.
  absl::StatusOr<bool> PreferNames(Way way, Outcome* best) {
    const std::vector<Added>& found = best->attempt.extension.effects;
    const auto is_local = [](const Added& one) { return one.candidate.family == Family::kBump; };
    if (!best->attempt.has_close_name || best->attempt.report.has_stopped_early) return false;
    if (std::none_of(found.begin(), found.end(), is_local)) return false;
    way.names_first = true;
    way.most_effects = std::min(way.most_effects, static_cast<int>(found.size()) + 1);
    ASSIGN_OR_RETURN(Outcome named, Try(way));
    if (!IsBetter(named, *best)) return false;
    *best = std::move(named);
    return true;
  }

  // One effect may have been added for two others which, found one after the other, would have explained more. Where
  // the noise does not account for what is left, each effect in turn is kept from coming where it came.
  absl::Status Detour(Way way, Outcome* best) {
    const std::vector<Added> found = best->attempt.extension.effects;
    for (size_t i = 0; i < found.size() && IsMisfit(best->fit) && !best->attempt.report.has_stopped_early; ++i) {
      if (IsUnnamed(found[i].candidate.family)) continue;
      way.prefix.assign(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(i));
      way.not_first = {found[i].candidate};
      way.not_first.insert(way.not_first.end(), found[i].equivalent.begin(), found[i].equivalent.end());
      ASSIGN_OR_RETURN(Outcome other, Try(way));
      if (!IsBetter(other, *best)) continue;
      Report& report = other.attempt.report;
      report.ranking = best->attempt.report.ranking;
      report.candidates = best->attempt.report.candidates;
      report.not_visible = best->attempt.report.not_visible;
      other.attempt.first = best->attempt.first;
      *best = std::move(other);
    }
    return absl::OkStatus();
  }

  // The scatter between neighbouring readings, of which the noise of dense series is judged, knows nothing of what is
  // left; that of a few readings takes it up, and one session seems to scatter more than others of its instrument.
  static bool IsMisfit(const Fit& fit) {
    constexpr double kBeyondChance = 2.0, kUnlike = 1.5;  // standard deviations; sigma
    constexpr double kHopeless = 4.0;  // what is twice the noise is no choice between names: the dictionary lacks it
    const identify::FitStatistics& all = fit.result.fit;
    if (all.chi2_per_dof > kHopeless) return false;
    if (all.chi2_per_dof > 1.0 + kBeyondChance * std::sqrt(2.0 / std::max(1, all.degrees_of_freedom))) return true;
    const identify::Problem& problem = fit.problem;
    const auto factor = [&](size_t i) { return problem.noise[i].sigma_mm / problem.runs[i].sigma_mm; };
    for (size_t i = 0; i < problem.runs.size(); ++i) {
      for (size_t k = 0; k < problem.runs.size(); ++k) {
        if (problem.runs[i].kind == problem.runs[k].kind && factor(i) > kUnlike * factor(k)) return true;
      }
    }
    return false;
  }

  // Explains more for what it takes, and no fewer of the check sessions.
  bool IsBetter(const Outcome& one, const Outcome& other) const {
    return CostOf(one) < CostOf(other) && one.unexplained_sessions.size() <= other.unexplained_sessions.size();
  }

  // What is left and what it took to explain the rest.
  double CostOf(const Outcome& outcome) const {
    double cost = ComparableSquaresOf(outcome.fit);
    for (const Added& one : outcome.attempt.extension.effects) {
      const bool is_named = !IsUnnamed(one.candidate.family);
      constexpr int kUnnamedColumns = 3;
      const int columns = is_named ? shapes::BasisCount(one.candidate.term.shape) : kUnnamedColumns;
      cost += options_.search.evidence + options_.search.per_column * (columns - 1);
    }
    return cost;
  }

  static identify::Options OptionsOf(const Options& options) {
    identify::Options out;
    out.cancelled = options.cancelled;
    out.scale_uncertainties = true;
    out.judge_bends = false;  // of fits on the way, which a model that misses bends
    return out;
  }

  absl::StatusOr<Outcome> Try(const Way& way) {
    Outcome outcome{{Extension(machine_, runs_), way, {}, {}, false, {}}, {}, {}, {}};
    Attempt* const attempt = &outcome.attempt;
    Report* const report = &attempt->report;
    std::vector<Added>& effects = attempt->extension.effects;
    report->has_check = !check_.is_empty();
    if (options_.progress) options_.progress({"fitting the declared model", 0.0, ""});
    ASSIGN_OR_RETURN(Fit fit, FitExtension(machine_, attempt->extension, identify_options_));
    report->fit_before = fit.result.fit;
    KeepResiduals(fit, runs_, &SessionResiduals::before_mm, report);
    ASSIGN_OR_RETURN(report->check_before, CheckStatistics(fit.result.model, &SessionResiduals::before_mm, report));
    for (const Added& one : way.prefix) {
      effects.push_back(one);
      ASSIGN_OR_RETURN(fit, FitExtension(machine_, attempt->extension, identify_options_));
      attempt->Note(Step::kAdded, attempt->extension.NameOf(effects.size() - 1), fit);
    }
    Growth growth(machine_, options_, identify_options_, attempt);
    Validation validation(machine_, identify_options_, &check_, attempt);
    RETURN_IF_ERROR(growth.Extend(&fit));
    ASSIGN_OR_RETURN(const bool has_replaced, validation.Run(&fit));
    if (has_replaced) {
      // What had no name beside the wrong effect may have one beside the right one, or not be there at all.
      std::erase_if(effects, [](const Added& one) { return IsUnnamed(one.candidate.family); });
      ASSIGN_OR_RETURN(fit, FitExtension(machine_, attempt->extension, identify_options_));
      RETURN_IF_ERROR(growth.Prune(&fit));
      RETURN_IF_ERROR(growth.Extend(&fit));
      RETURN_IF_ERROR(validation.Run(&fit).status());
    }
    ASSIGN_OR_RETURN(outcome.check_after, CheckStatistics(fit.result.model, &SessionResiduals::after_mm, report));
    if (!check_.is_empty()) {
      RETURN_IF_ERROR(check_.Settle(fit));
      ASSIGN_OR_RETURN(outcome.unexplained_sessions, check_.UnexplainedSessions(fit));
    }
    outcome.fit = std::move(fit);
    return outcome;
  }

  absl::StatusOr<Report> Finish(Outcome* outcome) const {
    Report& report = outcome->attempt.report;
    RETURN_IF_ERROR(DropToldApart(outcome->fit, identify_options_, &outcome->attempt.extension));
    Describe(machine_, runs_, outcome->attempt.extension, outcome->fit, options_.search, &report);
    KeepResiduals(outcome->fit, runs_, &SessionResiduals::after_mm, &report);
    report.last_fit = std::make_shared<Fit>(outcome->fit);
    report.check_after = outcome->check_after;
    report.unexplained.insert(report.unexplained.end(), outcome->unexplained_sessions.begin(),
                              outcome->unexplained_sessions.end());
    if (!report.unexplained.empty()) report.verdict = Verdict::kUnexplained;
    return std::move(report);
  }

  using ResidualField = Eigen::MatrixXd SessionResiduals::*;

  // Parts of a session whose artefact slipped join again.
  void KeepResiduals(const Fit& fit, const std::vector<MeasuringRun>& runs, ResidualField field, Report* report) const {
    const bool is_check = &runs == &check_.runs();
    const size_t offset = is_check ? runs_.size() : 0;
    report->residuals.resize(runs_.size() + check_.runs().size());
    size_t part = 0;
    for (size_t i = 0; i < runs.size(); ++i) {
      SessionResiduals& kept = report->residuals[offset + i];
      kept.session = runs[i].session;
      kept.is_check = is_check;
      Eigen::MatrixXd& residuals_mm = kept.*field;
      residuals_mm.resize(runs[i].row_count, runs[i].reading_count());
      for (Eigen::Index at = 0; at < residuals_mm.cols(); ++part) {
        const Eigen::MatrixXd& columns = fit.residuals_mm[part];
        residuals_mm.middleCols(at, columns.cols()) = columns;
        at += columns.cols();
      }
    }
  }

  absl::StatusOr<identify::FitStatistics> CheckStatistics(const ErrorModel& model, ResidualField field,
                                                          Report* report) const {
    if (check_.is_empty()) return identify::FitStatistics{};
    ASSIGN_OR_RETURN(const Fit check, check_.Under(model));
    KeepResiduals(check, check_.runs(), field, report);
    return check.result.fit;
  }

  const Machine& machine_;
  const std::vector<MeasuringRun> runs_;
  const std::function<void(const identify::Progress&)> whole_progress_;
  const Options options_;  // its progress is that of the loop alone
  const identify::Options identify_options_;
  Check check_;
};

}  // namespace

absl::StatusOr<Report> CloseLoop(const Machine& machine, std::vector<MeasuringRun> fit, std::vector<MeasuringRun> check,
                                 const Options& options) {
  return Loop(machine, std::move(fit), std::move(check), options).Run();
}

}  // namespace axiscal::loop
