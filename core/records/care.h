// What each machine of a fleet needs, at a glance.
#ifndef AXISCAL_CORE_RECORDS_CARE_H_
#define AXISCAL_CORE_RECORDS_CARE_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"
#include "core/base/ids.h"
#include "core/records/drift.h"

namespace axiscal::records {

// The smaller the number, the sooner. Never renumber.
enum class Care {
  kNow = 1,      // somebody should look at it: it has new events, or findings
  kDecide = 2,   // newer candidates wait for a decision
  kUnknown = 3,  // no calibration is in use
  kGood = 4,     // nothing
};

// What the calibration in use cannot know of: a step, or that the last calibration is doubtful.
struct StandingFinding {
  DriftKind kind = DriftKind::kStep;  // kStep, kSuspect or kUnstable
  base::UtcTime at;                   // of the calibration with which it was found
  std::string text;                   // in words
};

struct MachineCare {
  struct InUse {
    CalibrationId calibration;
    int64_t version = 0;
    base::UtcTime measured_at;
    std::optional<double> rms_before_um, rms_after_um;  // of its residuals
  };
  MachineId machine;
  Care care = Care::kUnknown;
  std::vector<StandingFinding> findings;  // the oldest first
  int64_t new_events = 0;                 // that stand, are not shelved, and that nobody has acknowledged
  std::string newest_event;               // the words of the newest of these
  std::optional<InUse> in_use;
  int64_t waiting = 0;              // candidates that were measured later than what is in use
  bool is_followed = false;         // nothing has changed since its history was looked through
  std::vector<std::string> groups;  // that it is in, in order
};

// By what else is there.
inline Care CareOf(const MachineCare& machine) {
  if (machine.new_events > 0 || !machine.findings.empty()) return Care::kNow;
  if (machine.waiting > 0) return Care::kDecide;
  return machine.in_use ? Care::kGood : Care::kUnknown;
}

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_CARE_H_
