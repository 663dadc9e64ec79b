#include "core/loop/clustered_readings.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <map>

#include "core/loop/separation.h"

namespace axiscal::loop {
namespace {

using instruments::MeasuringRun;

// Bad readings that follow each other.
struct Event {
  int run = 0, reading = 0;  // of its largest residual
  double residual_mm = 0.0;
};

std::vector<Event> EventsOf(const identify::Fit& fit) {
  std::vector<Event> events;
  for (size_t i = 0; i < fit.problem.runs.size(); ++i) {
    const MeasuringRun& run = fit.problem.runs[i];
    int last_bad = -2;
    for (int k = 0; k < run.reading_count(); ++k) {
      for (int row = 0; row < run.row_count; ++row) {
        if (fit.problem.is_used[i][static_cast<size_t>(k) * run.row_count + row]) continue;
        const double residual_mm = std::abs(fit.residuals_mm[i](row, k));
        if (k > last_bad + 1 || events.empty()) {
          events.push_back({static_cast<int>(i), k, residual_mm});
        } else if (residual_mm > events.back().residual_mm) {
          events.back() = {static_cast<int>(i), k, residual_mm};
        }
        last_bad = k;
      }
    }
  }
  return events;
}

// A session in which the axis stands still says nothing about its places.
bool Moves(const MeasuringRun& run, int axis) {
  for (int k = 1; k < run.reading_count(); ++k) {
    if (run.PositionsOf(k)[axis] != run.PositionsOf(0)[axis]) return true;
  }
  return false;
}

struct Range {
  double chance = 1.0;  // of one like it anywhere along the axis
  double from = 0.0, to = 0.0;
};

// The least likely range of one axis. `share`: of all readings, how many begin a bad stretch.
Range LeastLikely(const std::vector<double>& bad, const std::vector<double>& all, double share) {
  const double widest = 0.2 * (all.back() - all.front());
  const double ranges = static_cast<double>(bad.size()) * static_cast<double>(bad.size());
  constexpr size_t kFewest = 4;
  Range least;
  for (size_t i = 0; i < bad.size(); ++i) {
    for (size_t j = i + kFewest - 1; j < bad.size() && bad[j] - bad[i] <= widest; ++j) {
      const auto within =
          std::upper_bound(all.begin(), all.end(), bad[j]) - std::lower_bound(all.begin(), all.end(), bad[i]);
      // The range begins at a bad reading by choice: what counts are those that follow it.
      const double others = static_cast<double>(j - i);
      const boost::math::binomial_distribution<double> following(static_cast<double>(within - 1), share);
      const double chance = ranges * boost::math::cdf(boost::math::complement(following, others - 1.0));
      if (chance < least.chance) least = {chance, bad[i], bad[j]};
    }
  }
  return least;
}

}  // namespace

std::vector<Unexplained> ClusteredReadings(const machine::Machine& machine, const identify::Fit& fit) {
  constexpr double kChance = 1e-3;
  const std::vector<Event> events = EventsOf(fit);
  int count_of_all = 0;
  for (const MeasuringRun& run : fit.problem.runs) count_of_all += run.reading_count();
  const double share = static_cast<double>(events.size()) / count_of_all;
  Range best;
  int best_axis = -1;
  for (int axis = 0; axis < machine.axis_count(); ++axis) {
    std::vector<double> all, bad;
    std::vector<bool> moves;
    for (const MeasuringRun& run : fit.problem.runs) {
      moves.push_back(Moves(run, axis));
      for (int k = 0; moves.back() && k < run.reading_count(); ++k) all.push_back(run.PositionsOf(k)[axis]);
    }
    for (const Event& event : events) {
      if (moves[event.run]) bad.push_back(fit.problem.runs[event.run].PositionsOf(event.reading)[axis]);
    }
    if (bad.empty()) continue;
    std::sort(all.begin(), all.end());
    std::sort(bad.begin(), bad.end());
    const Range range = LeastLikely(bad, all, share);
    if (range.chance >= best.chance) continue;
    best = range;
    best_axis = axis;
  }
  if (best_axis < 0 || best.chance * machine.axis_count() > kChance) return {};
  std::map<std::string, int> count_of;
  double squares = 0.0;
  int count = 0;
  for (const Event& event : events) {
    const MeasuringRun& run = fit.problem.runs[event.run];
    const double position = run.PositionsOf(event.reading)[best_axis];
    if (!Moves(run, best_axis) || position < best.from || position > best.to) continue;
    ++count_of[run.session];
    squares += event.residual_mm * event.residual_mm;
    ++count;
  }
  const auto most = std::max_element(count_of.begin(), count_of.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return {{Unexplained::kBadReadings, machine.axes[best_axis].name, best.from, best.to, most->first,
           std::sqrt(squares / count)}};
}

}  // namespace axiscal::loop
