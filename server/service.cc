#include "server/service.h"

#include "axiscal/v1/access_service.grpc.pb.h"
#include "axiscal/v1/admin_service.grpc.pb.h"
#include "axiscal/v1/calibrations_service.grpc.pb.h"
#include "axiscal/v1/events_service.grpc.pb.h"
#include "axiscal/v1/history_service.grpc.pb.h"
#include "axiscal/v1/jobs_service.grpc.pb.h"
#include "axiscal/v1/machines_service.grpc.pb.h"
#include "axiscal/v1/routines_service.grpc.pb.h"
#include "axiscal/v1/tables_service.grpc.pb.h"
#include "axiscal/v1/webhooks_service.grpc.pb.h"
#include "server/handlers/access.h"
#include "server/handlers/approve_calibration.h"
#include "server/handlers/backup.h"
#include "server/handlers/cancel_job.h"
#include "server/handlers/compare_calibrations.h"
#include "server/handlers/create_job.h"
#include "server/handlers/create_machine.h"
#include "server/handlers/delete_machine.h"
#include "server/handlers/diagnose.h"
#include "server/handlers/draw_calibration.h"
#include "server/handlers/events.h"
#include "server/handlers/find_drift.h"
#include "server/handlers/get_calibration.h"
#include "server/handlers/get_job.h"
#include "server/handlers/get_machine.h"
#include "server/handlers/get_metrics.h"
#include "server/handlers/get_server_info.h"
#include "server/handlers/latest_fleet.h"
#include "server/handlers/list_calibrations.h"
#include "server/handlers/list_care.h"
#include "server/handlers/list_jobs.h"
#include "server/handlers/list_machines.h"
#include "server/handlers/list_residuals.h"
#include "server/handlers/list_table_formats.h"
#include "server/handlers/make_table.h"
#include "server/handlers/marks.h"
#include "server/handlers/query_drift.h"
#include "server/handlers/requeue_job.h"
#include "server/handlers/retire_calibration.h"
#include "server/handlers/routines.h"
#include "server/handlers/update_machine.h"
#include "server/handlers/volumetric.h"
#include "server/handlers/wait_job.h"
#include "server/handlers/watch_events.h"
#include "server/handlers/watch_job.h"
#include "server/handlers/webhooks.h"
#include "server/respond.h"

namespace axiscal::server {
namespace {

class MachinesService final : public v1::Machines::Service {
 public:
  explicit MachinesService(handlers::Core& core) : core_(core) {}

  grpc::Status CreateMachine(grpc::ServerContext* context, const v1::CreateMachineRequest* request,
                             v1::CreateMachineResponse* response) override {
    return Respond(
        core_, context, "Machines.CreateMachine", request,
        [&](const auto& call) { return handlers::CreateMachine(core_, call, *request); }, response);
  }
  grpc::Status GetMachine(grpc::ServerContext* context, const v1::GetMachineRequest* request,
                          v1::GetMachineResponse* response) override {
    return Respond(
        core_, context, "Machines.GetMachine", request,
        [&](const auto& call) { return handlers::GetMachine(core_, call, *request); }, response);
  }
  grpc::Status ListMachines(grpc::ServerContext* context, const v1::ListMachinesRequest* request,
                            v1::ListMachinesResponse* response) override {
    return Respond(
        core_, context, "Machines.ListMachines", request,
        [&](const auto& call) { return handlers::ListMachines(core_, call, *request); }, response);
  }
  grpc::Status UpdateMachine(grpc::ServerContext* context, const v1::UpdateMachineRequest* request,
                             v1::UpdateMachineResponse* response) override {
    return Respond(
        core_, context, "Machines.UpdateMachine", request,
        [&](const auto& call) { return handlers::UpdateMachine(core_, call, *request); }, response);
  }
  grpc::Status DeleteMachine(grpc::ServerContext* context, const v1::DeleteMachineRequest* request,
                             v1::DeleteMachineResponse* response) override {
    return Respond(
        core_, context, "Machines.DeleteMachine", request,
        [&](const auto& call) { return handlers::DeleteMachine(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

class JobsService final : public v1::Jobs::Service {
 public:
  explicit JobsService(handlers::Core& core) : core_(core) {}

  grpc::Status CreateJob(grpc::ServerContext* context, const v1::CreateJobRequest* request,
                         v1::CreateJobResponse* response) override {
    return Respond(
        core_, context, "Jobs.CreateJob", request,
        [&](const auto& call) { return handlers::CreateJob(core_, call, *request); }, response);
  }
  grpc::Status GetJob(grpc::ServerContext* context, const v1::GetJobRequest* request,
                      v1::GetJobResponse* response) override {
    return Respond(
        core_, context, "Jobs.GetJob", request,
        [&](const auto& call) { return handlers::GetJob(core_, call, *request); }, response);
  }
  grpc::Status GetReport(grpc::ServerContext* context, const v1::GetReportRequest* request,
                         v1::GetReportResponse* response) override {
    return Respond(
        core_, context, "Jobs.GetReport", request,
        [&](const auto& call) { return handlers::GetReport(core_, call, *request); }, response);
  }
  grpc::Status ListJobs(grpc::ServerContext* context, const v1::ListJobsRequest* request,
                        v1::ListJobsResponse* response) override {
    return Respond(
        core_, context, "Jobs.ListJobs", request,
        [&](const auto& call) { return handlers::ListJobs(core_, call, *request); }, response);
  }
  grpc::Status CancelJob(grpc::ServerContext* context, const v1::CancelJobRequest* request,
                         v1::CancelJobResponse* response) override {
    return Respond(
        core_, context, "Jobs.CancelJob", request,
        [&](const auto& call) { return handlers::CancelJob(core_, call, *request); }, response);
  }
  grpc::Status RequeueJob(grpc::ServerContext* context, const v1::RequeueJobRequest* request,
                          v1::RequeueJobResponse* response) override {
    return Respond(
        core_, context, "Jobs.RequeueJob", request,
        [&](const auto& call) { return handlers::RequeueJob(core_, call, *request); }, response);
  }
  grpc::Status WaitJob(grpc::ServerContext* context, const v1::WaitJobRequest* request,
                       v1::WaitJobResponse* response) override {
    return Respond(
        core_, context, "Jobs.WaitJob", request,
        [&](const auto& call) -> absl::StatusOr<v1::WaitJobResponse> {
          const handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kWatch, call.cut_off,
                                        call.counted_as);
          RETURN_IF_ERROR(held.status());
          return handlers::WaitJob(core_, call, *request);
        },
        response);
  }
  grpc::Status WatchJob(grpc::ServerContext* context, const v1::WatchJobRequest* request,
                        grpc::ServerWriter<v1::WatchJobResponse>* writer) override {
    return RespondStream(core_, context, "Jobs.WatchJob", request, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kWatch, call.cut_off, call.counted_as);
      RETURN_IF_ERROR(held.status());
      return handlers::WatchJob(core_, call, *request, [&](const auto& message) {
        return held.Await([&] { return writer->Write(message); });
      });
    });
  }

 private:
  handlers::Core& core_;
};

class CalibrationsService final : public v1::Calibrations::Service {
 public:
  explicit CalibrationsService(handlers::Core& core) : core_(core) {}

  grpc::Status ListCalibrations(grpc::ServerContext* context, const v1::ListCalibrationsRequest* request,
                                v1::ListCalibrationsResponse* response) override {
    return Respond(
        core_, context, "Calibrations.ListCalibrations", request,
        [&](const auto& call) { return handlers::ListCalibrations(core_, call, *request); }, response);
  }
  grpc::Status GetCalibration(grpc::ServerContext* context, const v1::GetCalibrationRequest* request,
                              v1::GetCalibrationResponse* response) override {
    return Respond(
        core_, context, "Calibrations.GetCalibration", request,
        [&](const auto& call) { return handlers::GetCalibration(core_, call, *request); }, response);
  }
  grpc::Status ApproveCalibration(grpc::ServerContext* context, const v1::ApproveCalibrationRequest* request,
                                  v1::ApproveCalibrationResponse* response) override {
    return Respond(
        core_, context, "Calibrations.ApproveCalibration", request,
        [&](const auto& call) { return handlers::ApproveCalibration(core_, call, *request); }, response);
  }
  grpc::Status RetireCalibration(grpc::ServerContext* context, const v1::RetireCalibrationRequest* request,
                                 v1::RetireCalibrationResponse* response) override {
    return Respond(
        core_, context, "Calibrations.RetireCalibration", request,
        [&](const auto& call) { return handlers::RetireCalibration(core_, call, *request); }, response);
  }
  grpc::Status DrawCalibration(grpc::ServerContext* context, const v1::DrawCalibrationRequest* request,
                               v1::DrawCalibrationResponse* response) override {
    return Respond(
        core_, context, "Calibrations.DrawCalibration", request,
        [&](const auto& call) { return handlers::DrawCalibration(core_, call, *request); }, response);
  }
  grpc::Status ListResiduals(grpc::ServerContext* context, const v1::ListResidualsRequest* request,
                             v1::ListResidualsResponse* response) override {
    return Respond(
        core_, context, "Calibrations.ListResiduals", request,
        [&](const auto& call) { return handlers::ListResiduals(core_, call, *request); }, response);
  }
  grpc::Status GetVolumetricError(grpc::ServerContext* context, const v1::GetVolumetricErrorRequest* request,
                                  v1::GetVolumetricErrorResponse* response) override {
    return Respond(
        core_, context, "Calibrations.GetVolumetricError", request,
        [&](const auto& call) { return handlers::GetVolumetricError(core_, call, *request); }, response);
  }
  grpc::Status ListVolumetricErrors(grpc::ServerContext* context, const v1::ListVolumetricErrorsRequest* request,
                                    v1::ListVolumetricErrorsResponse* response) override {
    return Respond(
        core_, context, "Calibrations.ListVolumetricErrors", request,
        [&](const auto& call) { return handlers::ListVolumetricErrors(core_, call, *request); }, response);
  }
  grpc::Status CompareCalibrations(grpc::ServerContext* context, const v1::CompareCalibrationsRequest* request,
                                   v1::CompareCalibrationsResponse* response) override {
    return Respond(
        core_, context, "Calibrations.CompareCalibrations", request,
        [&](const auto& call) { return handlers::CompareCalibrations(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

class HistoryService final : public v1::History::Service {
 public:
  explicit HistoryService(handlers::Core& core) : core_(core) {}

  grpc::Status QueryDrift(grpc::ServerContext* context, const v1::QueryDriftRequest* request,
                          v1::QueryDriftResponse* response) override {
    return Respond(
        core_, context, "History.QueryDrift", request,
        [&](const auto& call) { return handlers::QueryDrift(core_, call, *request); }, response);
  }
  grpc::Status LatestFleet(grpc::ServerContext* context, const v1::LatestFleetRequest* request,
                           v1::LatestFleetResponse* response) override {
    return Respond(
        core_, context, "History.LatestFleet", request,
        [&](const auto& call) { return handlers::LatestFleet(core_, call, *request); }, response);
  }
  grpc::Status FindDrift(grpc::ServerContext* context, const v1::FindDriftRequest* request,
                         v1::FindDriftResponse* response) override {
    return Respond(
        core_, context, "History.FindDrift", request,
        [&](const auto& call) { return handlers::FindDrift(core_, call, *request); }, response);
  }
  grpc::Status ListCare(grpc::ServerContext* context, const v1::ListCareRequest* request,
                        v1::ListCareResponse* response) override {
    return Respond(
        core_, context, "History.ListCare", request,
        [&](const auto& call) { return handlers::ListCare(core_, call, *request); }, response);
  }
  grpc::Status PutMark(grpc::ServerContext* context, const v1::PutMarkRequest* request,
                       v1::PutMarkResponse* response) override {
    return Respond(
        core_, context, "History.PutMark", request,
        [&](const auto& call) { return handlers::PutMark(core_, call, *request); }, response);
  }
  grpc::Status ListMarks(grpc::ServerContext* context, const v1::ListMarksRequest* request,
                         v1::ListMarksResponse* response) override {
    return Respond(
        core_, context, "History.ListMarks", request,
        [&](const auto& call) { return handlers::ListMarks(core_, call, *request); }, response);
  }
  grpc::Status WithdrawMark(grpc::ServerContext* context, const v1::WithdrawMarkRequest* request,
                            v1::WithdrawMarkResponse* response) override {
    return Respond(
        core_, context, "History.WithdrawMark", request,
        [&](const auto& call) { return handlers::WithdrawMark(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

class EventsService final : public v1::Events::Service {
 public:
  explicit EventsService(handlers::Core& core) : core_(core) {}

  grpc::Status GetExpectations(grpc::ServerContext* context, const v1::GetExpectationsRequest* request,
                               v1::GetExpectationsResponse* response) override {
    return Respond(
        core_, context, "Events.GetExpectations", request,
        [&](const auto& call) { return handlers::GetExpectations(core_, call, *request); }, response);
  }
  grpc::Status SetExpectations(grpc::ServerContext* context, const v1::SetExpectationsRequest* request,
                               v1::SetExpectationsResponse* response) override {
    return Respond(
        core_, context, "Events.SetExpectations", request,
        [&](const auto& call) { return handlers::SetExpectations(core_, call, *request); }, response);
  }
  grpc::Status ListEvents(grpc::ServerContext* context, const v1::ListEventsRequest* request,
                          v1::ListEventsResponse* response) override {
    return Respond(
        core_, context, "Events.ListEvents", request,
        [&](const auto& call) { return handlers::ListEvents(core_, call, *request); }, response);
  }
  grpc::Status AcknowledgeEvent(grpc::ServerContext* context, const v1::AcknowledgeEventRequest* request,
                                v1::AcknowledgeEventResponse* response) override {
    return Respond(
        core_, context, "Events.AcknowledgeEvent", request,
        [&](const auto& call) { return handlers::AcknowledgeEvent(core_, call, *request); }, response);
  }
  grpc::Status ShelveEvent(grpc::ServerContext* context, const v1::ShelveEventRequest* request,
                           v1::ShelveEventResponse* response) override {
    return Respond(
        core_, context, "Events.ShelveEvent", request,
        [&](const auto& call) { return handlers::ShelveEvent(core_, call, *request); }, response);
  }
  grpc::Status WatchEvents(grpc::ServerContext* context, const v1::WatchEventsRequest* request,
                           grpc::ServerWriter<v1::WatchEventsResponse>* writer) override {
    return RespondStream(core_, context, "Events.WatchEvents", request, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kWatch, call.cut_off, call.counted_as);
      RETURN_IF_ERROR(held.status());
      return handlers::WatchEvents(core_, call, *request, [&](const auto& message) {
        return held.Await([&] { return writer->Write(message); });
      });
    });
  }

 private:
  handlers::Core& core_;
};

class RoutinesService final : public v1::Routines::Service {
 public:
  explicit RoutinesService(handlers::Core& core) : core_(core) {}

  grpc::Status PutRoutine(grpc::ServerContext* context, const v1::PutRoutineRequest* request,
                          v1::PutRoutineResponse* response) override {
    return Respond(
        core_, context, "Routines.PutRoutine", request,
        [&](const auto& call) { return handlers::PutRoutine(core_, call, *request); }, response);
  }
  grpc::Status RemoveRoutine(grpc::ServerContext* context, const v1::RemoveRoutineRequest* request,
                             v1::RemoveRoutineResponse* response) override {
    return Respond(
        core_, context, "Routines.RemoveRoutine", request,
        [&](const auto& call) { return handlers::RemoveRoutine(core_, call, *request); }, response);
  }
  grpc::Status ListRoutines(grpc::ServerContext* context, const v1::ListRoutinesRequest* request,
                            v1::ListRoutinesResponse* response) override {
    return Respond(
        core_, context, "Routines.ListRoutines", request,
        [&](const auto& call) { return handlers::ListRoutines(core_, call, *request); }, response);
  }
  grpc::Status StopRoutine(grpc::ServerContext* context, const v1::StopRoutineRequest* request,
                           v1::StopRoutineResponse* response) override {
    return Respond(
        core_, context, "Routines.StopRoutine", request,
        [&](const auto& call) { return handlers::StopRoutine(core_, call, *request); }, response);
  }
  grpc::Status RetryRoutine(grpc::ServerContext* context, const v1::RetryRoutineRequest* request,
                            v1::RetryRoutineResponse* response) override {
    return Respond(
        core_, context, "Routines.RetryRoutine", request,
        [&](const auto& call) { return handlers::RetryRoutine(core_, call, *request); }, response);
  }
  grpc::Status ListRoutineRuns(grpc::ServerContext* context, const v1::ListRoutineRunsRequest* request,
                               v1::ListRoutineRunsResponse* response) override {
    return Respond(
        core_, context, "Routines.ListRoutineRuns", request,
        [&](const auto& call) { return handlers::ListRoutineRuns(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

class WebhooksService final : public v1::Webhooks::Service {
 public:
  explicit WebhooksService(handlers::Core& core) : core_(core) {}

  grpc::Status PutWebhook(grpc::ServerContext* context, const v1::PutWebhookRequest* request,
                          v1::PutWebhookResponse* response) override {
    return Respond(
        core_, context, "Webhooks.PutWebhook", request,
        [&](const auto& call) { return handlers::PutWebhook(core_, call, *request); }, response);
  }
  grpc::Status RemoveWebhook(grpc::ServerContext* context, const v1::RemoveWebhookRequest* request,
                             v1::RemoveWebhookResponse* response) override {
    return Respond(
        core_, context, "Webhooks.RemoveWebhook", request,
        [&](const auto& call) { return handlers::RemoveWebhook(core_, call, *request); }, response);
  }
  grpc::Status ListWebhooks(grpc::ServerContext* context, const v1::ListWebhooksRequest* request,
                            v1::ListWebhooksResponse* response) override {
    return Respond(
        core_, context, "Webhooks.ListWebhooks", request,
        [&](const auto& call) { return handlers::ListWebhooks(core_, call, *request); }, response);
  }
  grpc::Status TestWebhook(grpc::ServerContext* context, const v1::TestWebhookRequest* request,
                           v1::TestWebhookResponse* response) override {
    return Respond(
        core_, context, "Webhooks.TestWebhook", request,
        [&](const auto& call) { return handlers::TestWebhook(core_, call, *request); }, response);
  }
  grpc::Status ListDeadLetters(grpc::ServerContext* context, const v1::ListDeadLettersRequest* request,
                               v1::ListDeadLettersResponse* response) override {
    return Respond(
        core_, context, "Webhooks.ListDeadLetters", request,
        [&](const auto& call) { return handlers::ListDeadLetters(core_, call, *request); }, response);
  }
  grpc::Status ResendDeadLetters(grpc::ServerContext* context, const v1::ResendDeadLettersRequest* request,
                                 v1::ResendDeadLettersResponse* response) override {
    return Respond(
        core_, context, "Webhooks.ResendDeadLetters", request,
        [&](const auto& call) { return handlers::ResendDeadLetters(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

class TablesService final : public v1::Tables::Service {
 public:
  explicit TablesService(handlers::Core& core) : core_(core) {}

  grpc::Status ListTableFormats(grpc::ServerContext* context, const v1::ListTableFormatsRequest* request,
                                v1::ListTableFormatsResponse* response) override {
    return Respond(
        core_, context, "Tables.ListTableFormats", request,
        [&](const auto& call) { return handlers::ListTableFormats(core_, call, *request); }, response);
  }
  grpc::Status MakeTable(grpc::ServerContext* context, const v1::MakeTableRequest* request,
                         v1::MakeTableResponse* response) override {
    return Respond(
        core_, context, "Tables.MakeTable", request,
        [&](const auto& call) { return handlers::MakeTable(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

class AdminService final : public v1::Admin::Service {
 public:
  explicit AdminService(handlers::Core& core) : core_(core) {}

  grpc::Status GetServerInfo(grpc::ServerContext* context, const v1::GetServerInfoRequest* request,
                             v1::GetServerInfoResponse* response) override {
    return Respond(
        core_, context, "Admin.GetServerInfo", request,
        [&](const auto& call) { return handlers::GetServerInfo(core_, call, *request); }, response);
  }
  grpc::Status GetMetrics(grpc::ServerContext* context, const v1::GetMetricsRequest* request,
                          v1::GetMetricsResponse* response) override {
    return Respond(
        core_, context, "Admin.GetMetrics", request,
        [&](const auto& call) { return handlers::GetMetrics(core_, call, *request); }, response);
  }
  grpc::Status Diagnose(grpc::ServerContext* context, const v1::DiagnoseRequest* request,
                        v1::DiagnoseResponse* response) override {
    return Respond(
        core_, context, "Admin.Diagnose", request,
        [&](const auto& call) { return handlers::Diagnose(core_, call, *request); }, response);
  }
  grpc::Status SetLogLevel(grpc::ServerContext* context, const v1::SetLogLevelRequest* request,
                           v1::SetLogLevelResponse* response) override {
    return Respond(
        core_, context, "Admin.SetLogLevel", request,
        [&](const auto& call) { return handlers::SetLogLevel(core_, call, *request); }, response);
  }
  grpc::Status Backup(grpc::ServerContext* context, const v1::BackupRequest* request,
                      grpc::ServerWriter<v1::BackupResponse>* writer) override {
    return RespondStream(core_, context, "Admin.Backup", request, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kDownload, call.cut_off,
                              call.counted_as);
      RETURN_IF_ERROR(held.status());
      return handlers::Backup(core_, call, *request,
                              [&](const auto& message) { return held.Await([&] { return writer->Write(message); }); });
    });
  }

 private:
  handlers::Core& core_;
};

class AccessService final : public v1::Access::Service {
 public:
  explicit AccessService(handlers::Core& core) : core_(core) {}

  grpc::Status GetIdentity(grpc::ServerContext* context, const v1::GetIdentityRequest* request,
                           v1::GetIdentityResponse* response) override {
    return Respond(
        core_, context, "Access.GetIdentity", request,
        [&](const auto& call) { return handlers::GetIdentity(core_, call, *request); }, response);
  }
  grpc::Status CreatePrincipal(grpc::ServerContext* context, const v1::CreatePrincipalRequest* request,
                               v1::CreatePrincipalResponse* response) override {
    return Respond(
        core_, context, "Access.CreatePrincipal", request,
        [&](const auto& call) { return handlers::CreatePrincipal(core_, call, *request); }, response);
  }
  grpc::Status RevokePrincipal(grpc::ServerContext* context, const v1::RevokePrincipalRequest* request,
                               v1::RevokePrincipalResponse* response) override {
    return Respond(
        core_, context, "Access.RevokePrincipal", request,
        [&](const auto& call) { return handlers::RevokePrincipal(core_, call, *request); }, response);
  }
  grpc::Status ListPrincipals(grpc::ServerContext* context, const v1::ListPrincipalsRequest* request,
                              v1::ListPrincipalsResponse* response) override {
    return Respond(
        core_, context, "Access.ListPrincipals", request,
        [&](const auto& call) { return handlers::ListPrincipals(core_, call, *request); }, response);
  }
  grpc::Status CreateToken(grpc::ServerContext* context, const v1::CreateTokenRequest* request,
                           v1::CreateTokenResponse* response) override {
    return Respond(
        core_, context, "Access.CreateToken", request,
        [&](const auto& call) { return handlers::CreateToken(core_, call, *request); }, response);
  }
  grpc::Status RevokeToken(grpc::ServerContext* context, const v1::RevokeTokenRequest* request,
                           v1::RevokeTokenResponse* response) override {
    return Respond(
        core_, context, "Access.RevokeToken", request,
        [&](const auto& call) { return handlers::RevokeToken(core_, call, *request); }, response);
  }
  grpc::Status ChangeRole(grpc::ServerContext* context, const v1::ChangeRoleRequest* request,
                          v1::ChangeRoleResponse* response) override {
    return Respond(
        core_, context, "Access.ChangeRole", request,
        [&](const auto& call) { return handlers::ChangeRole(core_, call, *request); }, response);
  }
  grpc::Status ChangeGroup(grpc::ServerContext* context, const v1::ChangeGroupRequest* request,
                           v1::ChangeGroupResponse* response) override {
    return Respond(
        core_, context, "Access.ChangeGroup", request,
        [&](const auto& call) { return handlers::ChangeGroup(core_, call, *request); }, response);
  }
  grpc::Status SetFourEyes(grpc::ServerContext* context, const v1::SetFourEyesRequest* request,
                           v1::SetFourEyesResponse* response) override {
    return Respond(
        core_, context, "Access.SetFourEyes", request,
        [&](const auto& call) { return handlers::SetFourEyes(core_, call, *request); }, response);
  }
  grpc::Status ListMachineAccess(grpc::ServerContext* context, const v1::ListMachineAccessRequest* request,
                                 v1::ListMachineAccessResponse* response) override {
    return Respond(
        core_, context, "Access.ListMachineAccess", request,
        [&](const auto& call) { return handlers::ListMachineAccess(core_, call, *request); }, response);
  }
  grpc::Status ListAudit(grpc::ServerContext* context, const v1::ListAuditRequest* request,
                         v1::ListAuditResponse* response) override {
    return Respond(
        core_, context, "Access.ListAudit", request,
        [&](const auto& call) { return handlers::ListAudit(core_, call, *request); }, response);
  }
  grpc::Status CheckAudit(grpc::ServerContext* context, const v1::CheckAuditRequest* request,
                          v1::CheckAuditResponse* response) override {
    return Respond(
        core_, context, "Access.CheckAudit", request,
        [&](const auto& call) { return handlers::CheckAudit(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

}  // namespace

std::vector<std::unique_ptr<grpc::Service>> MakeServices(handlers::Core& core) {
  std::vector<std::unique_ptr<grpc::Service>> services;
  services.push_back(std::make_unique<MachinesService>(core));
  services.push_back(MakeIngestService(core));
  services.push_back(std::make_unique<JobsService>(core));
  services.push_back(std::make_unique<CalibrationsService>(core));
  services.push_back(MakeProgramsService(core));
  services.push_back(std::make_unique<HistoryService>(core));
  services.push_back(std::make_unique<EventsService>(core));
  services.push_back(std::make_unique<RoutinesService>(core));
  services.push_back(std::make_unique<WebhooksService>(core));
  services.push_back(std::make_unique<TablesService>(core));
  services.push_back(std::make_unique<AdminService>(core));
  services.push_back(std::make_unique<AccessService>(core));
  return services;
}

}  // namespace axiscal::server
