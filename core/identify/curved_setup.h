// What set-up offsets that no reading shows leave uncertain by the curvature of the readings.
//
// Two faces that were touched once each, in their middle, stand |d| / cos c apart when their artefact is turned by c.
// No reading tells c where it is about zero, as the distance does not change with it to first order; but a turn of 20
// mrad makes 200 um/m, which reads like a scale of the machine. Linear propagation knows nothing of it: there the
// derivative by c is zero. With s the offsets beside the solution, of covariance S, readings are off by
//   1/2 s' H s,   H: second derivatives of a reading by the offsets
// and so the fitted errors move by quadratic forms s' Q s, of which
//   E[s' Qa s  s' Qb s] = 2 tr(Qa S Qb S) + tr(Qa S) tr(Qb S)
// for a normal s (JCGM 100:2008, 5.1.2, note, has the first part; the second is the mean, which no fit takes off).
#ifndef AXISCAL_CORE_IDENTIFY_CURVED_SETUP_H_
#define AXISCAL_CORE_IDENTIFY_CURVED_SETUP_H_

#include "core/identify/solve.h"

namespace axiscal::identify {

// Mean squares and products of the fitted errors (solved.parameters) by that, mm and rad; zero for held errors.
// `covariance`: of errors and set-ups by the readings. Offsets of touch sessions count (all
// others are nearly linear in their set-up, solve.cc) whose weak prior (a place or turn by hand) is what
// is known of them: a standard uncertainty of more than half of the prior's. What the others do by
// curvature is not in it.
Eigen::MatrixXd CurvedSetupCovariance(const SolvedProblem& solved, const Covariance& covariance);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_CURVED_SETUP_H_
