#include "core/toolsetter/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/testing/source_path.h"
#include "core/base/units.h"
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
}

}  // namespace
}  // namespace axiscal::toolsetter
