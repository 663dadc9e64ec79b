// All that the detector keeps of one machine: its size does not grow with the history.
#ifndef AXISCAL_CORE_DRIFT_STATE_H_
#define AXISCAL_CORE_DRIFT_STATE_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/drift/calibration.h"
#include "core/drift/joint_filter.h"
#include "core/drift/outlook.h"
#include "core/drift/rate_bank.h"

namespace axiscal::drift {

// One error. Whatever is "in its unit_size" is divided by it.
struct Followed {
  std::string symbol;
  Unit unit = Unit::kUm;
  double unit_size = 1.0;               // what its good calibrations state as sigma, in `unit`
  std::vector<double> stated_sigmas{};  // the last kMostSigmas, in `unit`
  base::UtcTime first_seen, last_seen;
  int seen = 0;  // calibrations that had it
  RateBank bank{};
  base::UtcTime bank_at;                                           // of the last calibration in it
  Outlook outlook{};                                               // of the calibrations before `State::last`
  bool is_wearing = false, is_seasonal = false, is_noisy = false;  // what was said and is not over
};

// One of the last calibrations, with what was expected before it.
struct Past {
  base::UtcTime at;
  Regressors regressors{};
  std::vector<int> seen;      // of State::errors, rising
  Eigen::VectorXd y;          // n, 0 where not seen
  Eigen::MatrixXd stated;     // n x n covariance, 0 where not seen
  Eigen::VectorXd suspicion;  // n: variance that is added to what is suspect
  Eigen::VectorXd loosened;   // n: variance that levels got before it, because of a step or mark
  bool may_start = false;     // a step may begin here
  bool is_wear_new = false;   // a service stands before it
  Joint before;
};

// The last step that was told.
struct ToldStep {
  base::UtcTime after, by;
  int64_t found = 0;                 // State::calibrations then; 0: none
  Eigen::VectorXd sizes, variances;  // n, 0 where an error did not jump
};

struct State {
  int64_t calibrations = 0;
  base::UtcTime first_at, last_at;  // of calibrations
  base::UtcTime last_mark_at;
  std::vector<Followed> errors;
  Joint joint;                  // after the last calibration
  std::vector<Past> last;       // up to kWindow, the oldest first
  base::UtcTime before_window;  // of the calibration before the oldest of them
  ToldStep told;
  int suspects_in_a_row = 0;
  base::UtcTime suspect_since;
  Eigen::VectorXd mark_loosens;  // n: variance that levels get before the next calibration
  bool is_marked = false;        // there ever was a mark
  bool is_service = false;       // one since the last calibration was a service
};

inline constexpr int kWindow = 6;       // calibrations in which a step is looked for
inline constexpr int kMostSigmas = 16;  // enough that a quarter of them are of the usual plan

// Time as the filters count it.
double WeeksBetween(base::UtcTime from, base::UtcTime to);

// Canonical bytes: the same state gives the same ones, and reading gives the very state back. Little-endian, version 1,
// sealed with a CRC-32C.
std::string WriteState(const State& state);
// DATA_LOSS where bytes are missing or changed, INVALID_ARGUMENT for another version.
absl::StatusOr<State> ReadState(const std::string& bytes);

}  // namespace axiscal::drift

#endif  // AXISCAL_CORE_DRIFT_STATE_H_
