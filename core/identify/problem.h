// The least-squares problem of identification: runs, an error model, setup offsets, noise; and its normal equations.
//   residual = (predicted - measured) / sigma;   normal matrix [S1 0 C1; 0 S2 C2; C1' C2' E]
// S: setup offsets of one group of runs (a session, sessions that share a setup, or all of one instrument's whose scale
// is one), E: errors, C: where both meet. No reading links the offsets of two groups, so the matrix has the shape of an
// arrow ("block angular", Bjorck 1996, 6.3). Only these blocks are kept and no rows: time grows with the number of
// readings, memory does not.
#ifndef AXISCAL_CORE_IDENTIFY_PROBLEM_H_
#define AXISCAL_CORE_IDENTIFY_PROBLEM_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/instruments/run.h"
#include "core/machine/error_model.h"

namespace axiscal::identify {

// Noise of one run. A share of its variance is white, the rest is first-order autoregressive (servo ripple and slow
// wander). Two readings of one row that are `lag` readings apart correlate by (1 - white_share) ar1^lag.
struct Noise {
  double sigma_mm = 0.0;     // standard deviation of one reading
  double ar1 = 0.0;          // 0: all of it is white
  double white_share = 0.0;  // of the variance, 0 to 1; without meaning where ar1 is 0

  double NeighbourCorrelation() const { return (1.0 - white_share) * ar1; }
};

// What one column of the problem is: an amplitude of a term, or a term's non-linear parameter (decay length, time
// constant).
struct Parameter {
  int term = 0;
  int basis = 0;
  bool is_nonlinear = false;
};

struct SetupGroup {
  std::vector<instruments::SetupParameter> parameters;
  std::vector<int> runs;
};

// row_count x row_count.
using RowWeight = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, instruments::kMaxRows,
                                instruments::kMaxRows>;

struct Problem {
  const machine::Machine* machine = nullptr;
  machine::ErrorModel fixed_model;   // errors that act but are not fitted
  Eigen::MatrixXd fixed_covariance;  // of ListParameters(fixed_model, true), mm and rad; empty: they are exact
  std::vector<instruments::MeasuringRun> runs;
  std::vector<Noise> noise;                // per run
  std::vector<std::vector<bool>> is_used;  // per run, reading * row_count + row; false for readings set aside
  // Per run: empty, or a matrix per reading. Its rows times the matrix scatter by the run's sigma each and are not
  // correlated (row_weights.h). A reading is then used or set aside as a whole.
  std::vector<std::vector<RowWeight>> row_weights;
  std::vector<SetupGroup> groups;
  std::vector<int> group_of_run;
  // Where each offset of a run (MeasuringRun::setup) stands among its group's. All of them in order, but where a group
  // holds several set-ups, which have one offset in common: the scale of their instrument.
  std::vector<std::vector<Eigen::Index>> offsets_of_run;

  const RowWeight* WeightOf(size_t run, int reading) const {
    return row_weights.empty() || row_weights[run].empty() ? nullptr : &row_weights[run][reading];
  }
};

// Values of everything that is fitted.
struct Point {
  machine::ErrorModel model;
  std::vector<Eigen::VectorXd> setup;  // per group, mm and rad
};

// Values of a run's own setup offsets, in their order.
Eigen::VectorXd SetupOf(const Problem& problem, const Point& point, size_t run);

// The first run with this one's set-up: itself where it has one of its own.
size_t FirstOfSetup(const Problem& problem, size_t run);
size_t CountSetups(const Problem& problem);

// Sessions that share a setup are measured with one mounting. INVALID_ARGUMENT naming both, the key and its values when
// they differ in instrument, datum, nominal ball, bar, anchor, beam, features, stated sigmas or, where offsets are of
// the tool, its tip.
absl::Status CheckSameSetup(const instruments::MeasuringRun& first, const instruments::MeasuringRun& other);

// Where the setup offset `scale` of a session that has `scale_of` stands in its setup.
size_t ScaleAt(const instruments::MeasuringRun& run);

// INVALID_ARGUMENT naming both sessions and values where they state the one scale of their instrument (`scale_of`) to
// be known with different sigmas.
absl::Status CheckSameScale(const instruments::MeasuringRun& first, const instruments::MeasuringRun& other);

// What the set-up offsets of a session that shares those of `first` start from: a tracker's frame, a length's zero.
void StartAs(const instruments::MeasuringRun& first, instruments::MeasuringRun* run);

// One clock for all sessions of a fit, or none (no column t_s in any), and in each of them what the errors of the model
// depend on. INVALID_ARGUMENT naming two of which only one has a clock, or as machine::RequireState.
absl::Status CheckRecorded(const machine::Machine& machine, const std::vector<instruments::MeasuringRun>& runs,
                           const machine::ErrorModel& model = {});

// Sessions that share a setup start as the first of them (StartAs). INVALID_ARGUMENT as CheckSameSetup and
// CheckSameScale, and when two sessions have one name.
absl::StatusOr<Problem> MakeProblem(const machine::Machine& machine, std::vector<instruments::MeasuringRun> runs);

// Entries of Problem::is_used of one run that are bad whatever is fitted: touches that were rejected, rows that stand
// in the run as bad.
void SetKnownAside(const instruments::MeasuringRun& run, std::vector<bool>* is_used);

Point StartingPoint(const Problem& problem, const machine::ErrorModel& model);

// Columns in the order of the model's terms: amplitudes, then the non-linear parameter where `with_nonlinear`.
std::vector<Parameter> ListParameters(const machine::ErrorModel& model, bool with_nonlinear);
double ValueOf(const machine::ErrorModel& model, const Parameter& parameter);
// 1 / sigma^2 of the prior of a free curve's amplitude (machine::ErrorTerm::prior_sigma), of mean zero; 0 where there
// is none.
double PriorPrecision(const machine::ErrorModel& model, const Parameter& parameter);
void SetValue(const Parameter& parameter, double value, machine::ErrorModel* model);

// Normal equations of one group's rows, without priors; order: setup, errors, residual.
struct GroupNormal {
  Eigen::MatrixXd gram;  // (s + p + 1)^2, both triangles
  int setup_count = 0;
};

struct NormalEquations {
  std::vector<Parameter> parameters;  // of the errors, in the order of the columns
  std::vector<GroupNormal> groups;
  int row_count = 0;  // rows that are used
};

NormalEquations Assemble(const Problem& problem, const Point& point, const std::vector<Parameter>& parameters);

// Predicted - measured of every reading, used or not: per run, row_count x readings, mm.
std::vector<Eigen::MatrixXd> ResidualsOf(const Problem& problem, const Point& point);
// Residuals of one run with unit variance and, where neighbours correlate, without that correlation (whitening.h); zero
// for rows that are not used. Row_count x readings.
Eigen::MatrixXd WhitenedOf(const Problem& problem, size_t run, const Eigen::MatrixXd& residuals_mm);
// Sum of squared whitened residuals of the used rows: of one run, of all.
double WhitenedSquaresOf(const Problem& problem, size_t run, const Eigen::MatrixXd& residuals_mm);
double WhitenedSquares(const Problem& problem, const std::vector<Eigen::MatrixXd>& residuals_mm);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_PROBLEM_H_
