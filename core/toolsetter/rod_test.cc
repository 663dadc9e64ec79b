#include "core/toolsetter/rod.h"

#include <gtest/gtest.h>

#include "core/base/units.h"
#include "core/toolsetter/narrow_shade.h"

namespace axiscal::toolsetter {
namespace {

using base::kRadPerDeg;

Rod MakeRod(double radius_mm, double fillet_mm, double face_deg, double azimuth_deg, double holder_deg = 0.0) {
  return {radius_mm, fillet_mm, face_deg * kRadPerDeg, azimuth_deg * kRadPerDeg, 100.0, holder_deg * kRadPerDeg};
}
Beam MakeBeam(double radius_mm, double yaw_deg, double pitch_deg) {
  return {radius_mm, yaw_deg * kRadPerDeg, pitch_deg * kRadPerDeg};
}

TEST(Integrate, IsExactForPolynomialsOfDegree31) {
  EXPECT_NEAR(Integrate(-1.0, 1.0, [](double) { return 1.0; }), 2.0, 1e-15);
  EXPECT_NEAR(Integrate(0.0, 1.0, [](double x) { return std::pow(x, 31); }), 1.0 / 32.0, 1e-15);
}

TEST(RodTrigger, ASquareFaceInAnAlignedBeamTriggersAtItsFace) {
  const auto trigger = TriggerOf(MakeRod(5, 0.03, 90, 0), MakeBeam(0.2, 0, 0));
  ASSERT_TRUE(trigger.ok()) << trigger.status();
  EXPECT_NEAR(trigger->height_mm, 0.0, 1e-13);
  EXPECT_NEAR(trigger->area_mm2, 0.0628318530718, 1e-12);
}

// Only the azimuth in the machine against the beam counts, and a mirror image changes nothing.
TEST(RodTrigger, TurnsWithTheBeamAndMirrors) {
  const double height_mm = TriggerOf(MakeRod(5, 0.1, 89, 40), MakeBeam(0.2, 0.5, 0.3))->height_mm;
  EXPECT_NEAR(TriggerOf(MakeRod(5, 0.1, 89, 10, 32), MakeBeam(0.2, 2.5, 0.3))->height_mm, height_mm, 1e-12);
  EXPECT_NEAR(TriggerOf(MakeRod(5, 0.1, 89, -40), MakeBeam(0.2, -0.5, 0.3))->height_mm, height_mm, 1e-12);
}

TEST(RodTrigger, AgreesWithTheSlowTwin) {
  const Beam beam = MakeBeam(0.2, 0.4, 0.3);
  for (const Rod& rod : {MakeRod(5, 0.03, 89.5, 100), MakeRod(1, 0.3, 88, 60), MakeRod(0.9, 0.0, 89, -30)}) {
    const auto slow = NarrowHalfShadeHeight(RodEdge(rod, beam), beam.radius_mm, rod.radius_mm);
    ASSERT_TRUE(slow.has_value());
    const auto fast = TriggerOf(rod, beam);
    ASSERT_TRUE(fast.ok()) << fast.status();
    EXPECT_NEAR(fast->height_mm, slow->height_mm / std::cos(beam.pitch_rad), 1e-11);
    EXPECT_NEAR(slow->shade.area_mm2, HalfDiscMm2(0.2), 1e-12);
    EXPECT_NEAR(slow->shade.arc_rad, std::numbers::pi, 0.1);
  }
}

// Square and sharp in an aligned beam: the strip |y| < R_r of the disc is cut by z = Zd; its area has a closed form.
TEST(RodTrigger, ARodNarrowerThanTheBeamSinksDeeper) {
  const double beam_mm = 0.2, rod_mm = 0.1;
  const auto trigger = TriggerOf(MakeRod(rod_mm, 0.0, 90, 0), MakeBeam(beam_mm, 0, 0));
  ASSERT_TRUE(trigger.ok()) << trigger.status();
  const double chord_mm2 = 0.5 * StripMm2(beam_mm, rod_mm) - 2.0 * rod_mm * trigger->height_mm;
  EXPECT_NEAR(chord_mm2, HalfDiscMm2(beam_mm), 1e-12);
  EXPECT_LT(trigger->height_mm, -0.1);
  EXPECT_NEAR(trigger->area_mm2, HalfDiscMm2(beam_mm), 1e-12);
}

TEST(RodTrigger, DerivativesAreThoseOfTheHeight) {
  const double kStep = 1e-5;
  struct Case {
    Rod rod;
    Beam beam;
  };
  for (const Case& c : {Case{MakeRod(5, 0.03, 88.041, 144.086), MakeBeam(0.2, 0.6241, 0.2836)},
                        Case{MakeRod(6, 1, 87.5, 30), MakeBeam(0.2, 0.35, 0.2)},
                        Case{MakeRod(0.22, 0.05, 89, 20), MakeBeam(0.2, 0.35, 0.8)}}) {
    const auto trigger = TriggerOf(c.rod, c.beam);
    ASSERT_TRUE(trigger.ok()) << trigger.status();
    for (int input = 0; input < kTriggerInputs; ++input) {
      const auto moved = [&](double step) {
        Rod rod = c.rod;
        Beam beam = c.beam;
        double* const fields[] = {&beam.radius_mm, &beam.yaw_rad, &beam.pitch_rad, &rod.radius_mm,
                                  &rod.fillet_mm,  &rod.face_rad, &rod.azimuth_rad};
        *fields[input] += step;
        return TriggerOf(rod, beam)->height_mm;
      };
      const double numeric = (moved(kStep) - moved(-kStep)) / (2.0 * kStep);
      // Second differences; the derivative by a radius has a root at the shadow's end where the rod is narrow.
      const double tolerance = c.rod.radius_mm < 1.0 ? 3e-5 : 2e-6;
      EXPECT_NEAR(trigger->by_input[input], numeric, tolerance * std::max(1.0, std::abs(numeric))) << input;
    }
  }
}

void ExpectRefused(const Rod& rod, const Beam& beam, const std::string& what) {
  const auto trigger = TriggerOf(rod, beam);
  ASSERT_EQ(trigger.status().code(), absl::StatusCode::kInvalidArgument) << what;
  EXPECT_NE(trigger.status().message().find(what), std::string::npos) << trigger.status().message();
}

TEST(RodTrigger, RefusesWhatIsNoRodOrBeam) {
  const Beam beam = MakeBeam(0.2, 0, 0);
  const double nan = std::nan("");
  ExpectRefused(MakeRod(5, 0.03, -88, 10), beam, "phi = -88 deg, expected 45 to 90");
  ExpectRefused(MakeRod(5, 0.03, 92, 10), beam, "phi = 92 deg, expected 45 to 90");
  ExpectRefused(MakeRod(5, 0.03, 0, 0), beam, "phi = 0 deg");  // Table 2.1 as printed
  ExpectRefused(MakeRod(0, 0, 90, 0), beam, "R_r = 0 mm");
  ExpectRefused(MakeRod(nan, 0, 90, 0), beam, "R_r = nan mm");
  ExpectRefused(MakeRod(5, 5, 90, 0), beam, "R_f = 5 mm");
  ExpectRefused(MakeRod(5, -0.01, 90, 0), beam, "R_f = -0.01 mm");
  ExpectRefused(MakeRod(5, 0, nan, 0), beam, "phi = nan");
  ExpectRefused(MakeRod(5, 0, 90, nan), beam, "tau");
  ExpectRefused(MakeRod(5, 0, 90, 0), MakeBeam(0, 0, 0), "R_l = 0 mm");
  ExpectRefused(MakeRod(5, 0, 90, 0), MakeBeam(0.2, 0, nan), "pitch = nan");
  ExpectRefused(MakeRod(5, 0, 90, 0), MakeBeam(0.2, 90, 0), "yaw = 90 deg");
  ExpectRefused(MakeRod(0.05, 0, 90, 0), beam, "shades at most 31.5 % of a beam of radius 0.2 mm");
}

}  // namespace
}  // namespace axiscal::toolsetter
