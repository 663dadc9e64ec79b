// Small histories whose truth is known, for the tests of the detector.
#ifndef AXISCAL_CORE_DRIFT_TESTING_HISTORIES_H_
#define AXISCAL_CORE_DRIFT_TESTING_HISTORIES_H_

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/drift/detector.h"

namespace axiscal::drift {

inline base::UtcTime Week(int week) {
  return base::FromUtcUs(1'420'416'000'000'000) + std::chrono::days(7 * week);  // from Monday 2015-01-05 on
}

// Three errors, the first two correlated by 0.5; sigmas 2 um, 1 um, 3 urad.
inline Eigen::MatrixXd UsualCovariance() { return Eigen::MatrixXd{{4.0, 1.0, 0.0}, {1.0, 1.0, 0.0}, {0.0, 0.0, 9.0}}; }

inline Calibration At(int week, const Eigen::VectorXd& values, const Eigen::MatrixXd& covariance = UsualCovariance()) {
  static const std::vector<std::string> kNames = {"EX0C", "EY0C", "EB0C"};
  Calibration calibration;
  calibration.at = Week(week);
  for (int j = 0; j < values.size(); ++j)
    calibration.values.push_back({kNames[j], j == 2 ? Unit::kUrad : Unit::kUm, values(j)});
  calibration.covariance = covariance;
  return calibration;
}

// Weekly calibrations with the scatter that they state, about (10, -5, 30).
class Machine {
 public:
  explicit Machine(uint64_t seed) : random_(seed) {}

  Calibration Measure(int week, const Eigen::MatrixXd& covariance = UsualCovariance()) {
    Eigen::VectorXd normal(3);
    for (double& one : normal) one = random_.Normal();
    const Eigen::MatrixXd root = covariance.llt().matrixL();
    return At(week, truth + root * normal, covariance);
  }

  Eigen::VectorXd truth = Eigen::Vector3d(10.0, -5.0, 30.0);

 private:
  base::Random random_;
};

// Advance() where nothing may be refused; the findings are added to `all`.
inline void Tell(const Calibration& calibration, State* state, std::vector<Finding>* all) {
  const auto findings = Advance(calibration, state);
  if (!findings.ok()) {
    ADD_FAILURE() << findings.status();
    return;
  }
  all->insert(all->end(), findings->begin(), findings->end());
}

template <typename Kind>
std::vector<Kind> Only(const std::vector<Finding>& findings) {
  std::vector<Kind> some;
  for (const Finding& finding : findings) {
    if (const Kind* const one = std::get_if<Kind>(&finding)) some.push_back(*one);
  }
  return some;
}

// Steps that are more than possible: of a hundred machine-years a few have one of the others by chance.
inline std::vector<StepChange> Clear(const std::vector<Finding>& findings) {
  std::vector<StepChange> steps = Only<StepChange>(findings);
  std::erase_if(steps, [](const StepChange& step) { return step.word == Word::kPossible; });
  return steps;
}

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_TESTING_HISTORIES_H_
