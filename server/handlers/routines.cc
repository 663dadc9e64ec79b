#include "server/handlers/routines.h"

#include <algorithm>

#include "core/machine/error_json.h"
#include "core/machine/machine_json.h"
#include "proto/convert/field.h"
#include "proto/convert/routine.h"
#include "server/inputs/job_inputs.h"

namespace axiscal::handlers {
namespace {

constexpr size_t kMostStopBytes = 1000;

absl::Status RequireRoutine(const std::string& name) { return convert::RequireText("name", name, 1, 64); }

// Whoever may see a machine hears of the routines that work for it, and of no others.
absl::Status RequireWorksFor(Core& core, const std::string& name, const std::string& machine) {
  RETURN_IF_ERROR(convert::RequireText("machine_id", machine, 1, 255));
  ASSIGN_OR_RETURN(const std::vector<records::RoutineRecord> routines, core.database.RoutinesOf(MachineId(machine)));
  const bool works = std::any_of(routines.begin(), routines.end(),
                                 [&](const records::RoutineRecord& one) { return one.content.name == name; });
  if (works) return absl::OkStatus();
  return base::Error(absl::StatusCode::kNotFound, absl::StrCat("no routine ", name, " works for machine ", machine),
                     {"ROUTINE_NOT_FOUND", {{"routine", name}}});
}

// What a routine of one machine asks to fit is held to that machine as it is: each of its runs would fail. The machines
// of a group are those of the time.
absl::Status CheckOptions(Core& core, const records::Routine& routine) {
  if (routine.scope.kind != records::Scope::Kind::kMachine) return absl::OkStatus();
  ASSIGN_OR_RETURN(const records::MachineRecord record, core.database.GetMachine(MachineId(routine.scope.name)));
  ASSIGN_OR_RETURN(const machine::Machine machine, machine::MachineFromJson(record.description_json));
  for (size_t i = 0; i < routine.declared.size(); ++i) {
    const auto asked = machine::ReadAskedError(routine.declared[i], machine);
    if (!asked.ok())
      return convert::FieldError(absl::StrCat("routine.declared_errors[", i, "]"),
                                 std::string(asked.status().message()));
  }
  return inputs::BudgetOf(machine, routine.budget_json, "routine.budget_json").status();
}

}  // namespace

absl::StatusOr<v1::PutRoutineResponse> PutRoutine(Core& core, const Call& call, const v1::PutRoutineRequest& request) {
  RETURN_IF_ERROR(convert::RequireMessage("routine", request.has_routine()));
  RETURN_IF_ERROR(convert::RequireNotNegative("etag", request.etag()));
  const absl::StatusOr<records::Routine> routine = convert::FromProto(request.routine());
  if (!routine.ok()) return convert::InField("routine", routine.status());
  RETURN_IF_ERROR(CheckOptions(core, *routine));
  ASSIGN_OR_RETURN(const records::RoutineRecord record, core.database.PutRoutine(*routine, request.etag(), call.By()));
  core.run_all_soon();
  v1::PutRoutineResponse response;
  *response.mutable_routine() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::RemoveRoutineResponse> RemoveRoutine(Core& core, const Call& call,
                                                        const v1::RemoveRoutineRequest& request) {
  RETURN_IF_ERROR(RequireRoutine(request.name()));
  RETURN_IF_ERROR(convert::RequireNotNegative("etag", request.etag()));
  ASSIGN_OR_RETURN(const records::RoutineRecord record,
                   core.database.RemoveRoutine(request.name(), request.etag(), call.By()));
  core.run_all_soon();
  v1::RemoveRoutineResponse response;
  *response.mutable_routine() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::ListRoutinesResponse> ListRoutines(Core& core, const Call& call,
                                                      const v1::ListRoutinesRequest& request) {
  v1::ListRoutinesResponse response;
  ASSIGN_OR_RETURN(const std::vector<records::RoutineRecord> routines,
                   request.machine_id().empty() ? core.database.ListRoutines(call.visible)
                                                : core.database.RoutinesOf(MachineId(request.machine_id())));
  for (records::RoutineRecord routine : routines) {
    // Of a machine that was named the caller hears what is said of it alone.
    if (!request.machine_id().empty()) {
      std::erase_if(routine.stops, [&](const auto& stop) { return stop.machine.text() != request.machine_id(); });
    }
    *response.add_routines() = convert::ToProto(routine);
  }
  return response;
}

absl::StatusOr<v1::StopRoutineResponse> StopRoutine(Core& core, const Call& call,
                                                    const v1::StopRoutineRequest& request) {
  RETURN_IF_ERROR(RequireRoutine(request.name()));
  RETURN_IF_ERROR(convert::RequireText("note", request.note(), 0, kMostStopBytes));
  RETURN_IF_ERROR(RequireWorksFor(core, request.name(), request.machine_id()));
  const MachineId machine(request.machine_id());
  ASSIGN_OR_RETURN(records::RoutineRecord record,
                   core.database.StopRoutine(request.name(), machine, request.stopped(), request.note(), call.By()));
  core.run_soon(machine);
  core.look_soon(machine);
  std::erase_if(record.stops, [&](const auto& stop) { return stop.machine != machine; });
  v1::StopRoutineResponse response;
  *response.mutable_routine() = convert::ToProto(record);
  return response;
}

absl::StatusOr<v1::RetryRoutineResponse> RetryRoutine(Core& core, const Call& call,
                                                      const v1::RetryRoutineRequest& request) {
  RETURN_IF_ERROR(RequireRoutine(request.name()));
  RETURN_IF_ERROR(RequireWorksFor(core, request.name(), request.machine_id()));
  const MachineId machine(request.machine_id());
  ASSIGN_OR_RETURN(const records::RoutineRun run, core.database.RetryRoutine(request.name(), machine, call.By()));
  core.run_soon(machine);
  v1::RetryRoutineResponse response;
  *response.mutable_run() = convert::ToProto(run);
  return response;
}

absl::StatusOr<v1::ListRoutineRunsResponse> ListRoutineRuns(Core& core, const Call& call,
                                                            const v1::ListRoutineRunsRequest& request) {
  ASSIGN_OR_RETURN(const records::PageRequest page, PageFrom(request.page_size(), request.page_token()));
  records::RunFilter filter;
  if (!request.machine_id().empty()) filter.machine = MachineId(request.machine_id());
  filter.routine = request.routine();
  ASSIGN_OR_RETURN(const records::Page<records::RoutineRun> runs, core.database.ListRuns(filter, page, call.visible));
  v1::ListRoutineRunsResponse response;
  for (const records::RoutineRun& run : runs.rows) *response.add_runs() = convert::ToProto(run);
  response.set_next_page_token(runs.next_token);
  return response;
}

}  // namespace axiscal::handlers
