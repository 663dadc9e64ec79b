#include "core/information/choice.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <random>

#include "core/information/smallest_set.h"

namespace axiscal::information {
namespace {

TestInformation OfReadings(const Eigen::MatrixXd& whitened) { return {OfRows(whitened), OfRows(whitened)}; }

TestInformation Sum(const std::vector<TestInformation>& tests, const std::vector<int>& set) {
  TestInformation sum = tests[set[0]];
  for (size_t i = 1; i < set.size(); ++i) sum += tests[set[i]];
  return sum;
}

// `count` tests of `rows` readings each about `unknowns`, not all of the same weight.
std::vector<TestInformation> Drawn(int count, int rows, int unknowns, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<TestInformation> tests;
  for (int i = 0; i < count; ++i) {
    const double weight = 1.0 + i % 3;
    tests.push_back(OfReadings(Eigen::MatrixXd::NullaryExpr(rows, unknowns, [&] { return weight * normal(random); })));
  }
  return tests;
}

// Of all sets: the fewest tests that determine as much as all do, then the least determinant by an LU decomposition.
struct Brute {
  std::vector<int> tests;
  double log_determinant = INFINITY;
};
Brute BruteForce(const std::vector<TestInformation>& tests, const std::vector<int>& asked) {
  const int count = static_cast<int>(tests.size());
  Brute best;
  size_t fewest = tests.size() + 1;
  for (unsigned mask = 1; mask < 1u << count; ++mask) {
    std::vector<int> set;
    for (int i = 0; i < count; ++i) {
      if (mask >> i & 1u) set.push_back(i);
    }
    const Eigen::MatrixXd gram = Sum(tests, set).informing.matrix;
    const Eigen::FullPivLU<Eigen::MatrixXd> lu(gram);
    if (!lu.isInvertible() || set.size() > fewest) continue;
    const Eigen::MatrixXd inverse = lu.inverse();
    const double log_determinant = std::log(Eigen::MatrixXd(inverse(asked, asked)).determinant());
    if (set.size() == fewest && log_determinant >= best.log_determinant) continue;
    fewest = set.size();
    best = {set, log_determinant};
  }
  return best;
}

TEST(ChooseTests, OneOrTwoTestsAreTheBestOfAllSets) {
  for (uint32_t seed = 1; seed <= 20; ++seed) {
    const int rows = seed % 2 == 0 ? 2 : 4;  // two tests are needed, or one
    const std::vector<TestInformation> tests = Drawn(8, rows, 4, seed);
    const std::vector<int> asked = {0, 2, 3};
    const Choice choice = ChooseTests(tests, asked);
    const Brute brute = BruteForce(tests, asked);
    ASSERT_EQ(brute.tests.size(), rows == 2 ? 2u : 1u);
    EXPECT_EQ(choice.tests, brute.tests) << seed;
    EXPECT_TRUE(choice.told.Undetermined().empty());
    const Eigen::MatrixXd covariance = Sum(tests, brute.tests).informing.matrix.inverse();
    for (size_t i = 0; i < asked.size(); ++i)
      EXPECT_NEAR(choice.told.sigma[i], std::sqrt(covariance(asked[i], asked[i])), 1e-9 * choice.told.sigma[i]);
  }
}

// Sets of four of nine: as small as any, and mostly the very best.
TEST(ChooseTests, LargerSetsAreAsSmallAsBruteForceAndMostlyAsGood) {
  int best = 0;
  constexpr int kCases = 20;
  for (uint32_t seed = 1; seed <= kCases; ++seed) {
    const std::vector<TestInformation> tests = Drawn(9, 1, 4, 100 + seed);
    const Choice choice = ChooseTests(tests, {0, 1, 2, 3});
    const Brute brute = BruteForce(tests, {0, 1, 2, 3});
    ASSERT_EQ(brute.tests.size(), 4u);
    EXPECT_EQ(choice.tests.size(), 4u) << seed;
    EXPECT_EQ(choice.told.determined_count, 4);
    std::vector<int> sorted = choice.tests;
    std::sort(sorted.begin(), sorted.end());
    best += sorted == brute.tests;
  }
  EXPECT_GE(best, 0.8 * kCases);
}

// Unknowns 1 and 2 show by their sum alone, whatever is measured; the others are told and chosen for.
TEST(ChooseTests, WhatNoSetDeterminesIsSaid) {
  std::vector<TestInformation> tests = Drawn(6, 2, 4, 3);
  for (TestInformation& test : tests) {
    Eigen::MatrixXd from = Eigen::MatrixXd::Identity(4, 4);
    from.col(2) = from.col(1);
    for (Information* information : {&test.identifying, &test.informing}) {
      information->matrix = (from.transpose() * information->matrix * from).eval();
      information->norm2 = information->matrix.diagonal();
    }
  }
  const Choice choice = ChooseTests(tests, {0, 1, 2, 3});
  EXPECT_EQ(choice.tests.size(), 2u);
  EXPECT_EQ(choice.told.Undetermined(), (std::vector<int>{1, 2}));
  EXPECT_EQ(choice.told.determined_count, 2);
  EXPECT_TRUE(std::isnan(choice.told.sigma[1]) && std::isnan(choice.told.sigma[2]));
  EXPECT_GT(choice.told.sigma[0], 0.0);
  const Choice nothing = ChooseTests(tests, {1, 2});
  EXPECT_TRUE(nothing.tests.empty());
  EXPECT_EQ(nothing.told.Undetermined(), (std::vector<int>{0, 1}));
}

TEST(ChooseTests, WithoutTestsNothingIsTold) {
  const Choice choice = ChooseTests({}, {0, 1});
  EXPECT_TRUE(choice.tests.empty());
  EXPECT_EQ(choice.told.Undetermined(), (std::vector<int>{0, 1}));
  EXPECT_TRUE(std::isnan(choice.told.sigma[0]));
}

// What is stated beforehand sharpens a number and makes none.
TEST(Tell, PriorsInformAndDoNotIdentify) {
  Eigen::MatrixXd rows(2, 2);
  rows << 1, 1, 2, 2;
  TestInformation test = OfReadings(rows);
  test.informing.matrix += Eigen::Vector2d(1.0, 9.0).asDiagonal();
  const Told told = Tell(test, {0, 1});
  EXPECT_EQ(told.Undetermined(), (std::vector<int>{0, 1}));
  rows << 1, 1, 2, 0;
  test = OfReadings(rows);
  const Told alone = Tell(test, {0, 1});
  test.informing.matrix += Eigen::Vector2d(0.0, 9.0).asDiagonal();
  const Told with = Tell(test, {0, 1});
  EXPECT_TRUE(with.Undetermined().empty());
  EXPECT_NEAR(alone.sigma[0], 0.5, 1e-12);
  EXPECT_LT(with.sigma[1], alone.sigma[1]);
  EXPECT_TRUE(with.IsBetterThan(alone));
  EXPECT_FALSE(with.TellsLessThan(alone));
}

// Judged by something else than a determinant: numbers that a set adds up to, at least 10, the most equal ones.
struct Weight {
  int sum = 0, largest = 0;
  bool TellsLessThan(const Weight& other) const { return std::min(sum, 10) < std::min(other.sum, 10); }
  bool IsBetterThan(const Weight& other) const {
    return other.TellsLessThan(*this) || (!TellsLessThan(other) && largest < other.largest);
  }
};

TEST(SmallestSet, TakesAnyVerdict) {
  const std::vector<int> weights = {1, 8, 4, 5, 2, 3, 6};
  const auto judge = [&](const std::vector<int>& set) {
    Weight weight;
    for (const int i : set) {
      weight.sum += weights[i];
      weight.largest = std::max(weight.largest, weights[i]);
    }
    return weight;
  };
  const auto chosen = SmallestSet(static_cast<int>(weights.size()), judge);
  EXPECT_EQ(chosen.tests, (std::vector<int>{2, 6}));  // 4 + 6, not 8 + anything
  EXPECT_EQ(chosen.verdict.sum, 10);
}

}  // namespace
}  // namespace axiscal::information
