// Which positions readings cover.
#ifndef AXISCAL_CORE_INSTRUMENTS_COVERED_H_
#define AXISCAL_CORE_INSTRUMENTS_COVERED_H_

#include <Eigen/Core>
#include <algorithm>
#include <optional>
#include <vector>

#include "core/instruments/run.h"

namespace axiscal::instruments {

struct Covered {
  std::vector<double> low, high;          // of each axis, mm or rad; empty where no reading has a position
  std::optional<Eigen::Vector3d> tip_mm;  // nominal tool point of the first that have, at home, machine frame
};

// Adds those of some runs of one machine. Readings taken along a path have no positions of their own.
inline void Cover(const std::vector<MeasuringRun>& runs, Covered& covered) {
  for (const MeasuringRun& run : runs) {
    if (run.path_readings != nullptr) continue;
    if (!covered.tip_mm) covered.tip_mm = run.tip_mm;
    for (int k = 0; k < run.reading_count(); ++k) {
      for (int i = 0; i < run.axis_count; ++i) {
        const double position = run.PositionsOf(k)[i];
        if (static_cast<int>(covered.low.size()) <= i) {
          covered.low.push_back(position);
          covered.high.push_back(position);
        }
        covered.low[i] = std::min(covered.low[i], position);
        covered.high[i] = std::max(covered.high[i], position);
      }
    }
  }
}

}  // namespace axiscal::instruments

#endif  // AXISCAL_CORE_INSTRUMENTS_COVERED_H_
