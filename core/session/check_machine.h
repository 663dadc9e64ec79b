// Does a session belong to a machine: its name, its axes, their units and their travel.
#ifndef AXISCAL_CORE_SESSION_CHECK_MACHINE_H_
#define AXISCAL_CORE_SESSION_CHECK_MACHINE_H_

#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/session/session.h"

namespace axiscal::session {

// The same for many parts of a session, prepared once for all of them.
class MachineCheck {
 public:
  // The header must be valid. INVALID_ARGUMENT when `columns`, which all parts have, are not its instrument's, or the
  // datum line does not fit the machine.
  static absl::StatusOr<MachineCheck> Create(const std::vector<HeaderEntry>& header,
                                             const std::vector<std::string>& columns, const machine::Machine& machine);

  // As CheckAgainstMachine of a session with this header and these readings; `log_lines`: of the readings, where they
  // came from a log, whose lines are then named.
  absl::Status Check(const std::vector<Column>& columns, const std::vector<size_t>* log_lines = nullptr) const;

 private:
  struct AxisColumn {
    size_t index = 0;                    // of the column
    absl::StatusOr<machine::Axis> axis;  // an error: the machine has no such axis, whatever the readings
    bool is_position = true;             // the command; else what the encoder shows beside it, or the sense
  };

  size_t header_entries_ = 0;
  absl::Status wrong_machine_, missing_axis_;  // told before and after what the axis columns tell
  std::vector<AxisColumn> axis_columns_;
};

// The session must be valid (see Validate). INVALID_ARGUMENT with the place in the session's file when the header names
// another machine, a column names an axis that the machine has not or has in the other unit, an axis that the
// instrument needs has no column, its datum line names what is no linear axis of the machine, or a position lies beyond
// the travel that the description states.
absl::Status CheckAgainstMachine(const Session& session, const machine::Machine& machine);

}  // namespace axiscal::session

#endif  // AXISCAL_CORE_SESSION_CHECK_MACHINE_H_
