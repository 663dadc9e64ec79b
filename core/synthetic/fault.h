// What is at fault beside the machine when a session is measured: the instrument, its clock, the control's log, what
// moved in the set-up. Nothing of it is an error of the machine, so nothing of it is in the truth at a pose.
#ifndef AXISCAL_CORE_SYNTHETIC_FAULT_H_
#define AXISCAL_CORE_SYNTHETIC_FAULT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/synthetic/effect.h"

namespace axiscal::synthetic {

enum class FaultKind {
  kGain,        // channels that read too much or too little, and each other
  kScale,       // a bar or a tracker's scale that is wrong, or grows with the temperature
  kBall,        // a ball that is not round
  kLobes,       // so many lobes about the tool (ball in the spindle) or about the table's z (ball on the table)
  kGrowth,      // the instrument warms up after each session's start
  kMotion,      // what the table or the tool holder carries, or the tracker, moves slowly: a set-up that drifts
  kClock,       // instrument and control have different times
  kLoggedLate,  // the positions that the session shows lag behind the true ones
  kSlip,        // what the table or the tool holder carries slips once
};
// "gain", "scale" ... in the enumeration's order, ended by nullptr.
const char* const* FaultWords();

struct Fault {
  FaultKind kind = FaultKind::kGain;
  std::vector<std::string> sessions;  // it acts in these; in all that can have it where empty
  instruments::Carrier carrier = instruments::Carrier::kTable;
  double gain = 0.0, crosstalk = 0.0;          // of kGain: share of a channel's own reading, largest of another's
  double scale = 0.0, scale_per_kelvin = 0.0;  // of kScale, shares of the length; per K about 20 deg C
  double rms_mm = 0.0;                         // of kBall, kLobes, kGrowth, kMotion, about the mean over all readings
  int order = 3;                               // of kLobes
  double tau_s = 600.0;                        // of kGrowth
  double delay_s = 0.0;                        // of kClock and kLoggedLate: > 0: the reading or the log is late
  double at = 0.5;                             // of kSlip: the share of the session's readings before it
  Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();  // of kSlip, in the carrier's frame
};

// All that faults do in one session.
struct SessionFaults {
  Eigen::Matrix3d gain = Eigen::Matrix3d::Identity();  // on the first row_count rows
  double saturation_mm = 0.0;                          // where not 0: what `gain` adds levels off beyond this reading
  Eigen::VectorXd scale;                               // per reading, share of the length; empty: none
  Eigen::MatrixXd offset_mm;                           // row_count x readings, added; empty: none
  Eigen::Matrix3Xd table_mm, tool_mm;   // per reading: translation of what table and tool holder carry; empty: none
  std::vector<double> read_positions;   // where the axes stand when the instrument reads; empty: at the commands
  std::vector<double> shown_positions;  // what the session shows; empty: the commands
};

// `runs` are the planned sessions bound, `plan` their history in this order. INVALID_ARGUMENT naming the fault where no
// session, or one that was named, can have it.
absl::StatusOr<std::vector<SessionFaults>> DrawFaults(const machine::Machine& machine, const std::vector<Fault>& faults,
                                                      Form form, const std::vector<instruments::MeasuringRun>& runs,
                                                      const History& plan, uint64_t seed);

// Adds gain, scale and offset to what a sound instrument would read.
void Distort(const SessionFaults& faults, const instruments::MeasuringRun& run, int reading, double* reading_mm);

}  // namespace axiscal::synthetic

#endif  // AXISCAL_CORE_SYNTHETIC_FAULT_H_
