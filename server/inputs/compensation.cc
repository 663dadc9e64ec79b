#include "server/inputs/compensation.h"

#include "core/base/error_detail.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/machine/program_profile.h"
#include "core/nc/stated_options.h"
#include "proto/convert/field.h"
#include "server/inputs/calibration_use.h"
#include "server/inputs/job_inputs.h"

namespace axiscal::inputs {

absl::StatusOr<records::CompensateParams> WithProfile(storage::Database& database, records::CompensateParams params,
                                                      const std::string& field) {
  params.of_profile.clear();
  if (params.without_profile) return params;
  ASSIGN_OR_RETURN(const records::MachineRecord record, database.GetMachine(params.machine));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  ASSIGN_OR_RETURN(const machine::ProgramProfile profile, machine::ProgramProfileFromJson(record.description_json));
  const auto read = nc::ReadStated(profile, nc::StatedBy::kProfile, machine);
  if (!read.ok()) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("the description of machine ", record.id.text(), ": ", read.status().message()),
                       {"PROFILE_INVALID", {}});
  }
  nc::StatedOptions stated{std::move(params.options), params.tool_tip_mm, params.open};
  absl::StatusOr<std::string> taken = nc::TakeProfile(profile, machine, &stated);
  if (!taken.ok()) return convert::FieldError(field + ".options", std::string(taken.status().message()));
  if (stated.open.tool_tip)
    return convert::FieldError(field + ".tool_tip_mm", "0 numbers, must be 3: the machine's profile states none");
  params.options = std::move(stated.options);
  params.tool_tip_mm = stated.tool_tip_mm;
  params.open = stated.open;
  params.of_profile = *std::move(taken);
  return params;
}

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
  std::vector<std::string> notes = NotesOnInseparableErrors(calibration);
  if (!params.of_profile.empty()) notes.push_back("of the machine's profile: " + params.of_profile);
  return Compensation{std::move(calibration), std::move(compensator), std::move(options), std::move(notes)};
}

}  // namespace axiscal::inputs
