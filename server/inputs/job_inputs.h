// The inputs of a job, checked when it is created so that what cannot work is refused at once.
#ifndef AXISCAL_SERVER_INPUTS_JOB_INPUTS_H_
#define AXISCAL_SERVER_INPUTS_JOB_INPUTS_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/status.h"
#include "core/identify/budget.h"
#include "core/identify/held.h"
#include "core/machine/error_model.h"
#include "proto/convert/job_params.h"
#include "server/storage/database.h"

namespace axiscal::inputs {

// The machine is there and not deleted; sessions are complete and of that machine; the program is complete; the
// calibration is of that machine and not retired, or, when none is named, one is approved. The store's NOT_FOUND,
// FIELD_INVALID, FAILED_PRECONDITION MACHINE_DELETED, SESSION_NOT_COMPLETE, PROGRAM_NOT_COMPLETE, CALIBRATION_RETIRED,
// CALIBRATION_NOT_APPROVED, CALIBRATION_NOT_PLAUSIBLE.
absl::Status CheckInputs(storage::Database& database, const records::JobParams& params);

// The calibration that compensation and tables use, as above; `field` names it in errors.
absl::StatusOr<records::CalibrationRecord> CalibrationFor(storage::Database& database, const MachineId& machine,
                                                          const std::optional<CalibrationId>& calibration,
                                                          const std::string& field);

// The error terms that were asked for: each a constant's symbol ("EZ0T") or a term of errors.json without its amplitude
// ({"symbol": "EBB", "shape": "harmonic", "order": 45}). Empty: the machine's declared ones. INVALID_ARGUMENT
// FIELD_INVALID.
absl::StatusOr<machine::ErrorModel> DeclaredModel(const machine::Machine& machine,
                                                  const std::vector<std::string>& declared);

// What an identification holds at its values, if anything, and the error terms that it fits beside.
struct IdentifyErrors {
  std::optional<identify::HeldErrors> held;
  machine::ErrorModel fitted;
};
// FIELD_INVALID; of a held calibration also what CalibrationFor refuses, and MACHINE_CHANGED.
absl::StatusOr<IdentifyErrors> ErrorsOf(storage::Database& database, const machine::Machine& machine,
                                        const records::IdentifyParams& params);

// A job's error budget, if it has one. INVALID_ARGUMENT FIELD_INVALID.
absl::StatusOr<std::optional<identify::Budget>> BudgetOf(const machine::Machine& machine,
                                                         const records::IdentifyParams& params);
absl::StatusOr<std::optional<identify::Budget>> BudgetOf(const machine::Machine& machine,
                                                         const records::CloseLoopParams& params);
// One that stands in `field`; empty: none.
absl::StatusOr<std::optional<identify::Budget>> BudgetOf(const machine::Machine& machine, const std::string& json,
                                                         const std::string& field);

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_JOB_INPUTS_H_
