// Simulated histories: calibrations of machines over years, and what truly happened to them. Every machine has thirteen
// errors whose calibrations are correlated; sizes count in what the full plan states as sigma.
//   steps          0.3 a year; 1 to 6 errors; Mahalanobis distance 3, 4, 5, 6, 8 or 12 of one full calibration's true
//                  covariance
//   wear           a third of the machines; 1 to 3 errors, 1 to 5 sigma a year, and a random walk of 0.03 sigma per
//                  root of a week
//   season         half of the machines; 3 to 8 errors follow the shop's temperature, which has a yearly cycle of 1.5
//   to
//                  5 K and weather; it is recorded on half of all machines
//   outliers       1 % of calibrations; 1 to 6 errors off by 4 to 30 sigma
//   plans          half of the machines: 60 % full, 25 % quick (1.5 times the sigma, one combination known to 50 sigma
//                  only), 15 % without two errors; the others: full
//   wrong sigma    the true sigma is 0.7 to 2 times the stated one (lognormal, 0.3), and on half of the machines
//   set-ups
//                  add up to 0.7 sigma to each error
//   gaps           10 % of calibrations are missing, and 0.3 times a year all of 4 to 12 weeks
#ifndef AXISCAL_CORE_SYNTHETIC_MACHINE_YEARS_H_
#define AXISCAL_CORE_SYNTHETIC_MACHINE_YEARS_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/drift/calibration.h"

namespace axiscal::synthetic {

struct Disturbances {
  bool steps = true, wear = true, season = true, plans = true, wrong_sigma = true, gaps = true;
  double outlier_share = 0.01;  // of calibrations
};

struct YearsToDraw {
  double years = 10.0;
  double interval_days = 7.0;
  uint64_t seed = 1;
  Disturbances disturbances;
};

// INVALID_ARGUMENT names field, value and rule: 0.1 to 50 years, 0.5 to 60 days.
absl::Status Check(const YearsToDraw& asked);

// What truly happened; indices count MachineYears::errors and calibrations.
struct TrueStep {
  int by = 0;  // the first calibration after it
  std::vector<int> errors;
  std::vector<double> sizes;    // um, urad
  double distance = 0.0;        // Mahalanobis, of one full calibration's true covariance
  double largest_sigmas = 0.0;  // the largest error's size by its true sigma
};
struct TrueOutlier {
  int calibration = 0;
  std::vector<int> errors;
};

struct MachineYears {
  std::string machine;
  struct Error {
    std::string symbol;
    drift::Unit unit = drift::Unit::kUm;
    double stated_sigma = 1.0;  // of the full plan
    double wear_per_year = 0.0;
    double season = 0.0;  // amplitude that the yearly cycle of the temperature gives it
  };
  std::vector<Error> errors;
  struct Plan {
    std::string name;
    std::vector<int> errors;     // that it can tell
    Eigen::MatrixXd covariance;  // as stated, of these
  };
  std::vector<Plan> plans;
  std::vector<drift::Calibration> calibrations;
  std::vector<int> plan_of;            // of each calibration
  std::vector<Eigen::VectorXd> truth;  // of each calibration: all errors, um and urad
  std::vector<TrueStep> steps;         // in order; those with no calibration after them are left out
  std::vector<TrueOutlier> outliers;
  double sigma_factor = 1.0;  // true by stated
  bool is_temperature_recorded = false;
};

// Machine `number` (from 0) of a fleet; what it is does not depend on the others.
MachineYears DrawMachineYears(const YearsToDraw& asked, int number);

// JSON Lines (docs/formats.md, "Simulated histories"): the first line of the file, and the lines of one machine.
std::string HistoryHeader(const YearsToDraw& asked, int machines);
std::string HistoryLines(const MachineYears& machine);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_MACHINE_YEARS_H_
