// Simulated histories are what their description says.
#include "core/synthetic/machine_years.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace axiscal::synthetic {
namespace {

using ::testing::HasSubstr;

YearsToDraw Clean(uint64_t seed) {
  YearsToDraw asked;
  asked.seed = seed;
  asked.disturbances = {true, false, false, false, false, false, 0.0};
  return asked;
}

Eigen::VectorXd ValuesOf(const drift::Calibration& calibration) {
  Eigen::VectorXd values(calibration.values.size());
  for (size_t i = 0; i < calibration.values.size(); ++i) values(static_cast<long>(i)) = calibration.values[i].value;
  return values;
}

TEST(MachineYears, ACleanMachineScattersAsItStates) {
  const MachineYears machine = DrawMachineYears(Clean(3), 0);
  ASSERT_EQ(machine.plans.size(), 1u);
  const Eigen::LLT<Eigen::MatrixXd> root(machine.plans[0].covariance);
  double squares = 0.0;
  for (size_t i = 0; i < machine.calibrations.size(); ++i)
    squares += root.matrixL().solve(ValuesOf(machine.calibrations[i]) - machine.truth[i]).squaredNorm();
  const double count = 13.0 * static_cast<double>(machine.calibrations.size());
  EXPECT_NEAR(squares / count, 1.0, 4.0 * std::sqrt(2.0 / count));
  EXPECT_EQ(machine.calibrations.size(), 522u);  // every week of ten years
}

TEST(MachineYears, StepsHaveTheirSizesAndDistances) {
  int steps = 0;
  for (int number = 0; number < 30; ++number) {
    const MachineYears machine = DrawMachineYears(Clean(4), number);
    const Eigen::LLT<Eigen::MatrixXd> root(machine.plans[0].covariance);
    for (size_t i = 1; i < machine.truth.size(); ++i) {
      Eigen::VectorXd moved = machine.truth[i] - machine.truth[i - 1];
      int here = 0;
      for (const TrueStep& step : machine.steps) {
        if (step.by != static_cast<int>(i)) continue;
        ++here;
        Eigen::VectorXd size = Eigen::VectorXd::Zero(13);
        for (size_t k = 0; k < step.errors.size(); ++k) size(step.errors[k]) = step.sizes[k];
        EXPECT_NEAR(std::sqrt(size.dot(root.solve(size))), step.distance, 1e-9 * step.distance);
        moved -= size;
      }
      steps += here;
      EXPECT_LT(moved.cwiseAbs().maxCoeff(), 1e-9);  // and nothing else moves a clean machine
    }
  }
  EXPECT_NEAR(steps, 0.3 * 300, 4.0 * std::sqrt(90.0));
}

TEST(MachineYears, DisturbancesAreAsOftenAsDescribed) {
  YearsToDraw asked;
  asked.years = 5.0;
  int wears = 0, seasons = 0, recorded = 0, plans = 0, outliers = 0, calibrations = 0;
  constexpr int kMachines = 200;
  for (int number = 0; number < kMachines; ++number) {
    const MachineYears machine = DrawMachineYears(asked, number);
    const auto has = [&](auto member) {
      return std::any_of(machine.errors.begin(), machine.errors.end(),
                         [&](const auto& one) { return one.*member != 0.0; });
    };
    wears += has(&MachineYears::Error::wear_per_year);
    seasons += has(&MachineYears::Error::season);
    recorded += machine.is_temperature_recorded;
    plans += machine.plans.size() == 3;
    outliers += static_cast<int>(machine.outliers.size());
    calibrations += static_cast<int>(machine.calibrations.size());
    EXPECT_GE(machine.sigma_factor, 0.7);
    EXPECT_LE(machine.sigma_factor, 2.0);
    for (size_t i = 0; i < machine.calibrations.size(); ++i) {
      EXPECT_TRUE(drift::Check(machine.calibrations[i]).ok());
      EXPECT_EQ(machine.calibrations[i].values.size(), machine.plans[machine.plan_of[i]].errors.size());
      EXPECT_EQ(machine.calibrations[i].temperature_celsius.has_value(), machine.is_temperature_recorded);
      if (i > 0) {
        EXPECT_GT(machine.calibrations[i].at, machine.calibrations[i - 1].at);
      }
    }
  }
  const auto near = [](int count, double share, int of) {
    EXPECT_NEAR(count, share * of, 4.0 * std::sqrt(share * (1.0 - share) * of));
  };
  near(wears, 1.0 / 3.0, kMachines);
  near(seasons, 0.5, kMachines);
  near(recorded, 0.5, kMachines);
  near(plans, 0.5, kMachines);
  near(outliers, 0.01, calibrations);
  // 10 % are missing, and of what is left gaps of 8 weeks, 0.3 times a year.
  EXPECT_NEAR(calibrations, 0.9 * (1.0 - 0.3 * 8.0 / 52.2) * 261 * kMachines, 0.01 * 261 * kMachines);
}

TEST(MachineYears, AMachineDoesNotDependOnTheOthers) {
  YearsToDraw asked;
  asked.years = 1.0;
  asked.seed = 9;
  EXPECT_EQ(HistoryLines(DrawMachineYears(asked, 4)), HistoryLines(DrawMachineYears(asked, 4)));
  std::string fourth = HistoryLines(DrawMachineYears(asked, 3)), fifth = HistoryLines(DrawMachineYears(asked, 4));
  EXPECT_THAT(fifth, HasSubstr("\"machine\": \"m00005\""));
  EXPECT_NE(fourth.substr(fourth.find('\n')), fifth.substr(fifth.find('\n')));
  asked.seed = 10;
  EXPECT_NE(HistoryLines(DrawMachineYears(asked, 4)), fifth);
}

TEST(MachineYears, RefusesWhatIsNoHistory) {
  YearsToDraw asked;
  asked.years = 0.0;
  EXPECT_THAT(std::string(Check(asked).message()), HasSubstr("years = 0, must be 0.1 to 50"));
  asked.years = 1.0;
  asked.interval_days = NAN;
  EXPECT_THAT(std::string(Check(asked).message()), HasSubstr("interval_days = nan, must be 0.5 to 60"));
}

}  // namespace
}  // namespace axiscal::synthetic
