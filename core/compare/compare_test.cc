#include "core/compare/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "core/base/units.h"
#include "core/machine/testing/machines.h"

namespace axiscal::compare {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kUm = 1e-3;

machine::Machine Machine() { return machine::testing::MultiTasking(); }

Side SideOf(const std::string& text) {
  auto side = ReadSide(text, Machine());
  EXPECT_TRUE(side.ok()) << side.status();
  return side.ok() ? *std::move(side) : Side();
}

// X over 500 mm, C once around; Z, Y and B rest.
predict::Workspace Over() {
  predict::Workspace workspace;
  workspace.tip_mm = {0, 0, -350};
  workspace.box.low = {-300, 10, -250, 0, 0};
  workspace.box.high = {-300, 10, 250, 0, 2 * M_PI};
  return workspace;
}

Comparison Compared(const Side& first, const Side& second, const std::optional<predict::Workspace>& workspace = {}) {
  auto made = Compare(Machine(), first, second, workspace);
  EXPECT_TRUE(made.ok()) << made.status();
  return made.ok() ? *std::move(made) : Comparison();
}

std::string One(double value, double sigma) {
  return absl::StrFormat(R"({"EX0C": %g, "covariance": {"of": ["EX0C"], "sigma": [%g], "correlation": [[]]}})", value,
                         sigma);
}

std::string Two(double a, double b, double sigma, double correlation) {
  return absl::StrFormat(
      R"({"EX0C": %.17g, "EY0C": %.17g, "covariance": {"of": ["EX0C", "EY0C"], "sigma": [%g, %g],
          "correlation": [[], [%g]]}})",
      a, b, sigma, sigma, correlation);
}

TEST(Compare, TheSameErrorsAgree) {
  const Side side = SideOf(Two(50, -20, 1, 0.5));
  const Comparison made = Compared(side, side, Over());
  ASSERT_THAT(made.errors, SizeIs(2));
  for (const Difference& one : made.errors) {
    EXPECT_EQ(one.difference, 0.0);
    EXPECT_EQ(one.probability, 1.0);
    EXPECT_EQ(one.verdict, Verdict::kAgrees);
  }
  EXPECT_EQ(made.joint.chi2, 0.0);
  EXPECT_EQ(made.tool_point->as_programmed.max_mm, 0.0);
  EXPECT_GT(made.tool_point->as_programmed.chance_rms_mm, 0.0);
}

// 10 um of 5 um (3 and 4 at right angles): two sigma, 4.55 %. A table 10 um beside its place is 10 um at every pose;
// with B at rest it is a shift of the tool, which is set anew.
TEST(Compare, OneErrorByHand) {
  const Comparison made = Compared(SideOf(One(50, 3)), SideOf(One(60, 4)), Over());
  ASSERT_THAT(made.errors, SizeIs(1));
  EXPECT_NEAR(made.errors[0].difference, 10.0, 1e-9);
  EXPECT_NEAR(made.errors[0].sigma, 5.0, 1e-9);
  EXPECT_NEAR(made.errors[0].probability, 0.0455003, 1e-6);
  EXPECT_EQ(made.errors[0].verdict, Verdict::kDiffers);  // one comparison: nothing to correct for
  EXPECT_NEAR(made.joint.chi2, 4.0, 1e-9);
  EXPECT_NEAR(made.joint.probability, made.errors[0].probability, 1e-9);
  EXPECT_NEAR(made.errors[0].rms_mm, 10 * kUm, 1e-9);
  const Size& size = made.tool_point->as_programmed;
  EXPECT_NEAR(size.rms_mm, 10 * kUm, 1e-9);
  EXPECT_NEAR(size.max_mm, 10 * kUm, 1e-9);
  EXPECT_THAT(size.where.by, ElementsAre("EX0C"));
  // |z| of a normal z is below 1.96 in 95 of 100 cases; drawn a thousand times.
  EXPECT_NEAR(size.chance_rms_mm, 1.96 * 5 * kUm, 0.6 * kUm);
  EXPECT_LT(made.tool_point->set_anew.max_mm, 1e-9);
}

// The tool point's error of a tilted table grows with the distance: its largest value is at a corner of the box.
TEST(Compare, WhereTheDifferenceIsLargest) {
  const Comparison made = Compared(SideOf(R"({"EB0C": 0})"), SideOf(R"({"EB0C": 100})"), Over());
  const Size& size = made.tool_point->as_programmed;
  EXPECT_EQ(std::abs(size.where.positions[2]), 250.0);
  EXPECT_THAT(size.where.by, ElementsAre("EB0C"));
  EXPECT_TRUE(std::isnan(size.chance_rms_mm));
  EXPECT_NEAR(made.tool_point->tilt_max_rad, 100e-6, 1e-9);
  EXPECT_EQ(made.errors[0].verdict, Verdict::kNoUncertainty);
  EXPECT_THAT(made.notes, ::testing::Contains(HasSubstr("states no uncertainties")));
}

// d = (1.5, -1.5) sigma of the difference, correlated by 0.95: chi-square = 1.5^2 * 2 / (1 - 0.95) = 90, although
// neither differs by itself.
TEST(Compare, CorrelatedErrorsAreJudgedTogether) {
  const double sigma = 2.0, joint = std::sqrt(2.0) * sigma;
  const Comparison made =
      Compared(SideOf(Two(10, 10, sigma, 0.95)), SideOf(Two(10 + 1.5 * joint, 10 - 1.5 * joint, sigma, 0.95)));
  for (const Difference& one : made.errors) EXPECT_EQ(one.verdict, Verdict::kAgrees) << one.name;
  EXPECT_NEAR(made.joint.chi2, 90.0, 1e-6);
  EXPECT_EQ(made.joint.degrees_of_freedom, 2);
  EXPECT_LT(made.joint.probability, 1e-15);
}

// The first measured B at one angle only: of EX0B and EX0C it knows the sum, 50. The second knows both: 20 and 31.
TEST(Compare, OnlyWhatBothDetermined) {
  Side first = SideOf(R"({"EX0B": 0, "EX0C": 50, "EA0B": 7,
      "covariance": {"of": ["EX0C", "EA0B"], "sigma": [0.6, 1], "correlation": [[], [0]]}})");
  first.has_report = true;
  first.not_separable = {"EX0B - EX0C"};
  first.without_number = {"EX0B", "EX0C"};
  const Side second = SideOf(R"({"EX0B": 20, "EX0C": 31, "EA0B": 7,
      "covariance": {"of": ["EX0B", "EX0C", "EA0B"], "sigma": [5, 5, 1], "correlation": [[], [-0.9872], [0, 0]]}})");
  const Comparison made = Compared(first, second, Over());
  ASSERT_THAT(made.errors, SizeIs(3));
  for (const Difference& one : made.errors) {
    EXPECT_EQ(one.verdict, one.name == "EA0B" ? Verdict::kAgrees : Verdict::kNotDetermined) << one.name;
    if (one.name == "EA0B") continue;
    EXPECT_TRUE(std::isnan(one.difference));
    EXPECT_THAT(one.reason, HasSubstr("the first could not tell it"));
  }
  ASSERT_THAT(made.combinations, SizeIs(1));
  EXPECT_THAT(made.combinations[0].name, ::testing::AnyOf("EX0C + EX0B", "EX0B + EX0C"));
  EXPECT_NEAR(made.combinations[0].difference, 1.0, 1e-9);
  // 0.6^2 + 5^2 (2 - 2 * 0.9872)
  EXPECT_NEAR(made.combinations[0].sigma, std::sqrt(0.36 + 50 * (1 - 0.9872)), 1e-9);
  EXPECT_EQ(made.combinations[0].verdict, Verdict::kAgrees);
  EXPECT_THAT(made.not_comparable, SizeIs(1));
  EXPECT_EQ(made.joint.degrees_of_freedom, 2);
}

// B turns and so does what is not known of it: it moves the tool point in the box.
TEST(Compare, AnUnknownDirectionThatActsIsSaid) {
  Side first = SideOf(One(50, 1));
  first.errors =
      SideOf(R"({"EX0B": 0, "EX0C": 50, "covariance": {"of": ["EX0C"], "sigma": [1], "correlation": [[]]}})").errors;
  first.has_report = true;
  first.not_separable = {"EX0B - EX0C"};
  predict::Workspace workspace = Over();
  workspace.box.high[3] = 1.0;
  EXPECT_THAT(Compared(first, first, workspace).tool_point->unknown, SizeIs(1));
}

TEST(Compare, AnErrorOfOneModelOnlyHasNoVerdict) {
  const Comparison made = Compared(SideOf(One(50, 1)), SideOf(Two(50, 4, 1, 0)));
  ASSERT_THAT(made.errors, SizeIs(2));
  EXPECT_EQ(made.errors[1].verdict, Verdict::kOnlyOne);
  EXPECT_TRUE(std::isnan(made.errors[1].first));
  EXPECT_EQ(made.errors[1].second, 4.0);
  EXPECT_EQ(made.joint.degrees_of_freedom, 1);
  EXPECT_THAT(made.notes, ::testing::Contains(HasSubstr("the models differ")));
}

// What is held at zero without an uncertainty is not known, where no report says more.
TEST(Compare, HeldAtZeroIsNotDetermined) {
  const Side first =
      SideOf(R"({"EX0B": 0, "EX0C": 5, "covariance": {"of": ["EX0C"], "sigma": [1], "correlation": [[]]}})");
  const Comparison made = Compared(first, first);
  EXPECT_EQ(made.errors[0].verdict, Verdict::kNotDetermined);
  EXPECT_EQ(made.errors[1].verdict, Verdict::kAgrees);
}

// Of pairs of calibrations of one machine that did not change, 5 % show anything: by the joint statistic, by name, and
// at the tool point.
TEST(Compare, NothingChangedIsSaidInNineteenOfTwenty) {
  constexpr int kPairs = 1500, kErrors = 4;
  const Eigen::Matrix<double, kErrors, kErrors> mix =
      (Eigen::Matrix4d() << 2, 0, 0, 0, 1.5, 1, 0, 0, -1, 0.5, 1.5, 0, 0.2, 0.3, -0.4, 3).finished();
  const Eigen::Matrix4d covariance = mix * mix.transpose();
  base::Random random(7);
  const auto draw = [&] {
    Eigen::Vector4d z;
    for (double& one : z) one = random.Normal();
    const Eigen::Vector4d value = Eigen::Vector4d(50, -20, 30, 5) + mix * z;
    const Eigen::Vector4d sigma = covariance.diagonal().cwiseSqrt();
    const auto rho = [&](int i, int k) { return covariance(i, k) / (sigma[i] * sigma[k]); };
    return SideOf(absl::StrFormat(R"({"EX0C": %.12g, "EY0C": %.12g, "EA0C": %.12g, "EB0C": %.12g,
        "covariance": {"of": ["EX0C", "EY0C", "EA0C", "EB0C"], "sigma": [%.12g, %.12g, %.12g, %.12g],
        "correlation": [[], [%.12g], [%.12g, %.12g], [%.12g, %.12g, %.12g]]}})",
                                  value[0], value[1], value[2], value[3], sigma[0], sigma[1], sigma[2], sigma[3],
                                  rho(1, 0), rho(2, 0), rho(2, 1), rho(3, 0), rho(3, 1), rho(3, 2)));
  };
  int joint = 0, named = 0;
  for (int i = 0; i < kPairs; ++i) {
    const Comparison made = Compared(draw(), draw());
    joint += made.joint.probability < 0.05;
    bool any = false;
    for (const Difference& one : made.errors) any = any || one.verdict == Verdict::kDiffers;
    named += any;
  }
  // 0.05 +- 3 sqrt(0.05 * 0.95 / 1500); Holm is on the safe side where errors are correlated.
  EXPECT_NEAR(joint, 0.05 * kPairs, 0.017 * kPairs);
  EXPECT_LE(named, (0.05 + 0.017) * kPairs);
  EXPECT_GE(named, 0.01 * kPairs);
}

TEST(ParseCombination, ReadsWhatReportsWrite) {
  const auto shares = ParseCombination("EX0B - EX0C + 0.1 EB0C - 2.5 EYC:tabulated(60,A -30)");
  ASSERT_TRUE(shares.ok());
  ASSERT_THAT(*shares, SizeIs(4));
  EXPECT_EQ((*shares)[1].coefficient, -1.0);
  EXPECT_EQ((*shares)[2].coefficient, 0.1);
  EXPECT_EQ((*shares)[3].name, "EYC:tabulated(60,A -30)");
  EXPECT_EQ((*shares)[3].coefficient, -2.5);
  for (const char* bad : {"", "EX0B - ", "x EX0B", "0.1", "1e999 EX0B"})
    EXPECT_EQ(ParseCombination(bad).status().code(), absl::StatusCode::kInvalidArgument) << bad;
}

TEST(ReadSide, ReportsAloneAndOtherMachinesAreRefused) {
  EXPECT_THAT(std::string(ReadSide(R"({"estimates": []})", Machine()).status().message()), HasSubstr("errors.json"));
  EXPECT_THAT(std::string(ReadSide(R"({"machine": "other", "model": {}, "report": {}})", Machine()).status().message()),
              HasSubstr("machine other, expected of " + Machine().id));
  EXPECT_FALSE(ReadSide("{", Machine()).ok());
}

TEST(BoxOfTravel, NamesAnAxisWithoutTravel) {
  machine::Machine machine = Machine();
  for (machine::Axis& axis : machine.axes) axis.min_position = axis.max_position = {};
  EXPECT_THAT(std::string(predict::BoxOfTravel(machine).status().message()), HasSubstr("states no travel of Z"));
  for (machine::Axis& axis : machine.axes) {
    axis.min_position = -1.0;
    axis.max_position = 2.0;
  }
  EXPECT_THAT(predict::BoxOfTravel(machine)->high, ElementsAre(2.0, 2.0, 2.0, 2.0, 2.0));
}

}  // namespace
}  // namespace axiscal::compare
