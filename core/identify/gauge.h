// The gauge of a fit: which errors are held at zero while the others are fitted, one for every direction in the space
// of errors that no reading shows.
//
// The directions (NullSpace) are a property of the poses and the error terms. They are found on the nominal machine,
// where they are exact. At the solution the set-ups stand where they really stood, and some of the held errors may show
// in the readings after all. Held at zero, such an error is an omitted variable: the fit misses, and other errors take
// up what it does, with wrong numbers. Two rules say which of them are fitted too: HeldAtSolution and BiasesMost. An
// error that is freed by them still gets no number of its own: it shows only because of where a set-up happened to
// stand.
#ifndef AXISCAL_CORE_IDENTIFY_GAUGE_H_
#define AXISCAL_CORE_IDENTIFY_GAUGE_H_

#include <optional>
#include <vector>

#include "core/identify/reduction.h"
#include "core/identify/solver.h"

namespace axiscal::identify {

// The problem on the nominal machine, all amplitudes and offsets zero.
struct Nominal {
  Point point;
  NormalEquations normal;  // of the amplitudes; errors that the problem holds act
  NullSpace null_space;    // of the amplitudes; none act
};
Nominal AtNominal(const Problem& problem, const machine::ErrorModel& model);

// The same directions in the columns of ListParameters(model, true). A non-linear parameter is judged by its own
// uncertainty, not by rank.
NullSpace WithNonlinearColumns(const NullSpace& space, const machine::ErrorModel& model);

// Of null_space.fixed, in their order, the errors to hold at the solution as well: those that the readings show there
// by less than one standard deviation of chi-square at a plausible size. With S the information on the errors in
// question once all others are refitted (Schur complement), an error of size a changes chi-square by S a^2. The
// best-seen error is freed first, then each time the best-seen in what the freed ones leave.
std::vector<int> HeldAtSolution(const Problem& problem, const Solution& solution,
                                const std::vector<Parameter>& parameters, const NullSpace& null_space);

// The error in `held` whose absence biases the identified errors most, if it does by more than half a standard
// uncertainty of one of them and the readings ask for it (score test of an omitted parameter, Rao 1948). With g its
// gradient of chi-square / 2 and S its information beside the fitted errors, freeing it would
//   move it by a = g / S, at most by a plausible size;   lower chi-square by 2 |g| a - S a^2 (4 are asked for);
//   move the fitted errors by C b a, C their covariance, b the cross information.
std::optional<int> BiasesMost(const Problem& problem, const Solution& solution,
                              const std::vector<Parameter>& parameters, const NullSpace& null_space,
                              const std::vector<int>& held);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_GAUGE_H_
