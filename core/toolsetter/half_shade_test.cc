#include "core/toolsetter/half_shade.h"

#include <gtest/gtest.h>

#include <random>

#include "core/base/units.h"
#include "core/toolsetter/insert_edge.h"
#include "core/toolsetter/testing/slow_half_shade.h"

namespace axiscal::toolsetter {
namespace {

using base::kRadPerDeg;

constexpr double kTwinMm = 1e-10;  // what bisecting and searching leave; the product's claim is 1e-8

class Draws {
 public:
  double Between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  bool IsOneIn(int n) { return random_() % static_cast<unsigned>(n) == 0; }

 private:
  std::mt19937 random_{20};
};

TEST(HalfShade, AgreesWithTheSlowTwinOnRandomRods) {
  Draws draws;
  for (int i = 0; i < 25; ++i) {
    const Beam beam{std::pow(10.0, draws.Between(-2.0, 0.0)), draws.Between(-20, 20) * kRadPerDeg,
                    draws.Between(-20, 20) * kRadPerDeg};
    Rod rod;
    const double rho_mm = beam.radius_mm * std::pow(10.0, draws.Between(0.2, 1.7));
    rod.fillet_mm = draws.IsOneIn(4) ? 0.0 : rho_mm * std::pow(10.0, draws.Between(-3.0, 0.5));
    rod.radius_mm = rho_mm + rod.fillet_mm;
    if (!draws.IsOneIn(4)) rod.face_rad = draws.Between(45, 90) * kRadPerDeg;
    if (draws.IsOneIn(2)) rod.face_rad = draws.Between(87, 90) * kRadPerDeg;
    rod.azimuth_rad = draws.Between(-180, 180) * kRadPerDeg;
    rod.holder_rad = draws.Between(-180, 180) * kRadPerDeg;
    SCOPED_TRACE(testing::Message() << "R_l " << beam.radius_mm << " yaw " << beam.yaw_rad << " pitch "
                                    << beam.pitch_rad << " R_r " << rod.radius_mm << " R_f " << rod.fillet_mm
                                    << " phi " << rod.face_rad << " tau " << rod.azimuth_rad + rod.holder_rad);
    const auto trigger = TriggerOf(rod, beam);
    ASSERT_TRUE(trigger.ok()) << trigger.status();
    const double slow_mm = SlowHalfShadeHeight(SlowRodEdge(rod, beam), beam.radius_mm) / std::cos(beam.pitch_rad);
    EXPECT_NEAR(trigger->height_mm, slow_mm, kTwinMm);
    EXPECT_NEAR(trigger->area_mm2, HalfDiscMm2(beam.radius_mm), 1e-12);
  }
}

// A flat face that turns into its fillet within the beam: nearly all of the fillet belongs to feet beside the end of
// the face, so that y goes far where the foot hardly moves.
TEST(HalfShade, AgreesWithTheSlowTwinWhereTheFaceEndsInTheBeam) {
  for (const double pitch_deg : {-2.0, -0.5, 0.02, 0.1, 0.5, 1.0, 2.0}) {
    const Beam beam{0.5, 0.0, pitch_deg * kRadPerDeg};
    Rod rod;
    rod.radius_mm = 3.0;
    rod.fillet_mm = 2.0;
    rod.face_rad = 70.0 * kRadPerDeg;
    rod.azimuth_rad = 90.0 * kRadPerDeg;
    SCOPED_TRACE(testing::Message() << "pitch " << pitch_deg);
    const auto trigger = TriggerOf(rod, beam);
    ASSERT_TRUE(trigger.ok()) << trigger.status();
    const double slow_mm = SlowHalfShadeHeight(SlowRodEdge(rod, beam), beam.radius_mm, 40) / std::cos(beam.pitch_rad);
    EXPECT_NEAR(trigger->height_mm, slow_mm, 1e-8);  // what the product claims
  }
}

TEST(HalfShade, AgreesWithTheSlowTwinOnRandomInserts) {
  Draws draws;
  int compared = 0;
  while (compared < 25) {
    Cutter cutter;
    cutter.insert_radius_mm = draws.Between(2, 12);
    cutter.tool_radius_mm = cutter.insert_radius_mm + draws.Between(0, 30);
    cutter.inserts = 1;
    cutter.radial_rad = draws.Between(-20, 20) * kRadPerDeg;
    cutter.axial_rad = draws.Between(-20, 20) * kRadPerDeg;
    CutterRun run;
    run.beam_radius_mm = std::pow(10.0, draws.Between(-2.0, -0.5));
    run.offset_mm = draws.Between(-1, 1) * cutter.tool_radius_mm;
    const double psi_rad = draws.Between(0, 360) * kRadPerDeg;
    // Near its ends the edge is steep, and 16 points tell less of it.
    if (!InsertEdge(cutter, run.offset_mm, psi_rad).Spans(2.0 * run.beam_radius_mm)) continue;
    const auto height_mm = TriggerHeightMm(cutter, run, psi_rad);
    if (!height_mm) continue;
    ++compared;
    SCOPED_TRACE(testing::Message() << "R_l " << run.beam_radius_mm << " d " << run.offset_mm << " psi " << psi_rad
                                    << " r " << cutter.tool_radius_mm << " R " << cutter.insert_radius_mm);
    EXPECT_NEAR(*height_mm,
                SlowHalfShadeHeight(SlowInsertEdge(cutter, run.offset_mm, psi_rad), run.beam_radius_mm), kTwinMm);
  }
}

}  // namespace
}  // namespace axiscal::toolsetter
