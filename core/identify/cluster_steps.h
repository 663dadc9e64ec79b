// How much the readings of one stretch of time alone move the fitted errors. An incomplete model leaves residuals that
// go together, and a fit takes each such stretch for as many independent readings as it has: its uncertainties are then
// too small. How far the stretches pull apart is what they should be (cluster-robust or "sandwich" covariance: Liang
// and Zeger 1986, Biometrika 73, eq. 8).
#ifndef AXISCAL_CORE_IDENTIFY_CLUSTER_STEPS_H_
#define AXISCAL_CORE_IDENTIFY_CLUSTER_STEPS_H_

#include "core/identify/solve.h"

namespace axiscal::identify {

// Stretches of equal numbers of readings that each session is cut into: a variance that is taken from n of them is off
// by sqrt(2 / n) of itself, and a plan has several sessions.
constexpr int kClustersPerRun = 16;

// p x clusters, mm and rad; zero for held errors: the Gauss-Newton step of the errors that the residuals of one cluster
// ask for, the set-ups refitted beside them. Their sum is what priors hold against.
Eigen::MatrixXd ClusterSteps(const SolvedProblem& solved);

// Per error, at least 1: the variance that its clusters show over `variance` (of readings that are independent, Birge
// ratio included), the design effect of its number (Kish 1965, section 8.2). 1 for held errors.
Eigen::VectorXd DesignEffects(const SolvedProblem& solved, const Eigen::VectorXd& variance, int degrees_of_freedom);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_CLUSTER_STEPS_H_
