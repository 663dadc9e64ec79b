#include "server/inputs/job_inputs.h"

#include "core/base/error_detail.h"
#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "core/toolsetter/evaluate.h"
#include "proto/convert/field.h"
#include "server/inputs/calibration_use.h"
#include "server/inputs/compensation.h"

namespace axiscal::inputs {
namespace {

absl::Status Unmet(const std::string& reason, const std::string& text) {
  return base::Error(absl::StatusCode::kFailedPrecondition, text, {reason, {}});
}

absl::Status CheckSessions(storage::Database& database, const MachineId& machine,
                           const std::vector<SessionId>& sessions, const std::string& field) {
  for (size_t i = 0; i < sessions.size(); ++i) {
    ASSIGN_OR_RETURN(const records::SessionRecord session, database.GetSession(sessions[i]));
    const std::string name = absl::StrCat("session ", session.id.number(), " (", session.name, ")");
    if (session.machine != machine) {
      return convert::FieldError(
          absl::StrCat(field, "[", i, "]"),
          absl::StrCat(name, " is of machine ", session.machine.text(), ", must be of ", machine.text()));
    }
    if (session.state != records::SessionState::kComplete) {
      const bool is_expired = session.state == records::SessionState::kExpired;
      return Unmet(
          "SESSION_NOT_COMPLETE",
          name + (is_expired ? " has expired: it was left, or its readings were removed by age" : " is not complete"));
    }
    if (session.is_rejected()) {
      return base::Error(
          absl::StatusCode::kFailedPrecondition,
          absl::StrCat(name, " was rejected by ", session.remark->changed_by, ": ", session.remark->reason),
          {"SESSION_REJECTED", {{"session", std::to_string(session.id.number())}}});
    }
  }
  return absl::OkStatus();
}

absl::Status CheckIdentify(storage::Database& database, const machine::Machine& machine,
                           const records::IdentifyParams& params) {
  RETURN_IF_ERROR(ErrorsOf(database, machine, params).status());
  RETURN_IF_ERROR(BudgetOf(machine, params).status());
  return CheckSessions(database, params.machine, params.sessions, "params.identify.session_ids");
}

absl::Status CheckCloseLoop(storage::Database& database, const machine::Machine& machine,
                            const records::CloseLoopParams& params) {
  RETURN_IF_ERROR(BudgetOf(machine, params).status());
  RETURN_IF_ERROR(CheckSessions(database, params.machine, params.fit, "params.close_loop.fit_session_ids"));
  return CheckSessions(database, params.machine, params.check, "params.close_loop.check_session_ids");
}

absl::Status CheckToolSetter(storage::Database& database, const records::ToolSetterParams& params) {
  RETURN_IF_ERROR(CheckSessions(database, params.machine, {params.session}, "params.tool_setter.session_id"));
  ASSIGN_OR_RETURN(const records::SessionRecord session, database.GetSession(params.session));
  if (toolsetter::IsToolSetter(session.instrument)) return absl::OkStatus();
  return convert::FieldError("params.tool_setter.session_id",
                             absl::StrCat("session ", session.id.number(), " is of instrument ", session.instrument,
                                          ", must be of tool-setter or tool-curve"));
}

absl::Status CheckCompensate(storage::Database& database, const records::CompensateParams& params) {
  ASSIGN_OR_RETURN(const records::ProgramRecord program, database.GetProgram(params.program));
  if (program.state != records::ProgramState::kComplete) {
    return Unmet("PROGRAM_NOT_COMPLETE", absl::StrCat("program ", program.id.number(), " is not complete"));
  }
  RETURN_IF_ERROR(CheckProfile(database, params, "params.compensate"));
  ASSIGN_OR_RETURN(const records::CalibrationRecord calibration,
                   CalibrationFor(database, params.machine, params.calibration, "params.compensate.calibration_id"));
  return CheckTables(database, calibration, params.tables_are_off);
}

absl::StatusOr<identify::HeldErrors> HeldCalibration(storage::Database& database, const machine::Machine& machine,
                                                     const MachineId& id, const CalibrationId& calibration_id) {
  ASSIGN_OR_RETURN(const records::CalibrationRecord calibration,
                   CalibrationFor(database, id, calibration_id, "params.identify.held_calibration_id"));
  RETURN_IF_ERROR(MachineFor(database, calibration).status());
  auto held = identify::ReadHeldErrors(calibration.content.model_json, calibration.content.report_json, machine);
  if (!held.ok())
    return convert::FieldError("params.identify.held_calibration_id", std::string(held.status().message()));
  return held;
}

absl::StatusOr<identify::HeldErrors> HeldText(const std::string& text, const machine::Machine& machine) {
  auto held = identify::ReadHeldErrors(text, machine);
  if (!held.ok()) return convert::FieldError("params.identify.held_errors_json", std::string(held.status().message()));
  return held;
}

}  // namespace

absl::Status CheckInputs(storage::Database& database, const records::JobParams& params) {
  ASSIGN_OR_RETURN(const records::MachineRecord record, database.GetMachine(records::MachineOf(params)));
  if (record.deleted_at) return Unmet("MACHINE_DELETED", "machine " + record.id.text() + " is deleted");
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  if (const auto* identify = std::get_if<records::IdentifyParams>(&params)) {
    return CheckIdentify(database, machine, *identify);
  }
  if (const auto* tool_setter = std::get_if<records::ToolSetterParams>(&params)) {
    return CheckToolSetter(database, *tool_setter);
  }
  if (const auto* close_loop = std::get_if<records::CloseLoopParams>(&params)) {
    return CheckCloseLoop(database, machine, *close_loop);
  }
  return CheckCompensate(database, std::get<records::CompensateParams>(params));
}

absl::StatusOr<records::CalibrationRecord> CalibrationFor(storage::Database& database, const MachineId& machine,
                                                          const std::optional<CalibrationId>& calibration_id,
                                                          const std::string& field) {
  if (!calibration_id) {
    absl::StatusOr<records::CalibrationRecord> approved = database.GetApprovedCalibration(machine);
    if (approved.ok()) RETURN_IF_ERROR(CheckSizes(*approved));
    if (approved.ok() || !absl::IsNotFound(approved.status())) return approved;
    return Unmet("CALIBRATION_NOT_APPROVED",
                 "machine " + machine.text() + " has no approved calibration: approve one, or name a candidate");
  }
  ASSIGN_OR_RETURN(records::CalibrationRecord calibration, database.GetCalibration(*calibration_id));
  if (calibration.content.machine != machine) {
    return convert::FieldError(
        field, absl::StrCat(calibration.id.number(), " is of machine ", calibration.content.machine.text(),
                            ", must be of ", machine.text()));
  }
  if (calibration.state == records::CalibrationState::kRetired) {
    return Unmet("CALIBRATION_RETIRED",
                 absl::StrCat("calibration ", calibration.id.number(), " is retired: approve it again to use it"));
  }
  RETURN_IF_ERROR(CheckSizes(calibration));
  return calibration;
}

absl::StatusOr<IdentifyErrors> ErrorsOf(storage::Database& database, const machine::Machine& machine,
                                        const records::IdentifyParams& params) {
  IdentifyErrors errors;
  ASSIGN_OR_RETURN(errors.fitted, DeclaredModel(machine, params.declared));
  if (!params.held_calibration && params.held_errors_json.empty()) return errors;
  ASSIGN_OR_RETURN(identify::HeldErrors held,
                   params.held_calibration
                       ? HeldCalibration(database, machine, params.machine, *params.held_calibration)
                       : HeldText(params.held_errors_json, machine));
  absl::StatusOr<machine::ErrorModel> fitted =
      identify::BesideHeld(machine, errors.fitted, !params.declared.empty(), held);
  if (!fitted.ok())
    return convert::FieldError("params.identify.declared_errors", std::string(fitted.status().message()));
  errors.fitted = *std::move(fitted);
  errors.held = std::move(held);
  return errors;
}

absl::StatusOr<std::optional<identify::Budget>> BudgetOf(const machine::Machine& machine, const std::string& json,
                                                         const std::string& field) {
  if (json.empty()) return std::nullopt;
  absl::StatusOr<identify::Budget> budget = identify::ReadBudget(json, machine);
  if (!budget.ok()) return convert::FieldError(field, std::string(budget.status().message()));
  return *std::move(budget);
}

absl::StatusOr<std::optional<identify::Budget>> BudgetOf(const machine::Machine& machine,
                                                         const records::IdentifyParams& params) {
  return BudgetOf(machine, params.budget_json, "params.identify.budget_json");
}

absl::StatusOr<std::optional<identify::Budget>> BudgetOf(const machine::Machine& machine,
                                                         const records::CloseLoopParams& params) {
  return BudgetOf(machine, params.budget_json, "params.close_loop.budget_json");
}

absl::StatusOr<machine::ErrorModel> DeclaredModel(const machine::Machine& machine,
                                                  const std::vector<std::string>& declared) {
  if (declared.empty()) return machine::DeclaredModel(machine);
  machine::ErrorModel model;
  for (size_t i = 0; i < declared.size(); ++i) {
    const absl::StatusOr<machine::ErrorModel> read = machine::ReadAskedError(declared[i], machine);
    if (!read.ok()) {
      return convert::FieldError(absl::StrCat("params.identify.declared_errors[", i, "]"),
                                 std::string(read.status().message()));
    }
    model.terms.insert(model.terms.end(), read->terms.begin(), read->terms.end());
  }
  return model;
}

}  // namespace axiscal::inputs
