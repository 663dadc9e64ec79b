// Fang 2022, ch. 3: length characteristic curves of round-insert mills. Exact values by an independent derivation;
// printed ones come from an edge polygon and a time step of 0.5 to 1 ms, which the agreement demanded allows for.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/units.h"
#include "core/toolsetter/insert_edge.h"
#include "core/toolsetter/length_curve.h"
#include "tests/known_answers/published.h"

namespace axiscal::toolsetter {
namespace {

using known_answers::ExpectPublished;

using base::kDegPerRad;
using base::kRadPerDeg;

constexpr double kExactMm = 2e-8;                                   // digits of Zc
constexpr double kClosedFormMm = 4e-7, kClosedFormOfR4Mm = 5.5e-7;  // what the closed form neglects
constexpr double kCurveMm = 2e-6;                                   // digits of the curve

Cutter Table31() {
  Cutter cutter;
  cutter.id = "table-3.1";
  cutter.tool_radius_mm = 10;
  cutter.insert_radius_mm = 6;
  cutter.inserts = 2;
  cutter.radial_rad = -8 * kRadPerDeg;
  cutter.axial_rad = -5 * kRadPerDeg;
  cutter.clearance_rad = 15 * kRadPerDeg;
  cutter.insert_thickness_mm = 3.97;
  return cutter;
}
CutterRun Example1(double feed_mm_min = 30, double height_mm = 0) { return {4, 0.2, 1000, feed_mm_min, height_mm}; }

std::vector<double> EveryDegree(double step_deg = 1.0) {
  std::vector<double> starts;
  for (int i = 0; i * step_deg < 360.0 - 1e-9; ++i) starts.push_back(i * step_deg * kRadPerDeg);
  return starts;
}

std::vector<CurvePoint> Curve(const CutterRun& run, const std::vector<double>& wear_mm = {0, 0},
                              double step_deg = 1.0) {
  const auto curve = ComputeCurve(Table31(), run, wear_mm, EveryDegree(step_deg));
  EXPECT_TRUE(curve.ok()) << curve.status();
  return curve.ok() ? *curve : std::vector<CurvePoint>(360);
}

bool Lower(const CurvePoint& a, const CurvePoint& b) { return a.height_mm < b.height_mm; }
double HighestDeg(const std::vector<CurvePoint>& curve) {
  return std::max_element(curve.begin(), curve.end(), Lower)->start_rad * kDegPerRad;
}
double LowestDeg(const std::vector<CurvePoint>& curve) {
  return std::min_element(curve.begin(), curve.end(), Lower)->start_rad * kDegPerRad;
}
double HighestMm(const std::vector<CurvePoint>& curve) {
  return std::max_element(curve.begin(), curve.end(), Lower)->height_mm;
}
double LowestMm(const std::vector<CurvePoint>& curve) {
  return std::min_element(curve.begin(), curve.end(), Lower)->height_mm;
}

TEST(FangInserts, TriggerHeightsOfOneInsert) {
  const struct {
    double psi_deg, exact_mm;
  } rows[] = {{60, -0.081025583},   {66, -0.037320423},  {70, -0.020553021},  {72, -0.014755211},
              {75, -0.008519523},   {76, -0.006984495},  {78, -0.004584083},  {82, -0.001893473},
              {86.5, -0.001113881}, {90, -0.001418034},  {95, -0.002339283},  {100, -0.003072231},
              {110, -0.002473601},  {117, -0.001652454}, {120, -0.002391761}, {125, -0.008026257}};
  for (const auto& row : rows) {
    const auto exact = TriggerHeightMm(Table31(), Example1(), row.psi_deg * kRadPerDeg);
    ASSERT_TRUE(exact.has_value());
    EXPECT_NEAR(*exact, row.exact_mm, kExactMm) << row.psi_deg;
    EXPECT_NEAR(*ClosedFormTriggerMm(Table31(), Example1(), row.psi_deg * kRadPerDeg), row.exact_mm, kClosedFormMm);
  }
  Cutter other = Table31();
  other.tool_radius_mm = 8;
  other.insert_radius_mm = 4;
  other.radial_rad = -6 * kRadPerDeg;
  other.axial_rad = 4 * kRadPerDeg;
  CutterRun run = Example1();
  run.offset_mm = 4.2;
  EXPECT_NEAR(*TriggerHeightMm(other, run, 75 * kRadPerDeg), -0.024655896, kExactMm);
  EXPECT_NEAR(*TriggerHeightMm(other, run, 85 * kRadPerDeg), -0.008261460, kExactMm);
  EXPECT_NEAR(*TriggerHeightMm(other, run, 95 * kRadPerDeg), -0.004920804, kExactMm);
  for (const double psi_deg : {75.0, 85.0, 95.0}) {
    EXPECT_NEAR(*ClosedFormTriggerMm(other, run, psi_deg * kRadPerDeg),
                *TriggerHeightMm(other, run, psi_deg * kRadPerDeg), kClosedFormOfR4Mm)
        << psi_deg;
  }
}

// Two maxima: the edge's lowest point crosses the beam twice.
TEST(FangInserts, PeaksOfOneInsert) {
  const auto heights = InsertHeights::Create(Table31(), Example1(), 0.05);
  ASSERT_TRUE(heights.ok()) << heights.status();
  EXPECT_NEAR(heights->peak_rad() * kDegPerRad, 86.4564, 1e-3);
  EXPECT_NEAR(heights->peak_mm(), -0.00111382, 1e-8);
  double second_mm = -1, second_deg = 0;
  for (double psi = 110; psi < 122; psi += 0.01) {
    const double height_mm = heights->At(psi * kRadPerDeg);
    if (height_mm > second_mm) second_mm = height_mm, second_deg = psi;
  }
  EXPECT_NEAR(second_mm, -0.0016310, 1e-7);
  EXPECT_NEAR(second_deg, 116.3, 0.05);
  // The cubic between tabulated values against the exact solution.
  for (double psi = 70.03; psi < 124; psi += 1.37)
    EXPECT_NEAR(heights->At(psi * kRadPerDeg), *TriggerHeightMm(Table31(), Example1(), psi * kRadPerDeg), 1e-9);
}

// The published length is not corrected for the beam's radius: even the peak reads R_l^2 / (6 R) low.
TEST(FangInserts, EvenThePeakReadsLow) {
  EXPECT_NEAR(-HighestMm(Curve(Example1())), 0.2 * 0.2 / (6 * 6), 1.5e-5);
  EXPECT_GT(-HighestMm(Curve(Example1())), 1.0e-3);
}

TEST(FangInserts, Example1Curve) {
  const std::vector<CurvePoint> curve = Curve(Example1());
  const struct {
    int start_deg, insert;
    double height_mm;
  } rows[] = {{0, 0, -0.006371},  {45, 0, -0.002919},  {73, 0, -0.001114},
              {98, 1, -0.012897}, {120, 1, -0.011132}, {160, 1, -0.007946}};
  for (const auto& row : rows) {
    EXPECT_NEAR(curve[row.start_deg].height_mm, row.height_mm, kCurveMm) << row.start_deg;
    EXPECT_EQ(curve[row.start_deg].insert, row.insert) << row.start_deg;
  }
  const std::vector<CurvePoint> slow = Curve(Example1(10));
  EXPECT_NEAR(slow[0].height_mm, -0.002255, kCurveMm);
  EXPECT_NEAR(slow[45].height_mm, -0.001131, kCurveMm);
  EXPECT_NEAR(slow[120].height_mm, -0.003855, kCurveMm);
  EXPECT_NEAR(HighestMm(Curve(Example1(10), {0, 0}, 0.01)), -0.001114, kCurveMm);
  EXPECT_NEAR(LowestMm(Curve(Example1(10), {0, 0}, 0.01)), -0.005538, kCurveMm);
}

TEST(FangInserts, PrintedExtremesOfExample1) {
  constexpr double kPrintedMm = 0.0007, kPrintedDeg = 5.0;  // polygon and time step
  const std::vector<CurvePoint> curve = Curve(Example1());
  EXPECT_NEAR(HighestMm(curve), -0.0014, kPrintedMm);
  EXPECT_NEAR(LowestMm(curve), -0.0135, kPrintedMm);
  // The curve repeats after 180 deg; the first of both is printed.
  EXPECT_NEAR(std::fmod(HighestDeg(curve), 180.0), 69, kPrintedDeg);
  EXPECT_NEAR(std::fmod(LowestDeg(curve), 180.0), 94, kPrintedDeg);
  const double lowest_deg = std::fmod(LowestDeg(Curve(Example1(), {0, 0}, 0.01)), 180.0);
  EXPECT_NEAR(lowest_deg, 97.21, 0.02);
  EXPECT_NEAR(LowestMm(Curve(Example1(), {0, 0}, 0.01)), -0.012961, kCurveMm);
  const double apart_deg = std::fmod(LowestDeg(curve) - HighestDeg(curve) + 360.0, 180.0);
  EXPECT_NEAR(apart_deg, 25, 1);  // the other sense of rotation would give 1
  for (int i = 0; i < 180; ++i) EXPECT_NEAR(curve[i].height_mm, curve[i + 180].height_mm, 1e-9);
  EXPECT_NEAR(curve[0].height_mm, -0.0065, 0.0002);
  const std::vector<CurvePoint> slow = Curve(Example1(10));
  EXPECT_NEAR(HighestMm(slow), -0.0014, kPrintedMm);
  EXPECT_NEAR(LowestMm(slow), -0.0061, kPrintedMm);
}

// A higher start shifts the curve by 360 dh N / v.
TEST(FangInserts, RaisedStartShiftsTheCurve) {
  const std::vector<CurvePoint> curve = Curve(Example1()), raised = Curve(Example1(30, 0.005));
  for (int i = 0; i < 360; ++i) EXPECT_NEAR(raised[i].height_mm, curve[(i + 60) % 360].height_mm, 1e-9) << i;
  EXPECT_NEAR(std::fmod(HighestDeg(raised), 180.0), 13, 1);
  EXPECT_NEAR(std::fmod(HighestDeg(raised), 180.0), 9, 5);  // printed
  EXPECT_NEAR(std::fmod(LowestDeg(raised), 180.0), 38, 1);
  EXPECT_NEAR(std::fmod(LowestDeg(raised), 180.0), 33, 5);  // printed
}

// h of example 1 is 0, not the 1 mm of its text: 1 mm shifts by 12000 deg, a whole number of thirds of a turn.
TEST(FangInserts, StartHeightOfTheText) {
  const std::vector<CurvePoint> text = Curve(Example1(30, 1.0));
  EXPECT_GT(std::abs(text[0].height_mm - -0.0065), 0.002);  // printed -0.0065 is that of h = 0
  EXPECT_NEAR(text[0].height_mm, Curve(Example1())[12000 % 360].height_mm, 1e-9);
}

// The offset is -Y (3.18), not +Y: the same as half a turn, which two inserts do not show and three do.
TEST(FangInserts, OffsetToTheOtherSide) {
  CutterRun wrong = Example1();
  wrong.offset_mm = -4;
  const std::vector<CurvePoint> curve = Curve(Example1());
  EXPECT_NEAR(Curve(wrong)[0].height_mm, curve[0].height_mm, 1e-9);
  Cutter three = Table31();
  three.inserts = 3;
  const std::vector<double> starts = EveryDegree();
  const auto ours = ComputeCurve(three, Example1(), {0, 0, 0}, starts);
  const auto other = ComputeCurve(three, wrong, {0, 0, 0}, starts);
  ASSERT_TRUE(ours.ok() && other.ok());
  EXPECT_NEAR((*other)[0].height_mm, (*ours)[180].height_mm, 1e-9);
  EXPECT_GT(std::abs((*other)[0].height_mm - (*ours)[0].height_mm), 0.002);
}

TEST(FangInserts, ShadingWhileTheToolSinks) {
  const struct {
    double height_mm, share;
  } rows[] = {{-0.0025, 0.0}, {-0.005, 0.268}, {-0.0065, 0.506}, {-0.006371, 0.5}};
  for (const auto& row : rows) {
    const double psi_deg = -row.height_mm / 0.03 * 360.0;
    EXPECT_NEAR(ShadedShare(Table31(), Example1(), psi_deg * kRadPerDeg, row.height_mm), row.share, 0.001);
  }
}

TEST(FangInserts, Example2PeaksDifferByTheWear) {
  const std::vector<CurvePoint> curve = Curve(Example1(), {0, 0.005}, 0.01);
  double first_mm = -1, second_mm = -1, first_deg = 0, second_deg = 0;
  int fired = 0;
  for (const CurvePoint& point : curve) {
    double& best_mm = point.insert == 0 ? first_mm : second_mm;
    if (point.height_mm > best_mm) {
      best_mm = point.height_mm;
      (point.insert == 0 ? first_deg : second_deg) = point.start_rad * kDegPerRad;
    }
    fired += point.insert == 1;
  }
  EXPECT_NEAR(first_mm - second_mm, 0.00500, 1e-6);
  EXPECT_NEAR(first_deg, 73, 1);
  EXPECT_NEAR(std::fmod(second_deg, 360.0), 193, 1);
  EXPECT_NEAR(LowestMm(curve), -0.017806, kCurveMm);
  EXPECT_NEAR(fired * 0.01, 120, 1.5);  // degrees on which the worn insert fires first
}

// Up to some 2 um before an insert stops firing (W = f, 15 um) its peak shows its whole wear; then the other's hump
// cuts it, by half a micrometre at most.
TEST(FangInserts, APeakIsCutBeforeItVanishes) {
  const auto reads_low_mm = [](double wear_mm) {
    double peak_mm = -1;
    for (const CurvePoint& point : Curve(Example1(), {0, wear_mm}, 0.01)) {
      if (point.insert == 1) peak_mm = std::max(peak_mm, point.height_mm);
    }
    return -0.00111382 - wear_mm - peak_mm;
  };
  for (const double wear_mm : {0.005, 0.010, 0.013}) EXPECT_NEAR(reads_low_mm(wear_mm), 0.0, 1e-6) << wear_mm;
  EXPECT_GT(reads_low_mm(0.0148), 1e-4);
  EXPECT_LT(reads_low_mm(0.0148), 5.5e-4);
  EXPECT_GT(reads_low_mm(0.0151), 0.5);  // it fires nowhere
}

// The printed heights are lower because of 300 chords (0.00022 lower) and a time step of 0.93 ms whose first step below
// fires: a comparison only.
TEST(FangInserts, PublishedPolygonAndTimeStep) {
  const auto heights = InsertHeights::Create(Table31(), Example1(), 0.06);
  ASSERT_TRUE(heights.ok());
  const auto stepped = [&](double feed, double start_height_mm) {
    double least = -1, most = 1, first = NAN;
    const double dt_min = 0.93e-3 / 60.0;
    for (int start = 0; start < 360; ++start) {
      for (int step = 0;; ++step) {
        const double turned = step * dt_min * 1000.0 * 360.0, z = start_height_mm - step * dt_min * feed;
        const double psi = (start + turned) * kRadPerDeg;
        const double envelope = std::max(heights->At(psi), heights->At(psi + std::numbers::pi)) - 0.00022;
        if (z > envelope) continue;
        least = std::max(least, z);
        most = std::min(most, z);
        if (start == 0) first = z;
        break;
      }
    }
    return std::array<double, 3>{least, most, first};
  };
  const auto fast = stepped(30, 0), slow = stepped(10, 0);
  constexpr double kPrintedMm = 2e-4;  // of its own last digits and step
  const std::string example = "Fang 2022, ch. 3, example 1 with its chords and time step: ";
  ExpectPublished(fast[0], -0.0014, kPrintedMm, example + "highest at 30 mm/min, mm");
  ExpectPublished(fast[1], -0.0135, kPrintedMm, example + "lowest at 30 mm/min, mm");
  ExpectPublished(fast[2], -0.0065, kPrintedMm, example + "at start 0, 30 mm/min, mm");
  ExpectPublished(slow[0], -0.0014, kPrintedMm, example + "highest at 10 mm/min, mm");
  ExpectPublished(slow[1], -0.0061, kPrintedMm, example + "lowest at 10 mm/min, mm");
}

}  // namespace
}  // namespace axiscal::toolsetter
