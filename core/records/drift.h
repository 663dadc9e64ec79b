// What happened to a machine, told from its calibrations (docs/drift.md), as the service hands it out.
#ifndef AXISCAL_CORE_RECORDS_DRIFT_H_
#define AXISCAL_CORE_RECORDS_DRIFT_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/calibration.h"
#include "core/records/mark.h"

namespace axiscal::records {

// A tolerance: low <= error <= high, um or urad.
struct DriftLimit {
  std::string symbol;
  double low = 0.0, high = 0.0;
};

struct DriftSearch {
  MachineId machine;
  std::vector<DriftLimit> limits;  // whose crossing is foretold
  // The newest candidate counts for sessions of which no calibration was ever approved.
  bool counts_candidates = false;
};

// Never renumber.
enum class DriftKind {
  kStep = 1,
  kRetraction = 2,
  kSuspect = 3,
  kSlope = 4,
  kSeason = 5,
  kNoise = 6,
  kUnstable = 7,
};

// One error's part in a finding: what moved (steps: now - before), per year (slopes), or the amplitude (seasons).
struct DriftAmount {
  std::string symbol;
  EstimateUnit unit = EstimateUnit::kUm;
  double size = 0.0, sigma = 0.0;
};

struct DriftFinding {
  DriftKind kind = DriftKind::kStep;
  std::string text;                        // in words
  base::UtcTime at;                        // of the calibration with which it was found
  std::optional<base::UtcTime> after, by;  // of steps: the calibrations before and after it
  std::vector<DriftAmount> amounts;        // the clearest first
  std::optional<double> certainty;         // 0 .. 1
  bool is_revision = false;                // corrects the step told last
  bool is_over = false;                    // was said before, and is no longer so
};

struct LimitForecast {
  DriftLimit limit;
  std::string text;  // in words; why there is none
  // That the error is outside now, and that it comes outside within a year after the last calibration.
  std::optional<double> probability_now, probability_within_year;
  std::optional<base::UtcTime> earliest, median, latest;  // outside by then with 5, 50, 95 %
};

struct DriftReport {
  std::vector<DriftFinding> findings;  // in order of time
  std::vector<LimitForecast> limits;   // one each of those asked
  std::vector<CalibrationId> counted;  // the oldest first
  int64_t calibrations = 0;            // that the machine has in all
  std::vector<std::string> left_out;   // those that should count and cannot: which, and why
  std::vector<Mark> marks;             // of people, the oldest first
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_DRIFT_H_
