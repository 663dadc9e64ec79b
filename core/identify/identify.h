// Identification: weighted least squares over declared error terms and each session's setup offsets, with standard
// uncertainties, rank, and the combinations that the data cannot separate.
#ifndef AXISCAL_CORE_IDENTIFY_IDENTIFY_H_
#define AXISCAL_CORE_IDENTIFY_IDENTIFY_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/identify/budget.h"
#include "core/identify/held.h"
#include "core/identify/problem.h"
#include "core/identify/result.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::identify {

struct Progress {
  std::string stage;      // "reading sessions", "fitting" ...
  double fraction = 0.0;  // 0 to 1
  std::string detail;     // "iteration 2, rms 1.3 um"
};

struct Options {
  // Error terms to fit. Unset: the machine's declared constants. An empty model fits setup offsets only.
  std::optional<machine::ErrorModel> model;
  bool fit_nonlinear = true;  // decay lengths and time constants too
  bool set_outliers_aside = true;
  // Multiplies uncertainties by sqrt(chi2 / dof) where the readings scatter more than the stated sigma.
  bool scale_uncertainties = true;
  // Where neighbouring readings of a dense series are correlated (servo ripple), fits again with that correlation:
  // independent readings would state uncertainties that are too small. The same where many readings scatter by clearly
  // less than stated. Of FitRuns and Identify.
  bool judge_correlation = true;
  // Fits errors that are held at zero where holding them biases others (gauge.h); where the problem is curved
  // (touches), checks each interval by its profile likelihood (profile_likelihood.h).
  bool profile_intervals = true;
  // Its sources that are drawn for every reading weigh the readings (row_weights.h). Of FitRuns and Identify.
  std::optional<Budget> budget;
  int max_iterations = 20;
  // Ends the fit once the next step would take less than this off chi-square.
  double converged_decrement = 1e-6;  // a step of a thousandth of a standard deviation: no reading could show it
  // A model that misses so that the fit does not converge is fitted with sigma raised (Result::noise_scale); false ends
  // the fit with FAILED_PRECONDITION instead.
  bool raise_noise = true;
  // Errors of an earlier identification that act at their values; the model holds none of them. Of FitRuns and
  // Identify.
  std::optional<HeldErrors> held_errors;
  // Polled in every iteration; true ends the fit with CANCELLED.
  std::function<bool()> cancelled;
  std::function<void(const Progress&)> progress;
};

// INVALID_ARGUMENT naming field, value and rule.
absl::Status Validate(const Options& options);

// INVALID_ARGUMENT for sessions that do not fit the machine or the model (FitMeasured), FAILED_PRECONDITION when the
// fit does not converge or has fewer readings than unknowns, CANCELLED.
absl::StatusOr<Result> Identify(const machine::Machine& machine, const std::vector<session::Session>& sessions,
                                const Options& options = {});

// More than a third of a feature's touches, and more than two, that would be set aside: no chips. They stay in the fit.
struct StandingOut {
  int run = 0, feature = 0;  // touch::Touches::features
  int touches = 0, of = 0;   // that stand out of the series or failed a gate; of the session
};

// The same on bound runs, for callers that need residuals too.
struct Fit {
  Problem problem;
  Point point;
  std::vector<Eigen::MatrixXd> residuals_mm;  // per run, predicted - measured
  Result result;
  std::vector<StandingOut> standing_out;
};
// INVALID_ARGUMENT also for a budget that names a session which is not there.
absl::StatusOr<Fit> FitRuns(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs,
                            const Options& options);

// FitRuns, and the nominal machine's fit to the same runs (Result::nominal): what an identification reports.
// INVALID_ARGUMENT where errors are fitted and a session has a feature of which too many touches stand out, and where
// two sessions hold the same readings.
absl::StatusOr<Fit> FitMeasured(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs,
                                const Options& options);

// Identify() with what it went through: BindSessions, then FitMeasured.
absl::StatusOr<Fit> FitSessions(const machine::Machine& machine, const std::vector<session::Session>& sessions,
                                const Options& options);

// A prepared problem (noise judged, readings set aside) from `model` on, and from the setup offsets `setup` (per group,
// mm and rad) where they are known; zero otherwise. Three stages: solve.h, judge.h, describe.h.
absl::StatusOr<Fit> FitProblem(Problem problem, const machine::ErrorModel& model, const Options& options,
                               const std::vector<Eigen::VectorXd>& setup = {});

// A measured session. INVALID_ARGUMENT where it does not fit the machine, or is of an instrument that reads one value
// all the time (instruments/plausible.h).
absl::StatusOr<instruments::MeasuringRun> BindMeasured(const session::Session& session,
                                                       const machine::Machine& machine);
// Each of them.
absl::StatusOr<std::vector<instruments::MeasuringRun>> BindSessions(const machine::Machine& machine,
                                                                    const std::vector<session::Session>& sessions);

// Other sessions under a fitted model: only their setup offsets are refitted.
absl::StatusOr<Fit> CheckRuns(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs,
                              const machine::ErrorModel& model, const Options& options);
// The same under the errors of a fit: a session that states a set-up (`# setup: NAME`) which the fit has keeps the
// fit's offsets, none of which are refitted, and one of an instrument whose one scale the fit has (`scale_of`) keeps
// that. INVALID_ARGUMENT where their headers contradict each other.
absl::StatusOr<Fit> CheckRuns(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs,
                              const Fit& fitted, const Options& options);
// The first run of `fit` whose set-up a session states, if any; one that slipped is nobody else's.
std::optional<size_t> SharedSetup(const instruments::MeasuringRun& run, const Problem& fit);
// The first run of `fit` whose instrument's scale is this session's, if any.
std::optional<size_t> SharedScale(const instruments::MeasuringRun& run, const Problem& fit);

// Statistics of residuals and of the priors that judge (SetupParameter::is_placed). `parameters` counts the fitted
// errors and OffsetsFromReadings (reduction.h); a setup offset with a judging prior adds as many readings as unknowns.
FitStatistics StatisticsOf(const Problem& problem, const Point& point, const std::vector<Eigen::MatrixXd>& residuals_mm,
                           int parameters);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_IDENTIFY_H_
