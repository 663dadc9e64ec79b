#include "server/access/methods.h"

#include <algorithm>

namespace axiscal::access {

using records::Role;

bool Includes(Role held, Role needed) {
  if (held == needed) return true;
  if (held == Role::kAdmin) return needed != Role::kApprover;
  return needed == Role::kViewer && (held == Role::kTechnician || held == Role::kApprover);
}

const std::vector<MethodRule>& Methods() {
  constexpr Role kViewer = Role::kViewer, kCell = Role::kCell, kTechnician = Role::kTechnician,
                 kApprover = Role::kApprover, kAdmin = Role::kAdmin;
  constexpr bool kFourEyes = true;
  static const auto* const methods = new std::vector<MethodRule>{
      {"Machines.CreateMachine", Reach::kService, {kAdmin}},
      {"Machines.GetMachine", Reach::kNamed, {kViewer, kCell}},
      {"Machines.ListMachines", Reach::kList, {kViewer, kCell}},
      {"Machines.UpdateMachine", Reach::kNamed, {kAdmin}},
      {"Machines.DeleteMachine", Reach::kNamed, {kAdmin}},

      {"Ingest.CreateSession", Reach::kNamed, {kCell}},
      {"Ingest.Upload", Reach::kNamed, {kCell}},
      {"Ingest.UploadOnce", Reach::kNamed, {kCell}},
      {"Ingest.PutLog", Reach::kNamed, {kCell}},
      {"Ingest.GetSession", Reach::kNamed, {kViewer, kCell}},
      {"Ingest.FinishSession", Reach::kNamed, {kCell}},
      {"Ingest.AbortSession", Reach::kNamed, {kCell}},
      {"Ingest.AnnotateSession", Reach::kNamed, {kTechnician, kApprover}},
      {"Ingest.RejectSession", Reach::kNamed, {kTechnician, kApprover}},
      {"Ingest.ListSessions", Reach::kList, {kViewer}},
      {"Ingest.DownloadSession", Reach::kNamed, {kViewer}},
      {"Ingest.ReportCell", Reach::kNamed, {kCell}},
      {"Ingest.ListCells", Reach::kList, {kViewer}},
      {"Ingest.ForgetCell", Reach::kNamed, {kTechnician}},

      {"Jobs.CreateJob", Reach::kNamed, {kTechnician}},
      {"Jobs.GetJob", Reach::kNamed, {kViewer}},
      {"Jobs.GetReport", Reach::kNamed, {kViewer}},
      {"Jobs.ListJobs", Reach::kList, {kViewer}},
      {"Jobs.CancelJob", Reach::kNamed, {kTechnician}},
      {"Jobs.RequeueJob", Reach::kNamed, {kTechnician}},
      {"Jobs.WaitJob", Reach::kNamed, {kViewer}},
      {"Jobs.WatchJob", Reach::kNamed, {kViewer}},

      {"Calibrations.ListCalibrations", Reach::kList, {kViewer}},
      {"Calibrations.GetCalibration", Reach::kNamed, {kViewer}},
      {"Calibrations.DrawCalibration", Reach::kNamed, {kViewer}},
      {"Calibrations.ListResiduals", Reach::kNamed, {kViewer}},
      {"Calibrations.GetVolumetricError", Reach::kNamed, {kViewer}},
      {"Calibrations.ListVolumetricErrors", Reach::kNamed, {kViewer}},
      {"Calibrations.CompareCalibrations", Reach::kNamed, {kViewer}},
      {"Calibrations.ApproveCalibration", Reach::kNamed, {kApprover}, kFourEyes},
      {"Calibrations.RetireCalibration", Reach::kNamed, {kApprover}},

      {"Programs.ListPrograms", Reach::kList, {kViewer}},
      {"Programs.PutProgram", Reach::kNamed, {kTechnician}},
      {"Programs.GetProgram", Reach::kNamed, {kViewer}},
      {"Programs.RewriteProgram", Reach::kNamed, {kTechnician}},

      {"Tables.ListTableFormats", Reach::kAnyone, {}},
      {"Tables.MakeTable", Reach::kNamed, {kTechnician}},

      {"History.QueryDrift", Reach::kNamed, {kViewer}},
      {"History.FindDrift", Reach::kNamed, {kViewer}},
      {"History.LatestFleet", Reach::kList, {kViewer}},
      {"History.ListCare", Reach::kList, {kViewer}},
      {"History.PutMark", Reach::kNamed, {kTechnician, kApprover}},
      {"History.ListMarks", Reach::kNamed, {kViewer}},
      {"History.WithdrawMark", Reach::kNamed, {kTechnician, kApprover}},

      {"Events.GetExpectations", Reach::kNamed, {kViewer}},
      {"Events.SetExpectations", Reach::kNamed, {kTechnician, kApprover}},
      {"Events.ListEvents", Reach::kList, {kViewer}},
      {"Events.WatchEvents", Reach::kList, {kViewer}},
      {"Events.AcknowledgeEvent", Reach::kNamed, {kTechnician, kApprover}},
      {"Events.ShelveEvent", Reach::kNamed, {kTechnician, kApprover}},

      {"Routines.PutRoutine", Reach::kService, {kAdmin}},
      {"Routines.RemoveRoutine", Reach::kService, {kAdmin}},
      {"Routines.ListRoutines", Reach::kList, {kViewer}},
      {"Routines.StopRoutine", Reach::kNamed, {kTechnician, kApprover}},
      {"Routines.RetryRoutine", Reach::kNamed, {kTechnician}},
      {"Routines.ListRoutineRuns", Reach::kList, {kViewer}},

      {"Webhooks.PutWebhook", Reach::kService, {kAdmin}},
      {"Webhooks.RemoveWebhook", Reach::kService, {kAdmin}},
      {"Webhooks.ListWebhooks", Reach::kService, {kAdmin}},
      {"Webhooks.TestWebhook", Reach::kService, {kAdmin}},
      {"Webhooks.ListDeadLetters", Reach::kService, {kAdmin}},
      {"Webhooks.ResendDeadLetters", Reach::kService, {kAdmin}},

      {"Admin.GetServerInfo", Reach::kAnyone, {}},
      {"Admin.GetMetrics", Reach::kService, {kViewer}},
      {"Admin.Diagnose", Reach::kService, {kViewer}},
      {"Admin.SetLogLevel", Reach::kService, {kAdmin}},

      {"Access.GetIdentity", Reach::kAnyone, {}},
      {"Access.CreatePrincipal", Reach::kService, {kAdmin}},
      {"Access.RevokePrincipal", Reach::kService, {kAdmin}},
      {"Access.ListPrincipals", Reach::kService, {kAdmin}},
      {"Access.CreateToken", Reach::kService, {kAdmin}},
      {"Access.RevokeToken", Reach::kService, {kAdmin}},
      {"Access.ChangeRole", Reach::kService, {kAdmin}},
      {"Access.ChangeGroup", Reach::kService, {kAdmin}},
      {"Access.SetFourEyes", Reach::kService, {kAdmin}},
      {"Access.ListMachineAccess", Reach::kService, {kAdmin}},
      {"Admin.Backup", Reach::kService, {kAdmin}},
      {"Access.ListAudit", Reach::kService, {kAdmin}},
      {"Access.CheckAudit", Reach::kService, {kAdmin}},
  };
  return *methods;
}

const MethodRule* FindMethod(const std::string& method) {
  const auto found =
      std::find_if(Methods().begin(), Methods().end(), [&](const MethodRule& rule) { return rule.method == method; });
  return found == Methods().end() ? nullptr : &*found;
}

}  // namespace axiscal::access
