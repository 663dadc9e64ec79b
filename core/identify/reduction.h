// Linear algebra of the normal equations (problem.h): setup offsets are eliminated group by group (Schur complement),
// which leaves equations of the machine's errors alone.
#ifndef AXISCAL_CORE_IDENTIFY_REDUCTION_H_
#define AXISCAL_CORE_IDENTIFY_REDUCTION_H_

#include <Eigen/Core>
#include <vector>

#include "core/identify/problem.h"
#include "core/information/null_space.h"

namespace axiscal::identify {

// Which priors of the setup offsets count. kInformative leaves the weak ones out: errors that only a weak prior
// ("mounted by hand") separates from an offset are not identified.
enum class Priors { kAll, kInformative };

// Precision (1 / sigma^2) that a prior adds; none where nothing is known or, for kInformative, where the prior is weak.
double PriorPrecision(const instruments::SetupParameter& parameter, Priors priors);

// Normal equations of the errors after elimination, the priors of free curves among them whatever is asked for: what a
// curve may be is knowledge. Information S, gradient g (d cost / d errors), and the cost at the
// setup's optimum.
struct Reduced {
  Eigen::MatrixXd information;  // p x p
  Eigen::VectorXd gradient;     // p
  Eigen::VectorXd column_norm;  // p: norm of each whitened Jacobian column before elimination
};

Reduced Reduce(const Problem& problem, const Point& point, const NormalEquations& normal, Priors priors,
               double damping = 0.0);

// What varies along an axis of a machine that is to cut stays below this, mm and rad.
inline constexpr double kLargestErrorMm = 10.0, kLargestErrorRad = 0.03;

// As large as an error is taken to get where the readings hardly show it; infinite for a non-linear parameter.
double LargestOf(const machine::ErrorModel& model, const Parameter& parameter);

// Reduce() without weak priors of the amplitudes of `point`'s model, made zero for an error that all readings together
// would show by less than one standard deviation at its LargestOf size. A ball bar, for one, shows an error across
// itself only through the rounding of positions in the file; fitted, such an error would run away.
Reduced ReduceVisible(const Problem& problem, const Point& point, const NormalEquations& normal);

// Information on the errors in `kept`, in their order, once the others are refitted beside them (Schur complement).
Eigen::MatrixXd InformationBeside(const Reduced& reduced, const std::vector<int>& kept);

// Inverse of the information while the errors in `held` do not move: p x p, zero rows and columns for those.
Eigen::MatrixXd InverseBeside(const Reduced& reduced, const std::vector<int>& held);

// What adds up over problems about the same errors and has a null space.
inline information::Information InformationOf(const Reduced& reduced) {
  return {reduced.information, reduced.column_norm.cwiseAbs2()};
}

// Directions in the space of errors that the data does not see.
using information::NullSpace;
inline NullSpace FindNullSpace(const Reduced& reduced) { return information::FindNullSpace(InformationOf(reduced)); }

struct GaussNewtonStep {
  Eigen::VectorXd errors;              // p; zero for held ones
  std::vector<Eigen::VectorXd> setup;  // per group
  double decrement = 0.0;              // predicted decrease of the sum of squares
};

// Gauss-Newton step with all priors; the errors in `held` do not move. `damping` (Levenberg-Marquardt) adds to the unit
// diagonal of the scaled blocks.
GaussNewtonStep SolveStep(const Problem& problem, const Point& point, const NormalEquations& normal,
                          const std::vector<int>& held, double damping = 0.0);

struct Covariance {
  Eigen::MatrixXd errors;                    // p x p; zero rows and columns for held errors
  std::vector<Eigen::VectorXd> setup_sigma;  // per group
  std::vector<Eigen::MatrixXd> setup;        // per group, of its offsets, as setup_sigma
  // Per group, errors x setup offsets, as the stated sigmas have it and without `known`: divided by an offset's prior
  // variance it is how the errors move with what the prior takes the offset for.
  std::vector<Eigen::MatrixXd> with_setup;
};

// `scale` multiplies what the readings' scatter makes uncertain. `known`: covariance of the last columns, errors that
// are not fitted but known from elsewhere; they and their share of the fitted ones' uncertainty are in the result.
Covariance CovarianceOf(const Problem& problem, const Point& point, const NormalEquations& normal,
                        const std::vector<int>& held, double scale = 1.0, const Eigen::MatrixXd& known = {});

// Gauss-Newton steps of the errors where residuals of one group change by the columns of a matrix D. `by_change`: per
// group J' D, (set-up offsets, errors) x columns, of whitened rows. Per group, p x columns; zero for held errors.
std::vector<Eigen::MatrixXd> StepsOf(const Problem& problem, const Point& point, const NormalEquations& normal,
                                     const std::vector<int>& held, const std::vector<Eigen::MatrixXd>& by_change);

// Sum of squares of the priors' residuals: of all, free curves' too; of those that judge the fit
// (SetupParameter::is_placed).
double PriorSquares(const Problem& problem, const Point& point);
double JudgingPriorSquares(const Problem& problem, const Point& point);

// How many amplitudes of free curves their prior determines in place of the readings, a part where both do: the sum of
// variance with the readings / variance of the prior.
double AmplitudesFromPriors(const Problem& problem, const Point& point, const NormalEquations& normal,
                            const std::vector<int>& held);

// How many set-up offsets without a judging prior the readings determine, a part where the prior does the rest: the sum
// of 1 - (variance with the prior / variance of the prior). An offset with a judging prior brings as much as it takes.
double OffsetsFromReadings(const Problem& problem, const Point& point, const NormalEquations& normal,
                           const std::vector<int>& held);

// How much of what the set-ups could be the readings rule out: log det(I + V N), N the information of the readings on
// the offsets with a prior while the errors stand and offsets without one are refitted, V the priors' variances. Of two
// models that fit alike the one with the smaller number leaned less on its set-ups: the Occam factor of Laplace's
// approximation (MacKay 1992, "Bayesian interpolation").
double LeaningOnSetups(const Problem& problem, const NormalEquations& normal);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_REDUCTION_H_
