#include "core/toolsetter/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
#include "core/information/choice.h"
#include "core/session/read_session.h"

namespace axiscal::toolsetter {
namespace {

using ::testing::HasSubstr;

RodSession Rods() {
  return ReadRodSession(session::ReadSessionFile(
                            base::SourcePath("/deploy/examples/fang-tool-setter/tool-setter-misaligned-1.csv"))
                            .value())
      .value();
}

// Fang 2022, ch. 2: three rods do not tell yaw at all well (10 mrad per um), the inclined one turned does.
TEST(PlanRods, TurningTheInclinedRodTellsTheBeam) {
  const ReferenceOptions all{true, true};
  const auto as_they_are = PlanRods(Rods(), "", 12, 3), turned = PlanRods(Rods(), "rod-2", 12, 3);
  ASSERT_TRUE(as_they_are.ok() && turned.ok());
  ASSERT_EQ(as_they_are->rods.size(), 3u);
  ASSERT_EQ(turned->rods.size(), 14u);
  EXPECT_EQ(turned->rods[2].name, "rod-2");
  EXPECT_EQ(turned->rods[3].name, "rod-2@30");
  EXPECT_EQ(turned->rods[3].body(), "rod-2");
  const auto before = FitReference(*as_they_are, all), after = FitReference(*turned, all);
  ASSERT_TRUE(before.ok() && after.ok()) << before.status() << after.status();
  EXPECT_NEAR(after->parameters[kReferenceZ].estimate, 0.0, 1e-6);
  EXPECT_NEAR(after->parameters[kReferenceYaw].estimate, 0.6241 * base::kRadPerDeg, 1e-6);
  EXPECT_LT(after->parameters[kReferenceYaw].sigma, 0.1 * before->parameters[kReferenceYaw].sigma);
}

// What a planned test tells is what its evaluation states once it is measured: the covariance is the inverse of the
// information, in the beam that noisy readouts give as well.
TEST(PlanRods, InformationIsThatOfTheMeasuredSession) {
  RodSession planned = PlanRods(Rods(), "rod-2", 12, 3).value();
  const auto tells = InformationOf(planned);
  ASSERT_TRUE(tells.ok()) << tells.status();
  const information::Told told =
      information::Tell({*tells, *tells}, {kReferenceZ, kReferenceYaw, kReferencePitch});
  EXPECT_TRUE(told.Undetermined().empty());
  const Reference expected = ExpectedOf(planned).value();
  for (int i = 0; i < kReferenceParameters; ++i)
    EXPECT_NEAR(told.sigma[i] / expected.parameters[i].sigma, 1.0, 1e-6) << i;
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (MeasuredRod& rod : planned.rods) {
    for (double& readout_mm : rod.readouts_mm) readout_mm += planned.sigma_mm * normal(random);
  }
  const Reference measured = FitReference(planned, {true, true}).value();
  planned.beam.yaw_rad = measured.parameters[kReferenceYaw].estimate;
  planned.beam.pitch_rad = measured.parameters[kReferencePitch].estimate;
  const Eigen::MatrixXd after = InformationOf(planned)->matrix;
  const Eigen::VectorXd scale = after.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd apart = scale.asDiagonal() * (tells->matrix - after) * scale.asDiagonal();
  EXPECT_LT(apart.cwiseAbs().maxCoeff(), 5e-3);
}

TEST(PlanRods, RodsThatShareNoErrorAddUp) {
  const RodSession all = PlanRods(Rods(), "", 12, 3).value();
  information::Information sum;
  for (size_t i = 0; i < all.rods.size(); ++i) {
    RodSession one = all;
    one.rods = {all.rods[i]};
    const information::Information tells = InformationOf(one).value();
    if (i == 0) {
      sum = tells;
    } else {
      sum += tells;
    }
  }
  const information::Information together = InformationOf(all).value();
  EXPECT_LT((together.matrix - sum.matrix).norm(), 1e-12 * together.matrix.norm());
  EXPECT_LT((together.norm2 - sum.norm2).norm(), 1e-12 * together.norm2.norm());
}

// A square rod feels no yaw, and Z and pitch by their sum alone.
TEST(PlanRods, WhatTheRodsCannotTellIsSaid) {
  RodSession square = PlanRods(Rods(), "standard", 12, 3).value();
  std::erase_if(square.rods, [](const MeasuredRod& rod) { return rod.body() != "standard"; });
  const information::Information tells = InformationOf(square).value();
  const information::Told told = information::Tell({tells, tells}, {kReferenceZ, kReferenceYaw, kReferencePitch});
  EXPECT_EQ(told.Undetermined(), (std::vector<int>{kReferenceZ, kReferenceYaw, kReferencePitch}));
  const Reference expected = ExpectedOf(square).value();
  for (const Fitted& parameter : expected.parameters) EXPECT_FALSE(parameter.is_identifiable);
}

// The rod to be turned next is chosen as tests of machines are: the least determinant of the covariance, by brute force
// over all rods. Of two that are tilted alike the thicker one tells more.
TEST(PlanRods, TheRodThatTellsMostIsProposed) {
  for (const double radius_mm : {3.0, 8.0}) {
    RodSession session = PlanRods(Rods(), "", 12, 3).value();
    MeasuredRod other = session.rods.back();
    ASSERT_EQ(other.name, "rod-2");
    other.name = "rod-3";
    other.rod.radius_mm = radius_mm;
    session.rods.push_back(other);
    session = PlanRods(session, "", 12, 3).value();
    const Reference reference = FitReference(session, {true, true}).value();
    ASSERT_TRUE(reference.next.has_value());
    std::string best;
    double least = INFINITY;
    for (const char* name : {"rod-2", "rod-3"}) {
      RodSession turned = PlanRods(session, name, 12, 1).value();
      std::erase_if(turned.rods, [&](const MeasuredRod& rod) { return rod.body() != name; });
      const double determinant = ExpectedOf(turned)->covariance.determinant();
      if (determinant < least) least = determinant, best = name;
    }
    EXPECT_EQ(reference.next->rod, best);
    EXPECT_EQ(reference.next->rod, radius_mm > 5.0 ? "rod-3" : "rod-2");
  }
}

TEST(PlanRods, RefusesWithWhatWasExpected) {
  EXPECT_THAT(std::string(PlanRods(Rods(), "rod-9", 12, 3).status().message()), HasSubstr("'rod-9' is no rod"));
  EXPECT_THAT(std::string(PlanRods(Rods(), "rod-2", 1, 3).status().message()), HasSubstr("holders = 1, expected 2"));
  EXPECT_THAT(std::string(PlanRods(Rods(), "", 12, 0).status().message()), HasSubstr("readouts = 0, expected 1"));
}

// Twelve starts at 1 um of noise: length and wear to about 0.8 um.
TEST(PlanStarts, TwelveStartsTellLengthAndWear) {
  CurveSession session;
  session.session = "planned";
  session.sigma_mm = 1e-3;
  session.start_sigma_rad = kUsualStartSigmaDeg * base::kRadPerDeg;
  const CutterDescription described =
      ReadCutterFile(base::SourcePath("/deploy/examples/fang-round-insert/cutter.json")).value();
  session.cutter = described.cutter;
  session.run = described.run;
  const auto planned = PlanStarts(session, 12);
  ASSERT_TRUE(planned.ok()) << planned.status();
  ASSERT_EQ(planned->starts_rad.size(), 12u);
  EXPECT_NEAR(planned->lengths_mm[0], -0.006371, 2e-6);  // Z_t at 0, computed apart
  const auto report = FitWear(*planned);
  ASSERT_TRUE(report.ok()) << report.status();
  EXPECT_NEAR(report->length_sigma_mm, 0.8e-3, 0.4e-3);
  EXPECT_THAT(std::string(PlanStarts(session, 3).status().message()), HasSubstr("starts = 3, expected 4 to 360"));
  session.run.offset_mm = 0.0;
  EXPECT_THAT(std::string(PlanStarts(session, 12).status().message()), HasSubstr("inserts cannot be told apart"));
}

// What is written is a session that lacks its readings alone.
TEST(PlanTables, AreSessionsOnceTheirReadingsStand) {
  const std::string path = base::SourcePath("/deploy/examples/fang-tool-setter/tool-setter-misaligned-1.csv");
  const session::Session rods = session::ReadSessionFile(path).value();
  const RodSession planned = PlanRods(ReadRodSession(rods).value(), "rod-2", 12, 2).value();
  std::string text = ToTable(rods, planned);
  for (size_t at = 0; (at = text.find(",\n", at)) != std::string::npos;) text.replace(at, 2, ",-330.0\n");
  const auto filled = session::ReadSessionText(text, "rods.csv");
  ASSERT_TRUE(filled.ok()) << filled.status();
  const auto read = ReadRodSession(*filled);
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->rods.size(), planned.rods.size());
  for (const MeasuredRod& rod : planned.rods) {
    const auto same = std::find_if(read->rods.begin(), read->rods.end(),
                                   [&](const MeasuredRod& other) { return other.name == rod.name; });
    ASSERT_NE(same, read->rods.end()) << rod.name;
    EXPECT_NEAR(same->rod.holder_rad, rod.rod.holder_rad, 1e-9);
    EXPECT_EQ(same->readouts_mm.size(), rod.readouts_mm.size());
  }
}

}  // namespace
}  // namespace axiscal::toolsetter
