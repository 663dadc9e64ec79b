#include "core/drift/step_score.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace axiscal::drift {
namespace {

double Gain(const Evidence& evidence, int j) {
  const double spread = 1.0 + kShiftVariance * evidence.information(j, j);
  return -0.5 * std::log(spread) + 0.5 * kShiftVariance * evidence.score(j) * evidence.score(j) / spread -
         std::log(static_cast<double>(evidence.choices));
}

// What is known of the others where error j has shifted by an unknown amount.
void Condition(int j, Evidence* evidence) {
  const Eigen::VectorXd column = evidence->information.col(j);
  const double share = kShiftVariance / (1.0 + kShiftVariance * column(j));
  evidence->score -= column * (share * evidence->score(j));
  evidence->information.noalias() -= share * column * column.transpose();
}

}  // namespace

Shift ChooseShift(Evidence evidence) {
  Shift shift;
  const auto n = static_cast<int>(evidence.score.size());
  while (static_cast<int>(shift.errors.size()) < std::min(n, kMostShifted)) {
    int best = -1;
    double gain = -INFINITY;
    for (int j = 0; j < n; ++j) {
      if (evidence.information(j, j) <= 0.0 ||
          std::find(shift.errors.begin(), shift.errors.end(), j) != shift.errors.end())
        continue;
      if (const double one = Gain(evidence, j); one > gain) best = j, gain = one;
    }
    if (best < 0 || (!shift.errors.empty() && gain <= 0.0)) break;
    shift.errors.push_back(best);
    shift.score += gain;
    Condition(best, &evidence);
  }
  return shift;
}

double ScoreOf(Evidence evidence, const std::vector<int>& errors) {
  double sum = 0.0;
  for (const int j : errors) {
    if (evidence.information(j, j) <= 0.0) continue;
    sum += Gain(evidence, j);
    Condition(j, &evidence);
  }
  return sum;
}

ShiftSize SizeOf(const Evidence& evidence, const std::vector<int>& errors) {
  const auto count = static_cast<Eigen::Index>(errors.size());
  const Eigen::MatrixXd information = evidence.information(errors, errors);
  ShiftSize shift;
  shift.covariance = Eigen::LLT<Eigen::MatrixXd>(information).solve(Eigen::MatrixXd::Identity(count, count));
  shift.size = shift.covariance * evidence.score(errors);
  return shift;
}

}  // namespace axiscal::drift
