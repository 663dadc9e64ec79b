#include "core/objective/scorer.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>

#include "core/objective/testing/dense_source.h"
#include "core/objective/testing/made_rows.h"

namespace axiscal::objective {
namespace {

constexpr double kTolerance = 1e-5;  // ridges of 1e-10 of a column's squares, times 600 rows

Eigen::MatrixXd Beyond(const Rows& rows, const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd nuisance = Eigen::MatrixXd::Zero(kRows, kSessions + 3);
  for (int s = 0; s < kSessions; ++s)
    nuisance.block(s * kSessionRows, s, kSessionRows, 1) = rows.own.middleRows(s * kSessionRows, kSessionRows);
  nuisance.rightCols(3) = rows.common;
  return columns - nuisance * nuisance.colPivHouseholderQr().solve(columns);
}

// A harmonic pair each, then the smooth curve of the same orders as a block.
std::vector<std::unique_ptr<Source>> PairsAndCurve(int orders) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<DenseSource>(Harmonics(orders), 2, 0));
  Group curve;
  curve.family = 1;
  curve.columns = 2 * orders;
  curve.spectrum.resize(2 * orders);
  for (int n = 1; n <= orders; ++n) curve.spectrum.segment(2 * n - 2, 2).setConstant(1.0 / (1.0 + n * n));
  sources.push_back(std::make_unique<DenseSource>(Harmonics(orders), std::vector<Group>{curve}));
  return sources;
}

// The objective as it is defined, with dense matrices of all rows: the marginal likelihood of the blocks given flat
// effects.
TEST(Scorer, TheObjectiveIsTheOneThatIsDefined) {
  Rows rows = MakeRows(11);
  constexpr int kOrders = 6, kCurve = kOrders;
  constexpr double kDesign = 1.7, kVariance = 0.3;
  const Policy policy;
  Scorer scorer(rows, PairsAndCurve(kOrders), policy);
  const State state = {{kCurve, kVariance}, {2, 0.0}};
  const Score score = scorer.ScoreOf(state, kDesign);
  ASSERT_TRUE(score.is_possible);

  const Eigen::MatrixXd x = Beyond(rows, Harmonics(kOrders));
  const Eigen::VectorXd y = Beyond(rows, rows.y);
  const Eigen::MatrixXd flat = x.middleCols(4, 2);
  const Eigen::VectorXd left = y - flat * flat.colPivHouseholderQr().solve(y);
  const Eigen::MatrixXd block = x - flat * flat.colPivHouseholderQr().solve(x);
  Eigen::VectorXd variance(2 * kOrders);
  for (int n = 1; n <= kOrders; ++n) variance.segment(2 * n - 2, 2).setConstant(kVariance / (1.0 + n * n));
  const Eigen::MatrixXd covariance =
      Eigen::MatrixXd::Identity(kRows, kRows) + block * (variance / kDesign).asDiagonal() * block.transpose();
  const double squares = left.dot(covariance.partialPivLu().solve(left));
  const double dof = kRows - 3;
  const double log_det = (Eigen::MatrixXd::Identity(2 * kOrders, 2 * kOrders) +
                          block.transpose() * block * (variance / kDesign).asDiagonal())
                             .partialPivLu()
                             .determinant();
  const double prices = 2.0 * policy.evidence + policy.per_look * std::log(kOrders) + policy.per_column;
  EXPECT_NEAR(score.squares, squares, kTolerance);
  EXPECT_NEAR(score.objective, dof / kDesign * std::log(squares / dof) + std::log(log_det) + prices, kTolerance);
}

// The gains that one triangular solve gives for all groups at once are those of the enlarged states.
TEST(Scorer, AdditionsAreScoredAsTheEnlargedStatesAre) {
  Rows rows = MakeRows(12);
  rows.y += Harmonics(3).col(2) + 0.3 * Harmonics(3).col(4);
  Scorer scorer(rows, PairsAndCurve(5), Policy());
  for (const State& state : std::vector<State>{{}, {{1, 0.0}}, {{5, 0.05}}, {{1, 0.0}, {5, 0.05}, {3, 0.0}}}) {
    for (const double design : {1.0, 2.5}) {
      const std::vector<Move> moves = scorer.AdditionsWithin(state, design, 1e9);
      EXPECT_GE(moves.size() + state.size(), 5u);
      for (const Move& move : moves) {
        State more = state;
        more.push_back(move.member);
        EXPECT_NEAR(move.objective, scorer.ScoreOf(more, design).objective, kTolerance);
      }
    }
  }
}

// What is kept of a state serves it and what is left of it without any one member.
TEST(Scorer, AKeptStateGivesTheSameAdditionsWithoutAnyMember) {
  Rows rows = MakeRows(12);
  rows.y += Harmonics(3).col(2) + 0.3 * Harmonics(3).col(4);
  Scorer fresh(rows, PairsAndCurve(8), Policy()), kept(rows, PairsAndCurve(8), Policy());
  const State whole = {{1, 0.0}, {8, 0.05}, {3, 0.0}, {6, 0.0}};
  constexpr double kDesign = 1.4;
  kept.Keep(whole, kDesign);
  for (size_t gone = 0; gone <= whole.size(); ++gone) {
    State state = whole;
    if (gone < whole.size()) state.erase(state.begin() + static_cast<std::ptrdiff_t>(gone));
    const std::vector<Move> expected = fresh.AdditionsWithin(state, kDesign, 1e9);
    const std::vector<Move> moves = kept.AdditionsWithin(state, kDesign, 1e9);
    ASSERT_EQ(moves.size(), expected.size());
    for (size_t i = 0; i < moves.size(); ++i) {
      EXPECT_EQ(moves[i].member.group, expected[i].member.group);
      EXPECT_NEAR(moves[i].objective, expected[i].objective, kTolerance);
    }
  }
}

// An answer for more moves, or among more groups, serves where the one that is asked for follows from it.
TEST(Scorer, WhatWasAskedBeforeIsAnsweredAlike) {
  Rows rows = MakeRows(12);
  rows.y += Harmonics(3).col(2) + 0.3 * Harmonics(3).col(4) + 0.2 * Harmonics(6).col(11);
  Scorer known(rows, PairsAndCurve(8), Policy());
  const std::vector<bool> none;
  std::vector<bool> first_four(static_cast<size_t>(known.group_count()), false);
  std::fill_n(first_four.begin(), 4, true);
  std::vector<bool> pairs(static_cast<size_t>(known.group_count()), true);
  pairs.back() = false;
  for (const State& state : std::vector<State>{{}, {{1, 0.0}}, {{8, 0.05}}, {{1, 0.0}}}) {
    for (const int most : {3, 1, 20, 2}) {
      for (const std::vector<bool>& allowed : {none, first_four, pairs, none}) {
        const std::vector<Move> moves = known.Additions(state, 1.4, allowed, most);
        Scorer fresh(rows, PairsAndCurve(8), Policy());
        const std::vector<Move> expected = fresh.Additions(state, 1.4, allowed, most);
        ASSERT_EQ(moves.size(), expected.size());
        for (size_t i = 0; i < moves.size(); ++i) {
          EXPECT_EQ(moves[i].member.group, expected[i].member.group);
          EXPECT_NEAR(moves[i].objective, expected[i].objective, kTolerance);
        }
      }
    }
  }
}

TEST(Scorer, WhatTheNuisanceExplainsOrAPriorForbidsIsNoEffect) {
  Rows rows = MakeRows(13);
  Eigen::MatrixXd columns(kRows, 2);
  columns.col(0) = rows.common.col(1);
  columns.col(1) = Harmonics(1).col(0);
  rows.y += 5.0 * columns.col(1);
  std::vector<Group> groups(2);
  groups[1].largest_amplitude = 4.0;
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<DenseSource>(columns, groups));
  Scorer scorer(rows, std::move(sources), Policy());
  EXPECT_FALSE(scorer.IsVisible(0));
  EXPECT_TRUE(scorer.IsVisible(1));
  EXPECT_TRUE(scorer.Additions({}, 1.0, {}, 2).empty());
  EXPECT_FALSE(scorer.ScoreOf({{1, 0.0}}, 1.0).is_possible);
}

// Elements of one friction: none gives back what another takes.
TEST(Scorer, ThoseOfOneSignAreNoOpposites) {
  Rows rows = MakeRows(15);
  Eigen::MatrixXd columns(kRows, 2);
  columns << Harmonics(2).col(0), Harmonics(2).col(2);
  rows.y += 5.0 * columns.col(0) - 4.0 * columns.col(1);
  std::vector<Group> groups(2);
  for (int i = 0; i < 2; ++i) {
    groups[i].one_sign = 7;
  }
  const auto is_possible = [&](double sign) {
    columns.col(1) *= sign;
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::make_unique<DenseSource>(columns, groups));
    Scorer scorer(rows, std::move(sources), Policy());
    EXPECT_TRUE(scorer.ScoreOf({{1, 0.0}}, 1.0).is_possible);
    return scorer.ScoreOf({{0, 0.0}, {1, 0.0}}, 1.0).is_possible;
  };
  EXPECT_FALSE(is_possible(1.0));
  EXPECT_TRUE(is_possible(-1.0));
}

// Two columns of which one is the other: no state holds both.
TEST(Scorer, CombinationsOfEachOtherAreNoState) {
  Rows rows = MakeRows(14);
  Eigen::MatrixXd columns(kRows, 2);
  columns << Harmonics(1).col(0), 2.0 * Harmonics(1).col(0);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<DenseSource>(columns, 1, 0));
  Scorer scorer(rows, std::move(sources), Policy());
  EXPECT_TRUE(scorer.ScoreOf({{0, 0.0}}, 1.0).is_possible);
  EXPECT_FALSE(scorer.ScoreOf({{0, 0.0}, {1, 0.0}}, 1.0).is_possible);
  EXPECT_TRUE(scorer.Additions({{0, 0.0}}, 1.0, {}, 2).empty());
}

// A family pays for its looks, of which several alike members are one; what rounding may look like is the least that an
// effect pays, and no bad row.
TEST(Scorer, ThePriceCountsLooksAndIsNoLessThanRounding) {
  Rows rows = MakeRows(3);
  constexpr int kGroups = 16;
  Group one, alike, bad;
  one.columns = alike.columns = 2;
  alike.family = 1;
  alike.looks = 0.25;
  bad.family = 2;
  bad.is_counted = false;
  const Policy policy;
  constexpr double kDesign = 2.0;  // rounding that looks like an effect counts as any noise
  const auto price_of = [&](const Group& group) {
    std::vector<std::unique_ptr<Source>> sources;
    const Eigen::MatrixXd columns = Harmonics(kGroups).leftCols(kGroups * group.columns);
    sources.push_back(std::make_unique<DenseSource>(columns, std::vector<Group>(kGroups, group)));
    return Scorer(rows, std::move(sources), policy).PriceOf(0, kDesign);
  };
  EXPECT_DOUBLE_EQ(price_of(one), policy.evidence + policy.per_look * std::log(16.0) + policy.per_column);
  EXPECT_DOUBLE_EQ(price_of(alike), policy.evidence + policy.per_look * std::log(4.0) + policy.per_column);
  const double of_row = price_of(bad);
  rows.rounding_squares = 500.0;
  EXPECT_DOUBLE_EQ(price_of(one), 500.0 / kDesign);
  EXPECT_DOUBLE_EQ(price_of(bad), of_row);
}

}  // namespace
}  // namespace axiscal::objective
