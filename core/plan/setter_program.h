// Programs of the laser tool setter: rods that are fed down onto the beam (`tool-setter`), a mill that is started at
// stated angles of the spindle and fed down while it turns (`tool-curve`). Positions are axis positions (program.h).
#ifndef AXISCAL_CORE_PLAN_SETTER_PROGRAM_H_
#define AXISCAL_CORE_PLAN_SETTER_PROGRAM_H_

#include <map>
#include <optional>
#include <string>

#include "core/machine/machine.h"
#include "core/plan/probe_writer.h"
#include "core/session/session.h"

namespace axiscal::plan {

struct SetterOptions {
  // Positions of the linear axes, by name, at which the spindle's reference point (of a mill: the tool's lowest nominal
  // point) stands in the beam, mm. The spindle stands over the beam wherever the program moves along the tool.
  std::map<std::string, double> beam_at_mm;
  double clearance_mm = 2.0;   // above the beam where the feed of a rod begins
  double overtravel_mm = 2.0;  // below the beam, where a feed without a trigger ends
  double retract_mm = 50.0;    // further up, where rods are changed and the spindle is turned
  double feed_mm_min = 4.0;    // of rods; a mill's is the plan's
};

// Which words turn the spindle to an angle and start it, of a dialect.
struct SpindleWords {
  std::string orient = "M19 R";  // the angle in deg follows
  std::string stop_for_a_person = "M00";
};

// Body of the program: of each line of the session the spindle is turned to its angle (rod: theta_th; mill: start_deg),
// the tool is fed down to the trigger and taken up again. A mill starts to turn at the start height and is fed down at
// once: how far it has turned until it is at speed is alike each time and part of the fitted phase. `spindle_rpm` > 0
// is counter-clockwise seen from above: M04. INVALID_ARGUMENT on a number out of range, a missing position of the beam
// or a session of another instrument; FAILED_PRECONDITION where no linear axis runs along the tool or travel ends.
absl::StatusOr<std::string> SetterBlocks(const machine::Machine& machine, const session::Session& session,
                                         const SetterOptions& options, const ProbeDialect& dialect,
                                         const SpindleWords& words);

}  // namespace axiscal::plan

#endif  // AXISCAL_CORE_PLAN_SETTER_PROGRAM_H_
