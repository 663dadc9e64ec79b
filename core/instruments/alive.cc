#include <algorithm>
#include <cmath>
#include <vector>

#include "core/instruments/plausible.h"
#include "core/instruments/registry.h"
#include "core/instruments/resolution.h"
#include "core/session/column_rules.h"

namespace axiscal::instruments {
namespace {

// Readings first .. last of one column are the same; the machine moved `moves` times meanwhile.
struct Stretch {
  int first = 0, last = 0, moves = 0;
};

bool Moved(const MeasuringRun& run, int reading) {
  return !std::equal(run.PositionsOf(reading), run.PositionsOf(reading) + run.axis_count, run.PositionsOf(reading - 1));
}

// The stretches in which the machine moved at least kDeadMoves times.
std::vector<Stretch> LongStretches(const MeasuringRun& run, int row) {
  std::vector<Stretch> stretches;
  Stretch now;
  for (int k = 1; k <= run.reading_count(); ++k) {
    if (k < run.reading_count() && run.measured_mm(row, k) == run.measured_mm(row, k - 1)) {
      now.last = k;
      now.moves += Moved(run, k);
      continue;
    }
    if (now.moves >= kDeadMoves) stretches.push_back(now);
    now = {k, k, 0};
  }
  return stretches;
}

// Scatter of the readings outside the stretches, mm, judged from second differences, which a smooth signal hardly has;
// at most the stated one.
double NoiseBeside(const MeasuringRun& run, int row, const std::vector<Stretch>& stretches) {
  std::vector<double> bends;
  auto stretch = stretches.begin();
  for (int k = 1; k + 1 < run.reading_count(); ++k) {
    while (stretch != stretches.end() && stretch->last <= k) ++stretch;
    if (stretch != stretches.end() && stretch->first < k) continue;
    bends.push_back(
        std::abs(run.measured_mm(row, k - 1) - 2.0 * run.measured_mm(row, k) + run.measured_mm(row, k + 1)));
  }
  constexpr size_t kFewest = 10;
  if (bends.size() < kFewest) return run.sigma_mm;
  const auto middle = bends.begin() + static_cast<std::ptrdiff_t>(bends.size() / 2);
  std::nth_element(bends.begin(), middle, bends.end());
  const double sigma_per_median = 1.4826 / std::sqrt(6.0);  // of Gaussian noise
  return std::min(run.sigma_mm, sigma_per_median * *middle);
}

// Whether noise would have changed the reading during that many moves.
bool IsDead(const MeasuringRun& run, int row, const Stretch& stretch, const std::vector<Stretch>& stretches) {
  if (stretch.first == 0 && stretch.last + 1 == run.reading_count()) return run.readings_before == 0;
  const double noise_mm = NoiseBeside(run, row, stretches);
  constexpr double kHardlyAny = 0.1;  // of the stated sigma: simulated without noise
  if (noise_mm < kHardlyAny * run.sigma_mm) return false;
  // At best the signal stands in the middle of a step of the display.
  constexpr double kOnce = 1e-9;
  const double stays = std::erf(ResolutionOf(run, row) / (std::sqrt(8.0) * noise_mm));
  return run.reading_count() * std::pow(stays, stretch.moves) < kOnce;
}

}  // namespace

absl::Status CheckAlive(const session::Session& session, const MeasuringRun& run,
                        const std::vector<size_t>* log_lines) {
  const Instrument* instrument = FindInstrument(session::FindHeader(session, "instrument").value_or(""));
  if (instrument == nullptr) return absl::OkStatus();
  for (size_t row = 0; row < instrument->reading_columns.size(); ++row) {
    const std::vector<Stretch> stretches = LongStretches(run, static_cast<int>(row));
    if (stretches.empty()) continue;
    const Stretch& longest = *std::max_element(stretches.begin(), stretches.end(),
                                               [](const Stretch& a, const Stretch& b) { return a.moves < b.moves; });
    if (!IsDead(run, static_cast<int>(row), longest, stretches)) continue;
    const int first = run.readings_before + longest.first, last = run.readings_before + longest.last;
    return absl::InvalidArgumentError(absl::StrFormat(
        "line %d: readings %d to %d of session '%s': %s = %g mm in all of them while the machine moves, expected "
        "readings "
        "that scatter: an instrument that reads the same at more than %d moves is not connected, stuck or off scale",
        session::ReadingLine(session.header.size(), static_cast<size_t>(first), log_lines), first + 1, last + 1,
        run.session, instrument->reading_columns[row], run.measured_mm(static_cast<Eigen::Index>(row), longest.first),
        kDeadMoves));
  }
  return absl::OkStatus();
}

}  // namespace axiscal::instruments
