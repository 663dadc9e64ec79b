#include "core/toolsetter/reference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/base/units.h"
#include "core/session/read_session.h"

namespace axiscal::toolsetter {
namespace {

using ::testing::HasSubstr;

using base::kRadPerDeg;

const char kHeader[] =
    "# machine: mt\n# session: rods\n# instrument: tool-setter\n# sigma_um: 0.5\n# tool_tip_mm: 0 0 0\n";

MeasuredRod MakeRod(const std::string& name, double face_deg, double azimuth_deg, double holder_deg, int readouts) {
  MeasuredRod rod;
  rod.name = name;
  rod.rod = {5.0,
             0.03,
             face_deg == 90.0 ? 0.5 * std::numbers::pi : face_deg * kRadPerDeg,
             azimuth_deg * kRadPerDeg,
             150.,
             holder_deg * kRadPerDeg};
  rod.readouts_mm.assign(readouts, 0.0);
  return rod;
}

constexpr double kTrueZ = -510.0, kTrueYaw = 0.6 * kRadPerDeg, kTruePitch = 0.28 * kRadPerDeg;

// Readouts of a beam at the true values, with noise of `noise_mm`.
void Measure(RodSession* session, double noise_mm, std::mt19937* random) {
  std::normal_distribution<double> normal;
  const Beam truth{session->beam.radius_mm, kTrueYaw, kTruePitch};
  for (MeasuredRod& rod : session->rods) {
    const double height_mm = TriggerOf(rod.rod, truth)->height_mm;
    for (double& readout_mm : rod.readouts_mm)
      readout_mm = kTrueZ + rod.rod.length_mm + height_mm + noise_mm * normal(*random);
  }
}

RodSession ThreeRods() {
  RodSession session;
  session.session = "rods";
  session.sigma_mm = 0.5e-3;
  session.beam = {0.2, kTrueYaw, kTruePitch};
  session.rods = {MakeRod("standard", 90, 0, 0, 3), MakeRod("rod-1", 89.922, 127.71, 0, 3),
                  MakeRod("rod-2", 88.041, 144.086, 0, 3)};
  return session;
}

TEST(Reference, ExactReadoutsGiveTheBeam) {
  std::mt19937 random(1);
  RodSession session = ThreeRods();
  Measure(&session, 0.0, &random);
  const auto reference = FitReference(session);
  ASSERT_TRUE(reference.ok()) << reference.status();
  EXPECT_NEAR(reference->parameters[kReferenceZ].estimate, kTrueZ, 1e-10);
  EXPECT_NEAR(reference->range_mm, 0.0, 1e-10);
  EXPECT_EQ(reference->between_rods_mm, 0.0);
  EXPECT_NEAR(reference->parameters[kReferenceZ].sigma, 0.5e-3 / 3.0, 1e-6);  // nine readouts
}

TEST(Reference, StandardAndTiltedRodSeparatePitchFromZ) {
  std::mt19937 random(1);
  RodSession session = ThreeRods();
  session.rods.erase(session.rods.begin() + 1);
  Measure(&session, 0.0, &random);
  session.beam.pitch_rad = 0.0;  // far from it, on the kink
  const auto reference = FitReference(session, {false, true});
  ASSERT_TRUE(reference.ok()) << reference.status();
  EXPECT_NEAR(reference->parameters[kReferenceZ].estimate, kTrueZ, 1e-9);
  EXPECT_NEAR(reference->parameters[kReferencePitch].estimate, kTruePitch, 1e-9);
  EXPECT_TRUE(reference->unseen.empty());
  EXPECT_EQ(reference->degrees_of_freedom, 0);
}

TEST(Reference, OneSquareRodCannotTellPitchFromZNorSeeYaw) {
  std::mt19937 random(1);
  RodSession session = ThreeRods();
  session.rods.resize(1);
  Measure(&session, 0.0, &random);
  const auto reference = FitReference(session, {true, true});
  ASSERT_TRUE(reference.ok()) << reference.status();
  ASSERT_EQ(reference->unseen.size(), 2u);
  for (const Fitted& parameter : reference->parameters) {
    EXPECT_FALSE(parameter.is_identifiable);
    EXPECT_TRUE(std::isnan(parameter.estimate));
  }
  const std::string json = reports::ToJson(ReportOf(session, *reference));
  EXPECT_NE(json.find("\"identifiable\": false"), std::string::npos);
  EXPECT_EQ(json.find("nan"), std::string::npos);
}

TEST(Reference, YawNeedsTenMilliradiansPerMicrometreWithThreeRods) {
  std::mt19937 random(1);
  RodSession session = ThreeRods();
  Measure(&session, 0.0, &random);
  const double rod_um = session.sigma_mm / std::sqrt(3.0) / 1e-3;
  const auto yaw = FitReference(session, {true, false});
  ASSERT_TRUE(yaw.ok()) << yaw.status();
  EXPECT_NEAR(yaw->parameters[kReferenceYaw].sigma / rod_um, 12e-3, 3e-3);  // rad per um
  const auto all = FitReference(session, {true, true});  // with pitch free, only rod 1's weak tilt is left to tell yaw
  ASSERT_TRUE(all.ok()) << all.status();
  EXPECT_GT(all->parameters[kReferenceYaw].sigma / rod_um, 100e-3);
  ASSERT_TRUE(all->next.has_value());
  EXPECT_EQ(all->next->rod, "rod-2");
  EXPECT_LT(all->next->sigma[kReferenceYaw], 0.05 * all->parameters[kReferenceYaw].sigma);
}

// What is proposed works: the turned rod gives yaw, pitch and Z together, within what it promised.
TEST(Reference, TurningTheTiltedRodGivesAllThree) {
  std::mt19937 random(7);
  int covered = 0, total = 0;
  for (int k = 0; k < 60; ++k) {
    RodSession session = ThreeRods();
    session.rods.clear();
    for (int i = 0; i < 12; ++i)
      session.rods.push_back(MakeRod(absl::StrCat("rod-2@", 30 * i), 88.041, 144.086, 30 * i, 1));
    Measure(&session, session.sigma_mm, &random);
    session.beam.yaw_rad = session.beam.pitch_rad = 0.0;
    const auto reference = FitReference(session, {true, true});
    ASSERT_TRUE(reference.ok()) << reference.status();
    const double truth[] = {kTrueZ, kTrueYaw, kTruePitch};
    for (int i = 0; i < kReferenceParameters; ++i) {
      const Fitted& parameter = reference->parameters[i];
      covered += std::abs(parameter.estimate - truth[i]) < 1.96 * parameter.sigma;
      ++total;
    }
    ASSERT_TRUE(reference->next.has_value());
    const double grown = std::sqrt(std::max(1.0, reference->chi2 / reference->degrees_of_freedom));
    EXPECT_NEAR(reference->next->sigma[kReferencePitch] * grown, reference->parameters[kReferencePitch].sigma, 1e-7);
  }
  EXPECT_GE(covered, 0.89 * total);  // 95 % of 180, less three standard deviations
}

TEST(Reference, RodsThatDisagreeWidenTheUncertainty) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  int covered = 0;
  const int runs = 200;
  for (int k = 0; k < runs; ++k) {
    RodSession session = ThreeRods();
    for (int i = 0; i < 5; ++i) session.rods.push_back(MakeRod(absl::StrCat("more-", i), 89.9, 20.0 * i, 0, 3));
    Measure(&session, session.sigma_mm, &random);
    for (MeasuredRod& rod : session.rods) {
      const double off_mm = 3e-3 * normal(random);  // of its length: repeats do not show it
      for (double& readout_mm : rod.readouts_mm) readout_mm += off_mm;
    }
    const auto reference = FitReference(session);
    ASSERT_TRUE(reference.ok()) << reference.status();
    EXPECT_GT(reference->between_rods_mm, 0.2e-3);
    const Fitted& z = reference->parameters[kReferenceZ];
    covered += std::abs(z.estimate - kTrueZ) < 2.36 * z.sigma;  // Student's t, 7 degrees of freedom
  }
  EXPECT_GE(covered, 0.90 * runs);
}

// With as many unknowns as rods nothing shows what the rods are off by: no sigma but where it was stated, and then it
// covers.
TEST(Reference, AsManyUnknownsAsRodsHaveNoIntervalUnlessItIsStated) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  const auto off_rods = [&] {
    RodSession session = ThreeRods();
    session.rods.push_back(MakeRod("rod-3", 88.5, 20.0, 0, 3));
    session.rods.erase(session.rods.begin() + 1);  // nearly as square as the standard
    Measure(&session, session.sigma_mm, &random);
    for (MeasuredRod& rod : session.rods) {
      const double off_mm = 3e-3 * normal(random);
      for (double& readout_mm : rod.readouts_mm) readout_mm += off_mm;
    }
    return session;
  };
  const Reference bare = FitReference(off_rods(), {true, true}).value();
  EXPECT_EQ(bare.degrees_of_freedom, 0);
  for (int i = 0; i < kReferenceParameters; ++i) EXPECT_FALSE(bare.has_interval[i]) << i;
  const RodSession any = off_rods();
  const reports::BeamReference report = ReportOf(any, FitReference(any, {true, true}).value());
  EXPECT_TRUE(std::isnan(report.reference_mm.sigma));
  EXPECT_TRUE(std::isnan(report.yaw_deg.sigma));
  EXPECT_TRUE(std::isfinite(report.yaw_deg.estimate));
  ASSERT_EQ(report.warnings.size(), 1u);
  EXPECT_EQ(report.warnings[0].kind, reports::WarningKind::kNoFreedom);
  EXPECT_THAT(report.warnings[0].text, HasSubstr("Z, yaw, pitch from 3 rods"));
  int covered = 0, total = 0;
  for (int k = 0; k < 60; ++k) {
    RodSession session = off_rods();
    for (MeasuredRod& rod : session.rods) rod.sigma.length_mm = 3e-3;
    const Reference reference = FitReference(session, {true, true}).value();
    const double truth[] = {kTrueZ, kTrueYaw, kTruePitch};
    for (int i = 0; i < kReferenceParameters; ++i) {
      EXPECT_TRUE(reference.has_interval[i]);
      covered += std::abs(reference.parameters[i].estimate - truth[i]) <
                 reference.coverage_factor * reference.parameters[i].sigma;
      ++total;
    }
  }
  EXPECT_GE(covered, 0.86 * total);  // 95 % of 180 that go together by three, less three standard deviations
}

// One rod and Z alone; one rod turned, which tells the beam's angles by itself but not what its length is off by.
TEST(Reference, OneRodCannotJudgeItsOwnLength) {
  std::mt19937 random(2);
  RodSession session = ThreeRods();
  session.rods.resize(1);
  Measure(&session, session.sigma_mm, &random);
  EXPECT_TRUE(std::isnan(ReportOf(session, FitReference(session).value()).reference_mm.sigma));
  session.rods.clear();
  for (int i = 0; i < 12; ++i)
    session.rods.push_back(MakeRod(absl::StrCat("rod-2@", 30 * i), 88.041, 144.086, 30 * i, 1));
  Measure(&session, session.sigma_mm, &random);
  const reports::BeamReference turned = ReportOf(session, FitReference(session, {true, true}).value());
  EXPECT_TRUE(std::isnan(turned.reference_mm.sigma));
  EXPECT_TRUE(std::isfinite(turned.yaw_deg.sigma));
  EXPECT_TRUE(std::isfinite(turned.pitch_deg.sigma));
  ASSERT_EQ(turned.warnings.size(), 1u);
  EXPECT_THAT(turned.warnings[0].text, HasSubstr("from 1 rod,"));
  EXPECT_THAT(turned.warnings[0].text, HasSubstr("Z without sigma"));
}

TEST(Reference, FewRodsHaveWideIntervals) {
  std::mt19937 random(3);
  RodSession session = ThreeRods();
  Measure(&session, session.sigma_mm, &random);
  for (double& readout_mm : session.rods[2].readouts_mm) readout_mm += 8e-3;
  const Reference reference = FitReference(session).value();
  EXPECT_EQ(reference.degrees_between_rods, 2);
  EXPECT_NEAR(reference.coverage_factor, 4.303, 1e-3);  // Student's t
}

TEST(Reference, RefusesReadoutsThatAreNotTheRods) {
  RodSession session = ThreeRods();
  std::mt19937 random(1);
  Measure(&session, session.sigma_mm, &random);
  const RodSession right = session;
  session.rods[1].readouts_mm[1] *= 1e-3;
  EXPECT_THAT(std::string(FitReference(session).status().message()),
              HasSubstr("to -0.3600 mm, expected within 0.1 mm of each other"));
  session = right;
  session.rods[1].rod.length_mm *= 1e-3;
  EXPECT_THAT(std::string(FitReference(session).status().message()),
              HasSubstr("rods: rod-1 puts the reference point 149.85"));
  session = right;
  session.rods[2].rod.length_mm += 3.0;
  EXPECT_EQ(FitReference(session).status().code(), absl::StatusCode::kInvalidArgument);
  session.rods[2].rod.length_mm -= 2.95;  // nobody stated better: said as the spread between rods
  EXPECT_TRUE(FitReference(session).ok());
  EXPECT_TRUE(FitReference(right).ok());
}

TEST(Reference, StatedUncertaintiesOfRodsAndBeamCount) {
  std::mt19937 random(1);
  RodSession session = ThreeRods();
  session.rods.resize(1);
  session.rods[0].sigma.length_mm = 2e-3;
  Measure(&session, 0.0, &random);
  EXPECT_NEAR(FitReference(session)->parameters[kReferenceZ].sigma, std::hypot(2e-3, 0.5e-3 / std::sqrt(3.0)), 1e-9);
  session.beam_sigma.pitch_rad = 1e-3;  // 4.97 mm of lever
  const auto reference = FitReference(session);
  EXPECT_NEAR(reference->parameters[kReferenceZ].sigma, std::hypot(4.97e-3, 2e-3, 0.5e-3 / std::sqrt(3.0)), 1e-5);
  EXPECT_NEAR(reference->parameters[kReferencePitch].sigma, 1e-3, 1e-9);
}

absl::StatusOr<RodSession> ReadText(const std::string& header, const std::string& rows) {
  const auto session = session::ReadSessionText(kHeader + header + "rod,readout,Z_mm\n" + rows, "rods.csv");
  if (!session.ok()) return session.status();
  return ReadRodSession(*session);
}

TEST(RodSession, ReadsBeamRodsAndWhatIsStatedOfThem) {
  const auto session = ReadText(
      "# beam: 0.2 0.5 0.25\n# beam_sigma: 0 0.1 0.05\n# rod a: 5 0.03 90 0 133.7 0\n# rod b@30: 5 0 89 10 160 30\n"
      "# rod_sigma b: 0.001 0.002 0.01 0.02 0.003\n",
      "a,1,-376.5\nb@30,1,-349.6\na,2,-376.6\n");
  ASSERT_TRUE(session.ok()) << session.status();
  EXPECT_EQ(session->beam.yaw_rad, 0.5 * kRadPerDeg);
  EXPECT_EQ(session->beam_sigma.pitch_rad, 0.05 * kRadPerDeg);
  EXPECT_EQ(session->rods[0].readouts_mm, (std::vector<double>{-376.5, -376.6}));
  EXPECT_EQ(session->rods[1].body(), "b");
  EXPECT_EQ(session->rods[1].sigma.length_mm, 0.003);
  EXPECT_EQ(session->sigma_mm, 0.5e-3);
}

TEST(RodSession, RefusesWithPlaceAndRule) {
  const struct {
    std::string header, rows, what;
  } cases[] = {
      {"# beam: 0.2 0 0\n# rod a: 5 0.03 -90 0 133 0\n", "a,1,1\n", "a: rod: phi = -90 deg, expected 45 to 90"},
      {"# beam: 0.2 0 0\n# rod a: 0 0 90 0 133 0\n", "a,1,1\n", "R_r = 0 mm"},
      {"# beam: 0 0 0\n# rod a: 5 0 90 0 133 0\n", "a,1,1\n", "R_l = 0 mm"},
      {"# beam: 0.2 0 0\n# rod a: 5 0 90 0 133\n", "a,1,1\n", "R_r R_f phi tau L_r theta_th"},
      {"# beam: 0.2 0 0\n# rod a: 5 nan 90 0 133 0\n", "a,1,1\n", "R_r R_f phi tau L_r theta_th"},
      {"# beam: 0.2 0 0\n# rod a: 5 0 90 0 133 0\n", "b,1,1\n", "'b'"},
      {"# beam: 0.2 0 0\n# rod a: 5 0 90 0 133 0\n# rod_sigma a: 1 2\n", "a,1,1\n", "5 standard deviations"},
      {"# beam: 0.2 0 0\n# beam_sigma: 0 -1 0\n# rod a: 5 0 90 0 133 0\n", "a,1,1\n", "a number below 0"},
  };
  for (const auto& c : cases) {
    const auto session = ReadText(c.header, c.rows);
    ASSERT_EQ(session.status().code(), absl::StatusCode::kInvalidArgument) << c.what;
    EXPECT_NE(session.status().message().find(c.what), std::string::npos) << session.status().message();
  }
  RodSession none = ThreeRods();
  for (MeasuredRod& rod : none.rods) rod.readouts_mm.clear();
  EXPECT_EQ(FitReference(none).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace axiscal::toolsetter
