// A calibration: the errors that an identification or the loop found, as a version of its machine's error model.
// Texts named `..._json` are opaque here.
#ifndef AXISCAL_CORE_RECORDS_CALIBRATION_H_
#define AXISCAL_CORE_RECORDS_CALIBRATION_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/page.h"

namespace axiscal::records {

// Never renumber.
enum class CalibrationState { kCandidate = 1, kApproved = 2, kRetired = 3 };
// Never renumber.
enum class EstimateUnit { kUm = 1, kUrad = 2 };

// One identified error. What the data could not tell has no value and no sigma.
struct Estimate {
  std::string symbol;  // "EA0B", or with its shape "EBB:harmonic:45"
  EstimateUnit unit = EstimateUnit::kUm;
  bool identifiable = true;
  std::optional<double> value;  // um or urad
  std::optional<double> sigma;  // 1 standard uncertainty, um or urad

  bool operator==(const Estimate&) const = default;
};

// What it came from and what came out; nothing of it is ever changed.
struct NewCalibration {
  MachineId machine;
  int64_t machine_revision = 0;     // whose description was fitted
  std::vector<SessionId> sessions;  // that it came from, in order; all complete and of this machine
  base::UtcTime measured_at;        // the time of its estimates in the history
  std::string model_json;           // the error model: what compensation uses
  std::string options_json;         // how it was asked
  std::string report_json;          // what came out: reports::CalibrationReport
  std::string engine_version;
  int rank = 0;
  std::optional<double> condition;  // of the scaled Jacobian
  std::optional<double> chi2_per_dof;
  std::optional<double> rms_before_um, rms_after_um;
  std::vector<Estimate> estimates;
  std::string created_by;
};

// What a person decided of a calibration.
struct Decision {
  base::UtcTime at;
  std::string by;
  CalibrationState became = CalibrationState::kApproved;
  std::string reason;  // as it was given; empty: none was
};

// With its place among the machine's calibrations, of which at most one is approved.
struct CalibrationRecord {
  CalibrationId id;
  int64_t version = 0;  // 1, 2, ... of its machine
  CalibrationState state = CalibrationState::kCandidate;
  int64_t etag = 0;  // grows with every change of state
  std::optional<JobId> job;
  NewCalibration content;
  base::UtcTime created_at;
  std::string approved_by;
  std::optional<base::UtcTime> approved_at, retired_at;
  std::vector<SessionId> rejected_sessions;  // of its sessions, those that do not count any more
  std::vector<Decision> decisions;           // newest first; of one that was asked for by itself
};

struct CalibrationFilter {
  std::optional<MachineId> machine;
  std::optional<CalibrationState> state;
  TimeSpan measured = {};
  std::optional<SessionId> session = {};  // that it stands on
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_CALIBRATION_H_
