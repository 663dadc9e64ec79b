// The first stage of a fit: the point of least chi-square.
#ifndef AXISCAL_CORE_IDENTIFY_SOLVE_H_
#define AXISCAL_CORE_IDENTIFY_SOLVE_H_

#include <algorithm>
#include <vector>

#include "core/identify/gauge.h"
#include "core/identify/identify.h"
#include "core/identify/solver.h"

namespace axiscal::identify {

// Rise of chi-square, in units of what it is per degree of freedom, that refuses a solution: four standard
// uncertainties.
inline constexpr double kRefused = 16.0;

struct SolvedProblem {
  Problem problem;                        // with the noise that was fitted with; outliers are set aside
  std::vector<StandingOut> standing_out;  // of the solution
  std::vector<Parameter> parameters;
  NullSpace null_space;   // of the nominal machine, in the columns of `parameters`
  std::vector<int> held;  // of null_space.fixed, the errors that are held at the solution (gauge.h)
  Solution solution;
  // Of a curved problem: the minima of chi-square that were found before outliers were set aside, the best first.
  std::vector<Solution> minima;
  // Of touched faces: solutions with a turn of a set-up held elsewhere, chi-square within kRefused of the best.
  std::vector<Solution> along_turns;
  // Readings are so far from linear in the unknowns that linear propagation may state uncertainties that are too small
  // (Bates and Watts 1988, ch. 7, "curvature"). False where options.profile_intervals asks for no judgement of it.
  bool is_curved = false;
  bool is_way_curved = false;  // a step of the first fit was damped or led back
  double noise_scale = 1.0;    // Result::noise_scale

  // null_space with `held` as its gauge.
  NullSpace Holding() const;
  // Unknowns that take a degree of freedom each: errors, and set-up offsets that no prior judges (reduction.h).
  double Unknowns(const Solution& at) const;
  bool IsHeld(int error) const { return std::find(held.begin(), held.end(), error) != held.end(); }
};

// FitProblem()'s arguments and errors.
absl::StatusOr<SolvedProblem> SolveProblem(Problem problem, const machine::ErrorModel& model, const Options& options,
                                           const std::vector<Eigen::VectorXd>& setup);

}  // namespace axiscal::identify

#endif  // AXISCAL_CORE_IDENTIFY_SOLVE_H_
