// Is it a step, outliers or nothing? Scores of the last calibrations against what was expected before them.
// A shift of one error j has the prior N(0, 5^2) of its stated sigma. With the information I of the difference between
// what was measured and expected, and s = I difference, the ln Bayes factor of the shift is
//   b_j = -1/2 ln(1 + 25 I_jj) + 1/2 25 s_j^2 / (1 + 25 I_jj) - ln n,   n errors to choose from;
// given that shift, I and s become those of the others, and the next error is chosen (forward selection).
#ifndef AXISCAL_CORE_DRIFT_STEP_SCORE_H_
#define AXISCAL_CORE_DRIFT_STEP_SCORE_H_

#include <Eigen/Core>
#include <vector>

namespace axiscal::drift {

inline constexpr double kShiftVariance = 25.0;  // of a shift, in units of the stated sigma
inline constexpr int kMostShifted = 6;          // errors of one step or outlier

// What is known of the errors' shifts: information matrix (n x n, zeros where nothing is known) and I difference.
struct Evidence {
  Eigen::MatrixXd information;
  Eigen::VectorXd score;
  int choices = 1;  // errors that something is known of
};

struct Shift {
  std::vector<int> errors;  // in the order of choice
  double score = 0.0;       // sum of b
};

// The first is always taken, others while they raise the score.
Shift ChooseShift(Evidence evidence);
// The sum of b for these errors, in this order; those that nothing is known of count 0.
double ScoreOf(Evidence evidence, const std::vector<int>& errors);

// The shift of `errors` alone by generalised least squares, and its covariance.
struct ShiftSize {
  Eigen::VectorXd size;
  Eigen::MatrixXd covariance;
};
ShiftSize SizeOf(const Evidence& evidence, const std::vector<int>& errors);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_STEP_SCORE_H_
