#include "core/identify/outliers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace axiscal::identify {
namespace {

Eigen::VectorXd Noise(int count, double sigma) {
  std::mt19937 random(11);
  std::normal_distribution<double> normal(0.0, sigma);
  Eigen::VectorXd series(count);
  for (int i = 0; i < count; ++i) series[i] = normal(random);
  return series;
}

int Count(const std::vector<bool>& flags) { return static_cast<int>(std::count(flags.begin(), flags.end(), true)); }

TEST(Outliers, CleanNoiseIsLeftAlone) { EXPECT_EQ(Count(FindOutliers(Noise(20000, 1.0), 0.0)), 0); }

TEST(Outliers, SingleBadReadingsAreFoundAtTheirPlaceAlsoOnASlope) {
  Eigen::VectorXd series = Noise(500, 1.0);
  for (int i = 0; i < 500; ++i) series[i] += 40.0 * std::sin(0.02 * i);
  series[100] += 20.0;
  series[0] -= 25.0;
  series[499] += 30.0;
  const std::vector<bool> found = FindOutliers(series, 0.0);
  EXPECT_TRUE(found[0] && found[100] && found[499]);
  EXPECT_EQ(Count(found), 3);
}

TEST(Outliers, ReadingsThatStandOutTogetherAreStructure) {
  Eigen::VectorXd series = Noise(500, 1.0);
  for (int i = 200; i < 204; ++i) series[i] += 50.0;
  EXPECT_EQ(Count(FindOutliers(series, 0.0)), 0);
}

TEST(Outliers, AQuantisedSeriesHasAFloorUnderItsScale) {
  Eigen::VectorXd series = Eigen::VectorXd::Zero(100);
  series[50] = 0.1;  // one digit of the display
  EXPECT_EQ(Count(FindOutliers(series, 0.05)), 0);
  EXPECT_EQ(Count(FindOutliers(series, 0.0)), 1);
}

// A dozen poses of an R-test have no running median; a chip still stands out of them, a pose among two groups does not.
TEST(Outliers, AShortSeriesIsJudgedByItsOwnMedian) {
  Eigen::VectorXd series = Noise(12, 1.0);
  EXPECT_EQ(Count(FindOutliers(series, 0.0)), 0);
  series[4] = 30.0;
  const std::vector<bool> found = FindOutliers(series, 0.0);
  EXPECT_TRUE(found[4]);
  EXPECT_EQ(Count(found), 1);
  for (int i = 0; i < 12; ++i) series[i] = i % 2 == 0 ? 20.0 : -20.0;
  EXPECT_EQ(Count(FindOutliers(series, 0.0)), 0);
}

TEST(Outliers, AHandfulOfReadingsCannotTell) {
  Eigen::VectorXd series = Noise(7, 1.0);
  series[4] = 100.0;
  EXPECT_EQ(Count(FindOutliers(series, 0.0)), 0);
}

// The slow obvious twin sorts every window anew.
TEST(Outliers, RunningMedian) {
  for (const int count : {1, 2, 4, 9, 200}) {
    Eigen::VectorXd series = Noise(count, 1.0);
    for (int i = 0; i < count; i += 3) series[i] = 0.5;  // equal values
    for (const int half_window : {1, 5}) {
      const Eigen::VectorXd off = OffRunningMedian(series, half_window);
      for (int k = 0; k < count; ++k) {
        std::vector<double> neighbours;
        for (int i = std::max(0, k - half_window); i <= std::min(count - 1, k + half_window); ++i) {
          if (i != k) neighbours.push_back(series[i]);
        }
        EXPECT_EQ(off[k], series[k] - Median(&neighbours)) << count << ' ' << half_window << ' ' << k;
      }
    }
  }
}

TEST(Outliers, MedianAndRobustSigma) {
  std::vector<double> even = {4, 1, 3, 2}, none;
  EXPECT_EQ(Median(&even), 2.5);
  EXPECT_EQ(Median(&none), 0.0);
  EXPECT_NEAR(RobustSigma(Noise(20000, 2.0)), 2.0, 0.04);  // 1.17 / sqrt(20000) relative, 2.4 sigma
}

}  // namespace
}  // namespace axiscal::identify
