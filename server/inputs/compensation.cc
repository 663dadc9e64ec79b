#include "server/inputs/compensation.h"

#include "core/machine/error_json.h"
#include "server/inputs/calibration_use.h"
#include "server/inputs/job_inputs.h"

namespace axiscal::inputs {

absl::StatusOr<Compensation> CompensationFor(storage::Database& database, const records::CompensateParams& params,
                                             const std::string& calibration_field) {
  ASSIGN_OR_RETURN(records::CalibrationRecord calibration,
                   CalibrationFor(database, params.machine, params.calibration, calibration_field));
  RETURN_IF_ERROR(CheckTables(database, calibration, params.tables_are_off));
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineFor(database, calibration));
  ASSIGN_OR_RETURN(const machine::ErrorModel errors, machine::ReadErrors(calibration.content.model_json, machine));
  ASSIGN_OR_RETURN(compensate::Compensator compensator,
                   compensate::Compensator::Create(machine, errors,
                                                   {params.tool_tip_mm, params.time_s, params.temperature_celsius}));
  nc::RewriteOptions options = params.options;
  options.machine = params.machine.text();
  options.calibration = absl::StrCat(params.machine.text(), " v", calibration.version);
  return Compensation{std::move(calibration), std::move(compensator), std::move(options)};
}

}  // namespace axiscal::inputs
