#include "core/objective/search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/objective/moments.h"
#include "core/objective/testing/dense_source.h"
#include "core/objective/testing/made_rows.h"

namespace axiscal::objective {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

constexpr int kOrders = 40, kRandom = 200;

// 40 harmonics, then 200 random columns of another family.
std::vector<std::unique_ptr<Source>> Dictionary(std::mt19937* random) {
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<DenseSource>(Harmonics(kOrders), 2, 0));
  sources.push_back(std::make_unique<DenseSource>(Gaussian(kRows, kRandom, random), 1, 1));
  return sources;
}

Found SearchAll(Scorer* scorer, const std::vector<Start>& starts = {{}}) {
  const DesignEffect design(*scorer);
  return Searcher(scorer, &design).Search(starts);
}

std::vector<int> GroupsOf(const Found& found) {
  std::vector<int> groups;
  for (const Member& one : found.state) groups.push_back(one.group);
  return groups;
}

// Seeds whose state is not empty, of `count`.
int NamedOfNothing(int count, const std::function<void(Rows*, std::mt19937*)>& disturb) {
  int named = 0;
  for (int seed = 0; seed < count; ++seed) {
    std::mt19937 random(1000 + seed);
    Rows rows = MakeRows(seed);
    disturb(&rows, &random);
    Scorer scorer(rows, Dictionary(&random), Policy());
    named += !SearchAll(&scorer).state.empty();
  }
  return named;
}

TEST(Search, NothingIsFoundWhereNothingIs) {
  EXPECT_LE(NamedOfNothing(150, [](Rows*, std::mt19937*) {}), 1);
  // The scale of the noise does not matter.
  EXPECT_LE(NamedOfNothing(50, [](Rows* rows, std::mt19937*) { rows->y *= 7.0; }), 1);
}

// What the rows of a cluster share is no effect; who takes rows for independent names it. More than half of the
// variance is common to chunks of 15 rows.
TEST(Search, NoiseThatClustersShareIsNoEffect) {
  constexpr int kSeeds = 40;
  const auto disturb = [](Rows* rows, std::mt19937* random) {
    std::normal_distribution<double> normal;
    double common = 0.0;
    for (int i = 0; i < kRows; ++i) {
      if (i == 0 || rows->clusterings[0][i] != rows->clusterings[0][i - 1]) common = 1.2 * normal(*random);
      rows->y[i] += common;
    }
  };
  EXPECT_LE(NamedOfNothing(kSeeds, disturb), 2);
  const auto and_hide = [&](Rows* rows, std::mt19937* random) {
    disturb(rows, random);
    rows->clusterings.clear();
  };
  EXPECT_GE(NamedOfNothing(kSeeds, and_hide), kSeeds / 2);
}

TEST(Search, OneEffectAndTwoAreFoundAndNothingBeside) {
  int right = 0, in_all = 0;
  for (int seed = 0; seed < 40; ++seed) {
    std::mt19937 random(2000 + seed);
    Rows rows = MakeRows(100 + seed);
    std::vector<std::unique_ptr<Source>> sources = Dictionary(&random);
    std::vector<int> truth = {seed % kOrders};
    rows.y += 0.5 * sources[0]->Columns(truth[0]).col(seed % 2);
    if (seed % 2 == 0) {
      truth.push_back(kOrders + 7);
      rows.y += 0.4 * sources[1]->Columns(7);
    }
    Scorer scorer(rows, std::move(sources), Policy());
    std::vector<int> found = GroupsOf(SearchAll(&scorer));
    std::sort(found.begin(), found.end());
    right += found == truth;
    ++in_all;
  }
  EXPECT_GE(right, in_all - 1);
}

// Ten times the noise: what is left of the rows before it is found goes together in every cluster, so that D is large.
TEST(Search, AStrongEffectDoesNotHideItselfBehindTheDesignEffectThatItCauses) {
  for (const double size : {0.6, 1.5, 15.0}) {
    std::mt19937 random(3000);
    Rows rows = MakeRows(200);
    rows.y += size * Harmonics(kOrders).col(2);
    Scorer scorer(rows, Dictionary(&random), Policy());
    const Found found = SearchAll(&scorer);
    EXPECT_THAT(GroupsOf(found), ElementsAre(1)) << size;
    EXPECT_LT(found.design, 1.3);
  }
}

// Members of scans that are projected only where they may matter: the same states at the same objective.
TEST(Search, AScanIsSearchedAsIfAllOfItWereProjected) {
  for (int seed = 0; seed < 20; ++seed) {
    Found found[2];
    for (const bool is_scan : {false, true}) {
      std::mt19937 random(2500 + seed);
      Rows rows = MakeRows(150 + seed);
      const Eigen::MatrixXd others = Gaussian(kRows, kRandom, &random);
      // A common column that takes up most of an order.
      rows.common.col(1) = Harmonics(kOrders).col(8) + 0.5 * rows.common.col(1);
      if (seed % 3 > 0) rows.y += 0.6 * Harmonics(kOrders).col(8 + seed % 2) + 0.4 * others.col(5);
      std::vector<std::unique_ptr<Source>> sources;
      sources.push_back(std::make_unique<DenseSource>(Harmonics(kOrders), 2, 0, is_scan));
      sources.push_back(std::make_unique<DenseSource>(others, 1, 1, is_scan));
      Scorer scorer(rows, std::move(sources), Policy());
      found[is_scan] = SearchAll(&scorer);
    }
    EXPECT_EQ(GroupsOf(found[0]), GroupsOf(found[1])) << seed;
    EXPECT_NEAR(found[0].objective, found[1].objective, 1e-6);
  }
}

// Nearly the same column, and one that is nothing like it.
TEST(Search, LookAlikesAreAClass) {
  std::mt19937 random(4000);
  Rows rows = MakeRows(300);
  Eigen::MatrixXd columns = Gaussian(kRows, 30, &random);
  columns.col(4) = columns.col(3) + 0.02 * Gaussian(kRows, 1, &random);
  rows.y += columns.col(3);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<DenseSource>(columns, 1, 0));
  Scorer scorer(rows, std::move(sources), Policy());
  const DesignEffect design(scorer);
  Searcher searcher(&scorer, &design);
  const Found found = searcher.Search({{}});
  ASSERT_EQ(found.state.size(), 1u);
  std::vector<int> alike = {found.state[0].group};
  const std::vector<std::vector<Move>> classes = searcher.ClassesOf(found);
  for (const Move& move : classes[0]) alike.push_back(move.member.group);
  EXPECT_THAT(alike, UnorderedElementsAre(3, 4));
}

// The sum of two effects that stand alone as well explains nearly all that both do, and comes first; it must leave.
TEST(Search, WhatCameFirstLeavesForTheTwoThatItStoodFor) {
  std::mt19937 random(5000);
  Rows rows = MakeRows(400);
  Eigen::MatrixXd columns = Gaussian(kRows, 40, &random);
  columns.col(9) = columns.col(3) + columns.col(4) + 0.4 * Gaussian(kRows, 1, &random);
  rows.y += columns.col(3) + columns.col(4);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<DenseSource>(columns, 1, 0));
  Scorer scorer(rows, std::move(sources), Policy());
  ASSERT_EQ(scorer.Additions({}, 1.0, {}, 1)[0].member.group, 9);
  EXPECT_THAT(GroupsOf(SearchAll(&scorer)), UnorderedElementsAre(3, 4));
}

// A curve of many orders is one effect, not many; one order alone is that order.
TEST(Search, ACurveIsOneEffectAndAnOrderIsThatOrder) {
  constexpr int kCurveOrders = 15;
  std::mt19937 random(6000);
  std::normal_distribution<double> normal;
  Group curve;
  curve.family = 1;
  curve.columns = 2 * kCurveOrders;
  curve.spectrum.resize(2 * kCurveOrders);
  for (int n = 1; n <= kCurveOrders; ++n)
    curve.spectrum.segment(2 * n - 2, 2).setConstant(1.0 / (1.0 + std::pow(n / 3.0, 2)));
  for (const bool is_curve : {true, false}) {
    Rows rows = MakeRows(500);
    for (int c = 0; c < 2 * kCurveOrders; ++c) {
      const double size = is_curve ? std::sqrt(curve.spectrum[c]) * normal(random) : (c == 8 ? 0.6 : 0.0);
      rows.y += size * Harmonics(kCurveOrders).col(c);
    }
    std::vector<std::unique_ptr<Source>> sources;
    sources.push_back(std::make_unique<DenseSource>(Harmonics(kCurveOrders), 2, 0));
    sources.push_back(std::make_unique<DenseSource>(Harmonics(kCurveOrders), std::vector<Group>{curve}));
    Scorer scorer(rows, std::move(sources), Policy());
    EXPECT_THAT(GroupsOf(SearchAll(&scorer)), ElementsAre(is_curve ? kCurveOrders : 4));
  }
}

// A slip and bad rows in one state with an effect, where each alone would be explained by the others in part.
TEST(Search, ASlipAndBadRowsAreMembersLikeOthers) {
  std::mt19937 random(7000);
  Rows rows = MakeRows(600, 0.5);
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::make_unique<DenseSource>(Harmonics(kOrders), 2, 0));
  Slips::Series series{kSessionRows, 2 * kSessionRows, {}};
  for (int moment = 6; moment < kSessionRows - 6; ++moment) series.first.push_back(kSessionRows + moment);
  Group slip, row;
  slip.family = 1;
  slip.precision = Eigen::VectorXd::Constant(1, 1e-4);
  slip.kin = 0;
  slip.apart = 6.0;
  sources.push_back(
      std::make_unique<Slips>(kRows, std::vector<Slips::Series>{series}, Eigen::MatrixXd::Ones(kSessionRows, 1), slip));
  row.family = 2;
  std::vector<int> all(kRows);
  for (int i = 0; i < kRows; ++i) all[i] = i;
  sources.push_back(std::make_unique<SingleRows>(kRows, all, row));
  constexpr int kMoment = 60, kSlip = kOrders + kMoment - 6, kBad = 33, kOther = 500;
  const int first_row = kOrders + static_cast<int>(series.first.size());
  // Noise of the kind that the whitening is for: white after it.
  Eigen::MatrixXd signal = 0.8 * sources[0]->Columns(2).col(0) + 3.0 * sources[1]->Columns(kMoment - 6);
  signal(kBad, 0) += 9.0;
  signal(kOther, 0) += 9.0;
  rows.whitening.Apply(0, signal);
  rows.y += signal;
  Scorer scorer(rows, std::move(sources), Policy());
  const Found found = SearchAll(&scorer);
  EXPECT_THAT(GroupsOf(found), UnorderedElementsAre(2, kSlip, first_row + kBad, first_row + kOther));
}

// A start that leaves a family out at first ends with it where it is needed.
TEST(Search, StartsByFamiliesEndWithAllFamilies) {
  std::mt19937 random(8000);
  Rows rows = MakeRows(700);
  std::vector<std::unique_ptr<Source>> sources = Dictionary(&random);
  rows.y += 0.6 * sources[0]->Columns(3).col(0) + 0.6 * sources[1]->Columns(5);
  Scorer scorer(rows, std::move(sources), Policy());
  EXPECT_THAT(GroupsOf(SearchAll(&scorer, {{{}, {0}}})), UnorderedElementsAre(3, kOrders + 5));
}

// A search that is cancelled before its first step ends where it began.
TEST(Search, ACancelledSearchEndsWithItsStart) {
  std::mt19937 random(8100);
  Rows rows = MakeRows(700);
  std::vector<std::unique_ptr<Source>> sources = Dictionary(&random);
  rows.y += 0.6 * sources[0]->Columns(3).col(0);
  Scorer scorer(rows, std::move(sources), Policy());
  const DesignEffect design(scorer);
  Searcher searcher(&scorer, &design, [] { return true; });
  EXPECT_THAT(GroupsOf(searcher.Search({{{{5, 0.0}}, {}}})), ElementsAre(5));
}

// Bad rows are no effects: a limit of one effect leaves room for all of them, and for the strongest effect.
TEST(Search, ALimitCountsEffectsAndNoBadRows) {
  std::mt19937 random(5);
  Rows rows = MakeRows(6);
  const Eigen::MatrixXd harmonics = Harmonics(kOrders);
  rows.y += 2.0 * harmonics.col(4) + 0.8 * harmonics.col(20);
  const std::vector<int> bad = {50, 220, 400};
  for (const int row : bad) rows.y[row] += 15.0;
  Group model;
  model.family = 2;
  model.is_counted = false;
  std::vector<int> all(kRows);
  for (int i = 0; i < kRows; ++i) all[i] = i;
  const auto search = [&](int most) {
    std::vector<std::unique_ptr<Source>> sources = Dictionary(&random);
    sources.push_back(std::make_unique<SingleRows>(kRows, all, model));
    Policy policy;
    policy.most_effects = most;
    Scorer scorer(rows, std::move(sources), policy);
    return GroupsOf(SearchAll(&scorer));
  };
  const int first_row = kOrders + kRandom;
  EXPECT_THAT(search(1), UnorderedElementsAre(2, first_row + bad[0], first_row + bad[1], first_row + bad[2]));
  EXPECT_THAT(search(2), UnorderedElementsAre(2, 10, first_row + bad[0], first_row + bad[1], first_row + bad[2]));
}

}  // namespace
}  // namespace axiscal::objective
