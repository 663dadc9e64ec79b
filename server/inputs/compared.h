// Two stored calibrations of one machine as core/compare takes them.
#ifndef AXISCAL_SERVER_INPUTS_COMPARED_H_
#define AXISCAL_SERVER_INPUTS_COMPARED_H_

#include <functional>
#include <optional>

#include "core/compare/compare.h"
#include "server/storage/database.h"

namespace axiscal::inputs {

struct Compared {
  machine::Machine machine;  // as it is described now
  compare::Side first, second;
  // The positions that the sessions of both measured, and the tool point of the first of them; absent: no readings with
  // positions are left.
  std::optional<predict::Workspace> workspace;
};

// As MachineFor of both; INVALID_ARGUMENT where a calibration's errors or report cannot be read. `is_cancelled` is
// polled between sessions: CANCELLED.
absl::StatusOr<Compared> SidesOf(
    storage::Database& database, const records::CalibrationRecord& first, const records::CalibrationRecord& second,
    const std::function<bool()>& is_cancelled = [] { return false; });

}  // namespace axiscal::inputs

#endif  // AXISCAL_SERVER_INPUTS_COMPARED_H_
