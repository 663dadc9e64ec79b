#include "server/inputs/compensation.h"

#include "core/base/error_detail.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/machine/program_profile.h"
#include "core/nc/stated_options.h"
#include "core/reports/warning_kinds.h"
#include "proto/convert/field.h"
#include "server/inputs/calibration_use.h"
#include "server/inputs/job_inputs.h"

namespace axiscal::inputs {

namespace {

struct Filled {
  nc::StatedOptions stated;
  std::string of_profile;  // what the profile said, in the names of options
};

absl::StatusOr<Filled> WithProfile(const records::MachineRecord& record, const records::CompensateParams& params,
                                   const std::string& field) {
  Filled filled{{params.options, params.tool_tip_mm, params.open}, ""};
  if (params.without_profile) return filled;
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  ASSIGN_OR_RETURN(const machine::ProgramProfile profile, machine::ProgramProfileFromJson(record.description_json));
  const auto read = nc::ReadStated(profile, nc::StatedBy::kProfile, machine);
  if (!read.ok()) {
    return base::Error(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("the description of machine ", record.id.text(), ": ", read.status().message()),
                       {"PROFILE_INVALID", {}});
  }
  absl::StatusOr<std::string> taken = nc::TakeProfile(profile, machine, &filled.stated);
  if (!taken.ok()) return convert::FieldError(field + ".options", std::string(taken.status().message()));
  if (filled.stated.open.tool_tip)
    return convert::FieldError(field + ".tool_tip_mm", "0 numbers, must be 3: the machine's profile states none");
  filled.of_profile = *std::move(taken);
  return filled;
}

}  // namespace

void Compensation::AddTo(nc::RewriteReport* report) const {
  report->notes.insert(report->notes.end(), notes.begin(), notes.end());
  if (const std::optional<nc::Remark> note = NoteOnUnmeasured(calibration, nc::PositionsOf(*report)))
    report->notes.push_back(*note);
  report->calibration_warnings = doubts.warnings;
  report->calibration_causes = doubts.causes;
}

absl::Status CheckProfile(storage::Database& database, const records::CompensateParams& params,
                          const std::string& field) {
  ASSIGN_OR_RETURN(const records::MachineRecord record, database.GetMachine(params.machine));
  return WithProfile(record, params, field).status();
}

absl::StatusOr<Compensation> CompensationFor(storage::Database& database, const records::CompensateParams& params,
                                             const std::string& field) {
  ASSIGN_OR_RETURN(const records::MachineRecord record, database.GetMachine(params.machine));
  ASSIGN_OR_RETURN(Filled filled, WithProfile(record, params, field));
  ASSIGN_OR_RETURN(records::CalibrationRecord calibration,
                   CalibrationFor(database, params.machine, params.calibration, field + ".calibration_id"));
  RETURN_IF_ERROR(CheckTables(database, calibration, params.tables_are_off));
  ASSIGN_OR_RETURN(const machine::Machine machine, MachineFor(database, calibration));
  ASSIGN_OR_RETURN(const machine::ErrorModel errors, machine::ReadErrors(calibration.content.model_json, machine));
  ASSIGN_OR_RETURN(compensate::Compensator compensator,
                   compensate::Compensator::Create(
                       machine, errors, {filled.stated.tool_tip_mm, params.time_s, params.temperature_celsius}));
  nc::RewriteOptions options = std::move(filled.stated.options);
  options.machine = params.machine.text();
  options.calibration = absl::StrCat(params.machine.text(), " v", calibration.version);
  std::vector<nc::Remark> notes = NotesOnInseparableErrors(calibration);
  Doubts doubts = DoubtsOf(calibration);
  options.calibration_warns = reports::KindsOf(doubts.warnings, doubts.causes);
  if (!filled.of_profile.empty()) notes.push_back({"profile", "of the machine's profile: " + filled.of_profile});
  return Compensation{std::move(calibration), std::move(compensator), std::move(options),
                      std::move(notes),       std::move(doubts),      record.revision};
}

}  // namespace axiscal::inputs
