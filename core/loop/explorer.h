// Searches from the declared model to one that explains the sessions: the plain search, searches that avoid an effect
// that may have misled it, and one with all sessions fitted together; and which result is taken (docs/loop.md).
#ifndef AXISCAL_CORE_LOOP_EXPLORER_H_
#define AXISCAL_CORE_LOOP_EXPLORER_H_

#include <vector>

#include "core/loop/check.h"
#include "core/loop/growth.h"

namespace axiscal::loop {

// Where an attempt ended.
struct Outcome {
  Attempt attempt;
  identify::Fit fit;
  identify::FitStatistics check_after;
  std::vector<Unexplained> unexplained_sessions;  // of the check sessions
};

using ResidualField = Eigen::MatrixXd SessionResiduals::*;

class Explorer {
 public:
  // All but the runs must outlive it. `check` may be empty.
  Explorer(const machine::Machine& machine, std::vector<instruments::MeasuringRun> fit,
           std::vector<instruments::MeasuringRun> check, const Options& options,
           const identify::Options& identify_options)
      : machine_(machine),
        runs_(std::move(fit)),
        options_(options),
        identify_options_(identify_options),
        check_(machine, std::move(check), identify_options) {}

  // The best outcome found. The errors of identify::FitRuns; CANCELLED.
  absl::StatusOr<Outcome> Explore();

  const std::vector<instruments::MeasuringRun>& fit_runs() const { return runs_; }
  const std::vector<instruments::MeasuringRun>& check_runs() const { return check_.runs(); }
  // The sessions that an outcome was fitted to: the fit sessions, or all.
  const std::vector<instruments::MeasuringRun>& RunsOf(const Outcome& outcome) const {
    return outcome.attempt.way.with_check ? together_ : runs_;
  }
  // Residuals of the fit sessions in `fit`, whose first runs they or their parts are.
  void KeepFitResiduals(const identify::Fit& fit, ResidualField field, Report* report) const {
    KeepResiduals(fit, runs_, field, report);
  }

 private:
  absl::StatusOr<Outcome> Try(const Way& way);
  absl::StatusOr<Outcome> Grow(Way* way);
  absl::StatusOr<bool> PreferNames(Way way, Outcome* best);
  absl::Status Detour(Way way, Outcome* best);
  absl::Status BeginElsewhere(Way way, Outcome* best);
  absl::StatusOr<bool> IsMoreInAll(const Outcome& best, bool* is_foretold);
  Way WayOfAll();
  absl::StatusOr<bool> FitTogether(Outcome* best);
  absl::Status FitSameTogether(Outcome* best);
  absl::StatusOr<bool> FitAlone(const Outcome& named, Outcome* best);
  bool IsBetter(const Outcome& one, const Outcome& other) const;
  double CostOf(const Extension& extension, const identify::Fit& fit) const;
  void KeepResiduals(const identify::Fit& fit, const std::vector<instruments::MeasuringRun>& runs, ResidualField field,
                     Report* report) const;
  absl::StatusOr<identify::FitStatistics> CheckStatistics(const identify::Fit& fit, ResidualField field,
                                                          Report* report);

  const machine::Machine& machine_;
  const std::vector<instruments::MeasuringRun> runs_;
  std::vector<instruments::MeasuringRun> together_;  // and the check sessions, where they are fitted, too
  const Options& options_;
  const identify::Options& identify_options_;
  Check check_;
};

}  // namespace axiscal::loop

#endif  // AXISCAL_CORE_LOOP_EXPLORER_H_
