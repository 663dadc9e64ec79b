#include "core/toolsetter/length_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/units.h"
#include "core/toolsetter/insert_edge.h"

namespace axiscal::toolsetter {
namespace {

using base::kDegPerRad;
using base::kRadPerDeg;

Cutter MakeCutter(int inserts) {
  Cutter cutter;
  cutter.tool_radius_mm = 12;
  cutter.insert_radius_mm = 5;
  cutter.inserts = inserts;
  cutter.radial_rad = -8 * kRadPerDeg;
  cutter.axial_rad = -5 * kRadPerDeg;
  cutter.clearance_rad = 15 * kRadPerDeg;
  cutter.insert_thickness_mm = 3.97;
  return cutter;
}
const CutterRun kRun{7, 0.2, 500, 30, 1};

// The slow obvious twin: a small step down at a time until an insert shades half.
double SteppedHeight(const Cutter& cutter, const CutterRun& run, const std::vector<double>& wear_mm, double start_rad) {
  const auto heights = InsertHeights::Create(cutter, run, LengthCurve::DepthMm(run));
  double step = 1e-5 * kRadPerDeg, turned = 0.0;
  // Nothing fires above the peak.
  turned =
      std::max(0.0, (run.start_height_mm - heights->peak_mm() - 1e-6) / run.feed_per_turn_mm()) * 2 * std::numbers::pi;
  while (true) {
    const double z_mm = run.start_height_mm - run.feed_per_turn_mm() * turned / (2 * std::numbers::pi);
    double nearest_mm = 1e9;
    for (int k = 0; k < cutter.inserts; ++k) {
      const double psi = start_rad + cutter.theta_t_rad + turned + cutter.InsertAngle(k);
      const double miss_mm = z_mm - (heights->At(psi) - wear_mm[k]);
      if (miss_mm <= 0.0) return z_mm;
      nearest_mm = std::min(nearest_mm, miss_mm);
    }
    step = nearest_mm > 1e-3 ? 1e-2 * kRadPerDeg : nearest_mm > 1e-5 ? 1e-3 * kRadPerDeg : 1e-5 * kRadPerDeg;
    turned += step;
  }
}

TEST(LengthCurve, AgreesWithTheSteppedTwin) {
  Cutter uneven = MakeCutter(3);
  uneven.insert_angles_rad = {0, 110 * kRadPerDeg, 250 * kRadPerDeg};
  uneven.theta_t_rad = 20 * kRadPerDeg;
  const std::vector<double> starts = {0.0, 0.7, 1.9, 3.3, 4.1, 5.8};
  for (const Cutter& cutter : {MakeCutter(1), MakeCutter(3), uneven}) {
    std::vector<double> wear_mm(cutter.inserts, 0.002);
    wear_mm[0] = 0.005;
    const auto curve = ComputeCurve(cutter, kRun, wear_mm, starts);
    ASSERT_TRUE(curve.ok()) << curve.status();
    for (size_t i = 0; i < starts.size(); ++i)
      EXPECT_NEAR((*curve)[i].height_mm, SteppedHeight(cutter, kRun, wear_mm, starts[i]), 5e-8) << i;
  }
}

TEST(LengthCurve, TheOrderOfStartsDoesNotMatter) {
  const Cutter cutter = MakeCutter(3);
  const auto mixed = ComputeCurve(cutter, kRun, {0, 0.006, 0.01}, {5.0, 0.1, 7.0, -1.0, 0.1 + 2 * std::numbers::pi});
  ASSERT_TRUE(mixed.ok());
  for (const CurvePoint& point : *mixed) {
    const auto alone = ComputeCurve(cutter, kRun, {0, 0.006, 0.01}, {point.start_rad});
    EXPECT_NEAR((*alone)[0].height_mm, point.height_mm, 1e-11);
  }
  EXPECT_NEAR((*mixed)[1].height_mm, (*mixed)[4].height_mm, 1e-11);
}

TEST(LengthCurve, DerivativesAreThoseOfTheCurve) {
  const Cutter cutter = MakeCutter(3);
  const auto heights = HeightsOf(cutter, kRun);
  ASSERT_TRUE(heights.ok()) << heights.status();
  const std::vector<double> wear_mm = {0, 0.006, 0.01};
  constexpr double kStep = 1e-5;
  const double starts[] = {0.3, 1.0, 2.2, 4.9};
  for (const double start : starts) {
    const auto at = [&](double s, std::vector<double> w) {
      return LengthCurve(*heights, cutter, kRun, std::move(w)).At({s})[0];
    };
    const CurvePoint point = at(start, wear_mm);
    EXPECT_NEAR(point.by_start,
                (at(start + kStep, wear_mm).height_mm - at(start - kStep, wear_mm).height_mm) / (2 * kStep), 1e-6);
    std::vector<double> more = wear_mm, less = wear_mm;
    more[point.insert] += 1e-6;
    less[point.insert] -= 1e-6;
    EXPECT_NEAR(point.by_wear, (at(start, more).height_mm - at(start, less).height_mm) / 2e-6, 1e-3);
  }
}

// Insert k fires first on (360 / n)(1 - (W_k - W_before) / f) degrees of the starts; from W = f on it is not seen.
TEST(LengthCurve, WearNarrowsTheShareOfStarts) {
  const Cutter cutter = MakeCutter(2);
  std::vector<double> starts;
  for (int i = 0; i < 3600; ++i) starts.push_back(0.1 * i * kRadPerDeg);
  const double f_mm = kRun.feed_per_insert_mm(cutter);
  EXPECT_NEAR(f_mm, 0.03, 1e-12);
  for (const double share : {0.0, 0.25, 0.5, 0.75, 0.9, 1.0, 1.2}) {
    const auto curve = ComputeCurve(cutter, kRun, {0, share * f_mm}, starts);
    ASSERT_TRUE(curve.ok());
    double fired_deg = 0.0;
    for (const CurvePoint& point : *curve) fired_deg += point.insert == 1 ? 0.1 : 0.0;
    EXPECT_NEAR(fired_deg, std::max(0.0, 180.0 * (1.0 - share)), 7.0) << share;
    if (share >= 1.0) {
      EXPECT_EQ(fired_deg, 0.0);
    }
  }
}

void ExpectRefused(const Cutter& cutter, const CutterRun& run, const std::vector<double>& wear_mm,
                   const std::string& what) {
  const auto curve = ComputeCurve(cutter, run, wear_mm, {0.0});
  ASSERT_EQ(curve.status().code(), absl::StatusCode::kInvalidArgument) << what;
  EXPECT_NE(curve.status().message().find(what), std::string::npos) << curve.status().message();
}

TEST(LengthCurve, RefusesWithWhatWasExpected) {
  const Cutter cutter = MakeCutter(2);
  const auto with = [&](auto change) {
    Cutter changed = cutter;
    change(changed);
    return changed;
  };
  const auto run_with = [&](auto change) {
    CutterRun changed = kRun;
    change(changed);
    return changed;
  };
  ExpectRefused(with([](Cutter& c) { c.insert_radius_mm = 0; }), kRun, {0, 0}, "insert_radius_mm = 0, expected 0.1");
  ExpectRefused(with([](Cutter& c) { c.tool_radius_mm = NAN; }), kRun, {0, 0}, "tool_radius_mm = nan");
  ExpectRefused(with([](Cutter& c) { c.inserts = 0; }), kRun, {}, "inserts = 0");
  ExpectRefused(with([](Cutter& c) { c.insert_angles_rad = {0, 1e-4}; }), kRun, {0, 0}, "one insert per angle");
  ExpectRefused(with([](Cutter& c) {
                  c.insert_angles_rad = {0, 2 * std::numbers::pi};
                }),
                kRun, {0, 0}, "inserts 1 and 2");
  ExpectRefused(with([](Cutter& c) { c.insert_angles_rad = {0}; }), kRun, {0, 0}, "1 angles, expected 2");
  ExpectRefused(with([](Cutter& c) {
                  c.insert_angles_rad = {1, 2};
                }),
                kRun, {0, 0}, "expected 0: angles count from insert 1");
  ExpectRefused(with([](Cutter& c) { c.axial_rad = 30 * kRadPerDeg, c.clearance_rad = 0; }), kRun, {0, 0},
                "the flank stands");
  ExpectRefused(cutter, run_with([](CutterRun& r) { r.offset_mm = 20; }), {0, 0}, "no insert reaches across the beam");
  ExpectRefused(cutter, run_with([](CutterRun& r) { r.beam_radius_mm = 0; }), {0, 0}, "beam_radius_mm = 0");
  ExpectRefused(cutter, run_with([](CutterRun& r) { r.beam_radius_mm = 2; }), {0, 0}, "a fifth of insert_radius_mm");
  ExpectRefused(cutter, run_with([](CutterRun& r) { r.spindle_rpm = 0; }), {0, 0}, "spindle_rpm = 0");
  ExpectRefused(cutter, run_with([](CutterRun& r) { r.feed_mm_min = -30; }), {0, 0}, "feed_mm_min = -30");
  ExpectRefused(cutter, run_with([](CutterRun& r) { r.feed_mm_min = 1e5; }), {0, 0}, "expected a smaller feed");
  ExpectRefused(cutter, run_with([](CutterRun& r) { r.start_height_mm = -1; }), {0, 0},
                "shades the beam there already");
  ExpectRefused(cutter, kRun, {0, 5.0}, "wear_mm: 5 of insert 2, expected 0 or more and less than the insert's radius");
  ExpectRefused(cutter, kRun, {0, -0.001}, "wear_mm: -0.001");
  ExpectRefused(cutter, kRun, {0, NAN}, "wear_mm: nan");
  ExpectRefused(cutter, kRun, {0}, "1 numbers, expected 2");
}

}  // namespace
}  // namespace axiscal::toolsetter
