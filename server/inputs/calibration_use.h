// Whether a calibration may be put in use, and with which machine.
#ifndef AXISCAL_SERVER_INPUTS_CALIBRATION_USE_H_
#define AXISCAL_SERVER_INPUTS_CALIBRATION_USE_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/machine/machine.h"
#include "core/nc/remark.h"
#include "core/reports/axis_range.h"
#include "core/reports/loop.h"
#include "core/reports/warning.h"
#include "server/storage/database.h"

namespace axiscal::inputs {

// The machine as it is described now, if the calibration was fitted with the same axes; what its description declares
// may have changed. FAILED_PRECONDITION MACHINE_CHANGED naming both revisions.
absl::StatusOr<machine::Machine> MachineFor(storage::Database& database, const records::CalibrationRecord& calibration);

// OK if it holds no error that no machine has: more than 20 mm, 2 % of a length, or 100 mrad. FAILED_PRECONDITION
// CALIBRATION_NOT_PLAUSIBLE naming the error, its size and the limit.
absl::Status CheckSizes(const records::CalibrationRecord& calibration);

// OK if compensation can use it: its machine as in MachineFor, and its sessions determine at least one error or
// combination of errors, and CheckSizes(). FAILED_PRECONDITION MACHINE_CHANGED, CALIBRATION_EMPTY,
// CALIBRATION_NOT_PLAUSIBLE.
absl::Status CheckUsable(storage::Database& database, const records::CalibrationRecord& calibration);

// OK if the control of the calibration's machine has no table of any of its calibrations, or `are_off` says that it
// uses none: programs that `calibration` corrects would be corrected twice. FAILED_PRECONDITION TABLE_HANDED_OUT naming
// the newest tables, of which calibration each is, when and to whom it went, and what to state.
absl::Status CheckTables(storage::Database& database, const records::CalibrationRecord& calibration, bool are_off);

// Where the sessions could not separate some errors, the model holds their sum as one of them. That is right at poses
// like the measured ones and a guess elsewhere; so is an effect of the loop that stands for a class of effects. Users
// of the correction must know: one line for each.
std::vector<nc::Remark> NotesOnInseparableErrors(const records::CalibrationRecord& calibration);

// Where a program goes further than the calibration's sessions did: `positions` of the axes at the ends of what was
// corrected. Nothing where the calibration's report does not say where it was measured.
std::optional<nc::Remark> NoteOnUnmeasured(const records::CalibrationRecord& calibration,
                                           const std::vector<reports::AxisRange>& positions);

// What the calibration's own report says against it, which whoever corrects with it must know: its warnings, and what
// the loop found to be no error of the machine (a tool length that is wrong). Empty where its report cannot be read.
struct Doubts {
  std::vector<reports::Warning> warnings;
  std::vector<reports::Cause> causes;
};
Doubts DoubtsOf(const records::CalibrationRecord& calibration);

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_CALIBRATION_USE_H_
