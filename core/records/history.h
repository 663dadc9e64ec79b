// How identified errors went over the years, of one machine and of the fleet.
#ifndef AXISCAL_CORE_RECORDS_HISTORY_H_
#define AXISCAL_CORE_RECORDS_HISTORY_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/calibration.h"

namespace axiscal::records {

struct DriftQuery {
  MachineId machine;
  std::vector<std::string> symbols;  // empty: all that the machine has
  base::UtcTime from;                // included
  base::UtcTime to;                  // excluded
  int max_points = 500;              // per symbol, 1 .. 100'000
};

// Estimates of one bucket of time. With count = 1 it is that very estimate: min = max = mean, with its own sigma and
// calibration.
struct DriftPoint {
  base::UtcTime first_at, last_at;
  int64_t count = 0;
  double min = 0.0, max = 0.0, mean = 0.0;  // in the unit of the series
  std::optional<double> sigma;              // of the last estimate in the bucket
  CalibrationId last_calibration;
};

struct DriftSeries {
  std::string symbol;
  EstimateUnit unit = EstimateUnit::kUm;
  std::vector<DriftPoint> points;      // in time order; only estimates that have a value
  int64_t not_identifiable_count = 0;  // calibrations in the range that could not tell this error
};

struct LatestEstimate {
  Estimate estimate;
  base::UtcTime measured_at;
  CalibrationId calibration;
  CalibrationState state = CalibrationState::kCandidate;  // of that calibration: approved or a candidate
};

struct FleetRow {
  MachineId machine;
  std::vector<LatestEstimate> latest;  // one per symbol that a calibration not retired has, in order of symbol
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_HISTORY_H_
