#include "core/toolsetter/insert_heights.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "core/base/units.h"
#include "core/toolsetter/insert_edge.h"
#include "core/toolsetter/length_curve.h"

namespace axiscal::toolsetter {
namespace {

using base::kDegPerRad;
using base::kRadPerDeg;
using ::testing::HasSubstr;

Cutter Table31(int inserts = 2) {
  Cutter cutter;
  cutter.tool_radius_mm = 10;
  cutter.insert_radius_mm = 6;
  cutter.inserts = inserts;
  cutter.radial_rad = -8 * kRadPerDeg;
  cutter.axial_rad = -5 * kRadPerDeg;
  cutter.clearance_rad = 15 * kRadPerDeg;
  cutter.insert_thickness_mm = 3.97;
  return cutter;
}
CutterRun RunAt(double offset_mm) { return {offset_mm, 0.2, 1000, 30, 0.01}; }

// The slow obvious twin: Zc at angles all round, one by one.
class AllRound {
 public:
  AllRound(const Cutter& cutter, const CutterRun& run, int angles) : cutter_(cutter), run_(run) {
    for (int i = 0; i < angles; ++i) {
      constexpr double kNone = -std::numeric_limits<double>::infinity();
      heights_mm_.push_back(TriggerHeightMm(cutter, run, kTurn * i / angles).value_or(kNone));
    }
  }

  // By how much the envelope stands above the falling tool at any angle before `point`, mm; negative: nothing fires.
  double FiresBefore(const std::vector<double>& wear_mm, const CurvePoint& point) const {
    const double step = kTurn / static_cast<double>(heights_mm_.size()), sinks_mm = run_.feed_per_turn_mm() / kTurn;
    double most_mm = -std::numeric_limits<double>::infinity();
    const double from = std::max(0.0, point.turned_rad - kTurn);  // a turn before it the tool stood higher all along
    for (int k = 0; k < cutter_.inserts; ++k) {
      const double start = point.start_rad + cutter_.theta_t_rad + cutter_.InsertAngle(k);
      const auto last = static_cast<long>(std::floor((start + point.turned_rad) / step));
      for (long i = static_cast<long>(std::ceil((start + from) / step)); i <= last; ++i) {
        const long count = static_cast<long>(heights_mm_.size());
        const double z_mm = run_.start_height_mm - sinks_mm * (i * step - start);
        most_mm = std::max(most_mm, heights_mm_[((i % count) + count) % count] - wear_mm[k] - z_mm);
      }
    }
    return most_mm;
  }

 private:
  const Cutter& cutter_;
  const CutterRun& run_;
  std::vector<double> heights_mm_;
};

// Fires where it is said to, and nowhere before.
void ExpectFirstTrigger(const Cutter& cutter, const CutterRun& run, const AllRound& all_round,
                        const std::vector<double>& wear_mm, const CurvePoint& point) {
  constexpr double kOffMm = 2e-8;
  const double psi = point.start_rad + cutter.theta_t_rad + point.turned_rad + cutter.InsertAngle(point.insert);
  const auto fired_mm = TriggerHeightMm(cutter, run, psi);
  ASSERT_TRUE(fired_mm.has_value());
  EXPECT_NEAR(point.height_mm, *fired_mm - wear_mm[point.insert], kOffMm);
  EXPECT_LT(all_round.FiresBefore(wear_mm, point), kOffMm);
}

TEST(InsertHeights, TheSecondCrossingCountsAtEveryOffset) {
  const Cutter cutter = Table31();
  std::vector<double> starts;
  for (int i = 0; i < 72; ++i) starts.push_back((5 * i + 3) * kRadPerDeg);
  for (const double offset_mm : {0.6, 1.0, 2.0, 2.5, 3.0, 3.4, 3.8, 4.0, 4.1, -3.0}) {
    const CutterRun run = RunAt(offset_mm);
    const AllRound all_round(cutter, run, 7200);
    const std::vector<double> wear_mm = {0.006, 0.0};
    const auto curve = ComputeCurve(cutter, run, wear_mm, starts);
    ASSERT_TRUE(curve.ok()) << offset_mm << ": " << curve.status();
    for (const CurvePoint& point : *curve) ExpectFirstTrigger(cutter, run, all_round, wear_mm, point);
  }
  CutterRun run = RunAt(3.0);
  run.start_height_mm = 0.0;
  EXPECT_NEAR((*ComputeCurve(cutter, run, {0, 0}, {43 * kRadPerDeg}))[0].height_mm, -8.35e-3, 0.01e-3);
}

// Cutters of all sizes at all offsets: what has an answer has the right one, and most have.
TEST(InsertHeights, AgreesWithAllAnglesOnRandomCutters) {
  std::mt19937 random(25);
  const auto between = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) + 0.5) / 4294967296.0;
  };
  constexpr int kCutters = 60;
  int answered = 0;
  for (int i = 0; i < kCutters; ++i) {
    Cutter cutter;
    cutter.insert_radius_mm = between(2, 10);
    cutter.tool_radius_mm = cutter.insert_radius_mm * between(1.1, 6);
    cutter.inserts = 1 + static_cast<int>(between(0, 6));
    cutter.radial_rad = between(-12, 8) * kRadPerDeg;
    cutter.axial_rad = between(-9, 9) * kRadPerDeg;
    cutter.clearance_rad = 20 * kRadPerDeg;
    cutter.theta_t_rad = between(-180, 180) * kRadPerDeg;
    if (i % 3 == 0) {
      for (int k = 0; k < cutter.inserts; ++k)
        cutter.insert_angles_rad.push_back(k == 0 ? 0.0 : kTurn * (k + between(-0.2, 0.2)) / cutter.inserts);
    }
    const double reach_mm = BottomRadiusMm(cutter);
    const CutterRun run{between(-1, 1) * reach_mm, between(0.02, 0.25), 1000, between(3, 60), 0.05};
    std::vector<double> wear_mm, starts;
    for (int k = 0; k < cutter.inserts; ++k) wear_mm.push_back(between(0, 0.01));
    for (int k = 0; k < 8; ++k) starts.push_back(between(-7, 7));
    const auto curve = ComputeCurve(cutter, run, wear_mm, starts);
    if (!curve.ok()) {
      EXPECT_THAT(std::string(curve.status().message()), HasSubstr("expected a")) << curve.status();
      continue;
    }
    ++answered;
    SCOPED_TRACE(absl::StrFormat("cutter %d: r %g, R %g, offset %g", i, cutter.tool_radius_mm, cutter.insert_radius_mm,
                                 run.offset_mm));
    const AllRound all_round(cutter, run, 3600);
    for (const CurvePoint& point : *curve) ExpectFirstTrigger(cutter, run, all_round, wear_mm, point);
  }
  EXPECT_GT(answered, kCutters / 2);
}

// An insert that reaches across a part of the beam only does not tell by its cutting edge when it fires: no number
// where it might be the first, as with a large feed. With a small one another crossing comes before it.
TEST(InsertHeights, AnAngleThatTheEdgeDoesNotTellIsRefused) {
  CutterRun run = RunAt(1.0);
  EXPECT_TRUE(HeightsOf(Table31(), run).ok());
  run.feed_mm_min = 300;
  const std::string partly(HeightsOf(Table31(), run).status().message());
  EXPECT_THAT(partly,
              HasSubstr("offset_d_mm = 1, feed_mm_min / spindle_rpm = 0.3 mm: at a spindle angle of 175.8 deg"));
  run.offset_mm = 1.4;
  EXPECT_THAT(std::string(HeightsOf(Table31(), run).status().message()),
              HasSubstr("at a spindle angle of 18.2 deg the flank stands"));
}

// A face mill, whose inserts pass the beam within a fraction of a degree.
TEST(InsertHeights, LargeToolsAreTabulatedFiner) {
  Cutter cutter = Table31(6);
  cutter.tool_radius_mm = 160;
  const CutterRun run{120, 0.2, 1000, 30, 0.01};
  const auto curve = ComputeCurve(cutter, run, std::vector<double>(6, 0.0), {0.1, 1.3, 2.2, 4.9});
  ASSERT_TRUE(curve.ok()) << curve.status();
  const AllRound all_round(cutter, run, 72000);
  for (const CurvePoint& point : *curve) ExpectFirstTrigger(cutter, run, all_round, std::vector<double>(6, 0.0), point);
}

// Below its reach another insert's second crossing takes over: less wear is seen than the feed alone would show, and
// none at offset 0, where an insert right opposite gives the same readings.
TEST(UnseenFrom, FallsWithTheOffset) {
  const Cutter cutter = Table31();
  std::vector<double> starts;
  for (int i = 0; i < 14400; ++i) starts.push_back(0.025 * i * kRadPerDeg);
  const auto fires = [&](const CutterRun& run, double wear_mm) {
    const auto curve = ComputeCurve(cutter, run, {0.0, wear_mm}, starts).value();
    return std::any_of(curve.begin(), curve.end(), [](const CurvePoint& point) { return point.insert == 1; });
  };
  double before_mm = 1.0;
  for (const double offset_mm : {4.0, 0.5, 0.03, 0.01, 0.001}) {
    const CutterRun run = RunAt(offset_mm);
    const std::vector<double> unseen_mm = UnseenFromMm(HeightsOf(cutter, run).value(), cutter, run);
    EXPECT_NEAR(unseen_mm[0], unseen_mm[1], 1e-9);
    if (offset_mm == 4.0) {
      EXPECT_NEAR(unseen_mm[0], 0.015, 1e-9);
    }
    EXPECT_LE(unseen_mm[1], before_mm + 1e-9);
    EXPECT_TRUE(fires(run, 0.9 * unseen_mm[1])) << offset_mm;
    EXPECT_FALSE(fires(run, unseen_mm[1] + 2e-5)) << offset_mm;
    before_mm = unseen_mm[1];
  }
  EXPECT_LT(before_mm, 0.001);
  const CutterRun centred = RunAt(0.0);
  const auto heights = HeightsOf(cutter, centred);
  ASSERT_TRUE(heights.ok()) << heights.status();
  const absl::Status apart = CheckInsertsApart(*heights, cutter, centred, 1e-3);
  EXPECT_EQ(apart.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(apart.message()), HasSubstr("offset_d_mm = 0: inserts cannot be told apart"));
  EXPECT_TRUE(CheckInsertsApart(HeightsOf(Table31(3), centred).value(), Table31(3), centred, 1e-3).ok());
}

}  // namespace
}  // namespace axiscal::toolsetter
