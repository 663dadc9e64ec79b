// Trigger heights of measuring rods (goal: 10 us with the exact area), a length characteristic curve of 360 points (10
// ms), the reference point from nine readouts, and length and wear from twelve readings.
#include <benchmark/benchmark.h>

#include "core/base/demand.h"
#include "core/base/units.h"
#include "core/toolsetter/length_curve.h"
#include "core/toolsetter/reference.h"
#include "core/toolsetter/wear.h"

namespace axiscal::toolsetter {
namespace {

using base::kRadPerDeg;

const Beam kBeam{0.2, 0.6241 * kRadPerDeg, 0.2836 * kRadPerDeg};
const Rod kRod2{5, 0.03, 88.041 * kRadPerDeg, 144.086 * kRadPerDeg, 179.822, 0};

void TriggerHeight(benchmark::State& state) {
  Rod rod = kRod2;
  for (auto _ : state) {
    rod.azimuth_rad += 1e-6;
    const auto trigger = TriggerOf(rod, kBeam);
    DEMAND(trigger.ok() && std::abs(trigger->area_mm2 - 0.0628318530718) < 1e-9);
    benchmark::DoNotOptimize(trigger->height_mm);
  }
  state.counters["goal us"] = 10;
}
BENCHMARK(TriggerHeight)->Unit(benchmark::kMicrosecond);

Cutter Table31() {
  Cutter cutter;
  cutter.tool_radius_mm = 10;
  cutter.insert_radius_mm = 6;
  cutter.inserts = 2;
  cutter.radial_rad = -8 * kRadPerDeg;
  cutter.axial_rad = -5 * kRadPerDeg;
  return cutter;
}
const CutterRun kRun{4, 0.2, 1000, 30, 0};

void Curve360(benchmark::State& state) {
  std::vector<double> starts;
  for (int i = 0; i < 360; ++i) starts.push_back(i * kRadPerDeg);
  for (auto _ : state) {
    const auto curve = ComputeCurve(Table31(), kRun, {0, 0.005}, starts);
    DEMAND(curve.ok());
    benchmark::DoNotOptimize(curve->data());
  }
  state.counters["goal ms"] = 10;
}
BENCHMARK(Curve360)->Unit(benchmark::kMillisecond);

void ReferenceOfThreeRods(benchmark::State& state) {
  RodSession session;
  session.sigma_mm = 0.5e-3;
  session.beam = kBeam;
  const double z_mm[] = {-376.137, -349.258, -329.932};
  const Rod rods[] = {
      {5, 0.03, Rod().face_rad, 0, 133.702, 0}, {5, 0.03, 89.922 * kRadPerDeg, 127.71 * kRadPerDeg, 160.591, 0}, kRod2};
  for (int i = 0; i < 3; ++i) session.rods.push_back({std::to_string(i), rods[i], {}, {z_mm[i], z_mm[i], z_mm[i]}});
  for (auto _ : state) {
    const auto reference = FitReference(session, {false, true});
    DEMAND(reference.ok());
    benchmark::DoNotOptimize(reference->range_mm);
  }
}
BENCHMARK(ReferenceOfThreeRods)->Unit(benchmark::kMillisecond);

void WearFromTwelveReadings(benchmark::State& state) {
  CurveSession session;
  session.sigma_mm = 1e-3;
  session.start_sigma_rad = kUsualStartSigmaDeg * kRadPerDeg;
  session.cutter = Table31();
  session.run = kRun;
  for (int i = 0; i < 12; ++i) session.starts_rad.push_back(30 * i * kRadPerDeg);
  const auto curve = ComputeCurve(session.cutter, session.run, {0, 0.0035}, session.starts_rad);
  DEMAND(curve.ok());
  for (const CurvePoint& point : *curve) session.lengths_mm.push_back(176.641 + point.height_mm);
  for (auto _ : state) {
    const auto report = FitWear(session);
    DEMAND(report.ok() && std::abs(report->inserts[1].wear_mm - 0.0035) < 1e-5);
    benchmark::DoNotOptimize(report->length_mm);
  }
}
BENCHMARK(WearFromTwelveReadings)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace axiscal::toolsetter
