// The outlook's models against the joint normal distribution of all values, written out; banks of rates likewise.
#include "core/drift/outlook.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/base/random.h"
#include "core/drift/rate_bank.h"

namespace axiscal::drift {
namespace {

constexpr double kStart = 2.0, kStartVariance = 1e4;
const std::vector<double> kWeeks = {0.0, 1.0, 2.5, 6.0, 7.0, 11.0};
const std::vector<double> kValues = {2.3, 1.8, 2.9, 2.1, 3.0, 2.6};
const std::vector<double> kVariances = {1.0, 1.0, 2.0, 1.0, 1.5, 1.0};

Regressors At(double week) { return {1.0, std::sin(0.12 * week), std::cos(0.12 * week), 0.0}; }

// Covariance of the level with its season at two weeks under a model.
double Covariance(int model, double a, double b) {
  const double rate = kOutlookRates[RateIndex(model)], slope = kSlopeSizes[SlopeIndex(model)],
               season = kSeasonSizes[SeasonIndex(model)];
  return kStartVariance + rate * rate * std::min(a, b) + slope * slope * a * b +
         season * season * (At(a)[1] * At(b)[1] + At(a)[2] * At(b)[2]);
}

TEST(Outlook, IsTheJointNormalDistribution) {
  Outlook outlook = StartOutlook(0.0, kStart, kStartVariance);
  const auto count = static_cast<int>(kWeeks.size());
  for (int i = 0; i < count; ++i) Absorb(kWeeks[i], At(kWeeks[i]), kValues[i], kVariances[i], &outlook);
  EXPECT_EQ(outlook.count, count - 1);  // the first only says where the error is
  for (int model = 0; model < kModels; ++model) {
    Eigen::MatrixXd all(count, count);
    Eigen::VectorXd off(count), ahead(count);
    const double then = 30.0;
    for (int i = 0; i < count; ++i) {
      off(i) = kValues[i] - kStart;
      ahead(i) = Covariance(model, kWeeks[i], then);
      for (int j = 0; j < count; ++j) all(i, j) = Covariance(model, kWeeks[i], kWeeks[j]) + (i == j) * kVariances[i];
    }
    const double squares = off.dot(all.inverse() * off) - off(0) * off(0) / all(0, 0);
    EXPECT_NEAR(outlook.models[model].squares, squares, 1e-6);
    EXPECT_NEAR(outlook.models[model].log_determinant, std::log(all.determinant()) - std::log(all(0, 0)), 1e-6);
    const Ahead told = LookAhead(outlook, model, then - kWeeks.back(), At(then));
    EXPECT_NEAR(told.mean, kStart + ahead.dot(all.inverse() * off), 1e-6);
    EXPECT_NEAR(told.variance, Covariance(model, then, then) - ahead.dot(all.inverse() * ahead), 1e-5);
  }
}

TEST(Outlook, WeightsArePriorTimesStudentEvidence) {
  Outlook outlook = StartOutlook(0.0, kStart, kStartVariance);
  for (size_t i = 0; i < kWeeks.size(); ++i) Absorb(kWeeks[i], At(kWeeks[i]), kValues[i], kVariances[i], &outlook);
  const ModelWeights weights = WeightsOf(outlook, FlatPrior());
  double sum = 0.0, prior = 0.0;
  for (int k = 0; k < kModels; ++k) sum += weights[k], prior += FlatPrior()[k];
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_NEAR(prior, 1.0, 1e-12);
  const OutlookModel &a = outlook.models[0], &b = outlook.models[29];
  // Scale integrated out under an inverse gamma prior of 12 / 2 and 12 * 1.44 / 2.
  const double odds = FlatPrior()[0] / FlatPrior()[29] * std::exp(0.5 * (b.log_determinant - a.log_determinant)) *
                      std::pow((17.28 + b.squares) / (17.28 + a.squares), 0.5 * (12.0 + outlook.count));
  EXPECT_NEAR(weights[0] / weights[29], odds, 1e-9 * odds);
}

TEST(Outlook, OneWildValueHardlyMovesIt) {
  Outlook outlook = StartOutlook(0.0, 0.0, kStartVariance);
  for (int week = 0; week < 50; ++week) Absorb(week, At(week), week % 2 == 0 ? 0.5 : -0.5, 1.0, &outlook);
  Absorb(50.0, At(50.0), 1000.0, 1.0, &outlook);
  EXPECT_LT(std::abs(outlook.models[0].mean[0]), 1.0);
  EXPECT_LT(ScaleOf(outlook, 0), 2.0);
}

TEST(Outlook, AnotherUnitIsTheSameOutlook) {
  Outlook fine = StartOutlook(0.0, kStart, kStartVariance),
          coarse = StartOutlook(0.0, kStart / 4.0, kStartVariance / 16.0);
  for (size_t i = 0; i < 3; ++i) {
    Absorb(kWeeks[i], At(kWeeks[i]), kValues[i], kVariances[i], &fine);
    Absorb(kWeeks[i], At(kWeeks[i]), kValues[i] / 4.0, kVariances[i] / 16.0, &coarse);
  }
  Rescale(4.0, &fine);
  // Of the model that neither wanders, wears nor knows a season: the sizes of the others are in units.
  EXPECT_NEAR(fine.models[0].mean[0], coarse.models[0].mean[0], 1e-12);
  EXPECT_NEAR(fine.models[0].covariance[0], coarse.models[0].covariance[0], 1e-12);
}

TEST(RateBank, WithoutWanderingItIsTheWeighedMean) {
  RateBank bank;
  Restart(0.0, &bank);
  double sum = 0.0, weight = 1.0 / kStartVariance;
  for (size_t i = 0; i < kWeeks.size(); ++i) {
    Absorb(kValues[i], kVariances[i], i == 0 ? 0.0 : kWeeks[i] - kWeeks[i - 1], &bank);
    sum += kValues[i] / kVariances[i];
    weight += 1.0 / kVariances[i];
  }
  EXPECT_NEAR(bank.mean[0], sum / weight, 1e-9);
  EXPECT_NEAR(bank.variance[0], 1.0 / weight, 1e-9);
  EXPECT_GT(bank.variance[4], bank.variance[0]);
}

// Relative accuracy of a scale from 400 values is sqrt(2 / 400) = 0.07; four of them.
constexpr double kScaleTolerance = 0.28;

TEST(RateBank, LearnsTheScatterAndTheRate) {
  base::Random random(5);
  RateBank still, wandering;
  Restart(0.0, &still);
  Restart(0.0, &wandering);
  EXPECT_DOUBLE_EQ(ScaleOf(still), 1.44);
  double level = 0.0;
  for (int week = 0; week < 1500; ++week) {
    level += 2.0 * 0.3 * random.Normal();
    Absorb(2.0 * random.Normal(), 1.0, 1.0, &still);
    Absorb(level + 2.0 * random.Normal(), 1.0, 1.0, &wandering);
  }
  EXPECT_NEAR(ScaleOf(still), 4.0, 4.0 * kScaleTolerance);
  EXPECT_NEAR(ScaleOf(wandering), 4.0, 4.0 * kScaleTolerance);
  EXPECT_LT(SquaredRateOf(still), 0.02 * 0.02);
  EXPECT_NEAR(SquaredRateOf(wandering), 0.3 * 0.3, 0.05 * 0.05);
}

}  // namespace
}  // namespace axiscal::drift
