// What errors that no reading shows leave uncertain in those that are shown.
//
// The directions of the gauge (gauge.h) change no reading where set-ups stand in their nominal places. Where an offset
// of a set-up is s, an error of size h along a direction n changes readings by
//   s h d,   d = d(J n)/ds   (J: derivatives of the readings by the errors)
// A beam that is askew by s reads s of what the axis does along it; a target that stands s lower has that much more of
// the lever of an angle. Of h nothing is known but that it is an error of a machine
// (sigma_h is assumed: 100 um, urad, um/m ..., plausible_errors.h says why), and the fit holds it at zero where
// the readings do not ask for it (gauge.h): by themselves, or because another error does the same there. What h does
// moves the fitted errors as readings that are off by it do, with variances
//   sigma_h^2             by J n at the solution, which holds what is known of s
//   sigma_s^2 sigma_h^2   by d, for what is not known of s: the second-order term of the law of propagation where both
//                         first-order terms are zero (JCGM 100:2008, 5.1.2, note)
#ifndef AXISCAL_CORE_IDENTIFY_UNSEEN_H_
#define AXISCAL_CORE_IDENTIFY_UNSEEN_H_

#include "core/identify/reduction.h"
#include "core/identify/solve.h"

namespace axiscal::identify {

// Of a long run, sums over its readings are taken of so many stretches of four: 96 readings, the first of each stretch
// left out, tell the size of a term of second order to three per cent. All of them would cost more than the fit.
constexpr int kUnseenStretches = 32;

// Covariance of the fitted errors (solved.parameters) by that, mm and rad; zero for held errors. `covariance`: of
// errors and set-ups by the readings. sigma_h: kMeasuredWithin of a plausible size of each error (plausible_errors.h),
// along the directions that solved.held hold. Offsets of the instruments' own set-up count, not those of faults and
// slips. `stretches` of each run are looked at.
Eigen::MatrixXd UnseenCovariance(const SolvedProblem& solved, const Covariance& covariance,
                                 int stretches = kUnseenStretches);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_UNSEEN_H_
