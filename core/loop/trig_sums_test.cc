#include "core/loop/trig_sums.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

namespace axiscal::loop {
namespace {

void ExpectPlainSums(const Eigen::ArrayXd& positions, double first, double step, int count) {
  Eigen::MatrixXd strengths = Eigen::MatrixXd::Random(positions.size(), 2);
  strengths.col(1).array() += 5.0;
  const Eigen::MatrixXcd sums = TrigSums(positions, first, step, count).Of(strengths);
  ASSERT_EQ(sums.rows(), count);
  for (Eigen::Index column = 0; column < 2; ++column) {
    const double magnitude = strengths.col(column).cwiseAbs().sum();
    for (int m = 0; m < count; ++m) {
      std::complex<double> plain = 0.0;
      for (Eigen::Index k = 0; k < positions.size(); ++k)
        plain += strengths(k, column) * std::polar(1.0, (first + m * step) * positions[k]);
      EXPECT_LT(std::abs(sums(m, column) - plain), 1e-6 * magnitude) << "frequency " << m << " of " << count;
    }
  }
}

TEST(TrigSums, OrdersOfATurnAsThePlainSums) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> turn(-3.0 * M_PI, 9.0);
  Eigen::ArrayXd positions(300);
  for (double& one : positions) one = turn(random);
  ExpectPlainSums(positions, 5.0, 1.0, 716);
}

TEST(TrigSums, PitchesOfALinearAxisAsThePlainSums) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> along(-400.0, 250.0);
  Eigen::ArrayXd positions(200);
  for (double& one : positions) one = along(random);
  const double turn = 2.0 * M_PI / 650.0;
  ExpectPlainSums(positions, 3.0 * turn, turn / 3.0, 292);
}

TEST(TrigSums, FewFrequenciesAndReadingsAsThePlainSums) {
  for (const int count : {1, 2, 3, 7}) {
    ExpectPlainSums(Eigen::ArrayXd::LinSpaced(1, 0.3, 0.3), 2.0, 1.0, count);
    ExpectPlainSums(Eigen::ArrayXd::LinSpaced(40, 0.0, 2.0 * M_PI), 2.0, 1.0, count);
  }
}

}  // namespace
}  // namespace axiscal::loop
