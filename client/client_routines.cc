#include "client/client_impl.h"

namespace axiscal::client {

absl::StatusOr<records::RoutineRecord> Client::PutRoutine(const records::Routine& routine, int64_t etag) {
  v1::PutRoutineRequest request;
  *request.mutable_routine() = convert::ToProto(routine);
  request.set_etag(etag);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::PutRoutineResponse>(*impl_->routines, &v1::Routines::Stub::PutRoutine, request));
  return convert::RecordFromProto(response.routine());
}

absl::StatusOr<records::RoutineRecord> Client::RemoveRoutine(const std::string& name, int64_t etag) {
  v1::RemoveRoutineRequest request;
  request.set_name(name);
  request.set_etag(etag);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::RemoveRoutineResponse>(
                                            *impl_->routines, &v1::Routines::Stub::RemoveRoutine, request));
  return convert::RecordFromProto(response.routine());
}

absl::StatusOr<std::vector<records::RoutineRecord>> Client::ListRoutines(const std::optional<MachineId>& machine) {
  v1::ListRoutinesRequest request;
  if (machine) request.set_machine_id(machine->text());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListRoutinesResponse>(*impl_->routines, &v1::Routines::Stub::ListRoutines, request));
  std::vector<records::RoutineRecord> routines;
  for (const v1::Routine& message : response.routines()) {
    ASSIGN_OR_RETURN(records::RoutineRecord routine, convert::RecordFromProto(message));
    routines.push_back(std::move(routine));
  }
  return routines;
}

absl::StatusOr<records::RoutineRecord> Client::StopRoutine(const std::string& name, const MachineId& machine,
                                                           bool stopped, const std::string& note) {
  v1::StopRoutineRequest request;
  request.set_name(name);
  request.set_machine_id(machine.text());
  request.set_stopped(stopped);
  request.set_note(note);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::StopRoutineResponse>(*impl_->routines, &v1::Routines::Stub::StopRoutine, request));
  return convert::RecordFromProto(response.routine());
}

absl::StatusOr<records::RoutineRun> Client::RetryRoutine(const std::string& name, const MachineId& machine) {
  v1::RetryRoutineRequest request;
  request.set_name(name);
  request.set_machine_id(machine.text());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::RetryRoutineResponse>(*impl_->routines, &v1::Routines::Stub::RetryRoutine, request));
  return convert::FromProto(response.run());
}

absl::StatusOr<Page<records::RoutineRun>> Client::ListRoutineRuns(const records::RunFilter& filter,
                                                                  const PageRequest& page) {
  auto request = PageOf<v1::ListRoutineRunsRequest>(page);
  if (filter.machine) request.set_machine_id(filter.machine->text());
  request.set_routine(filter.routine);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::ListRoutineRunsResponse>(
                                            *impl_->routines, &v1::Routines::Stub::ListRoutineRuns, request));
  return ReadPage<records::RoutineRun>(response.runs(), response.next_page_token());
}

}  // namespace axiscal::client
