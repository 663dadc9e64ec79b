// GET /v1/calibrations/N/report: the page that `axiscal report` writes, from the same calls.
#include "axiscal/v1/calibrations_service.grpc.pb.h"
#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "axiscal/v1/machines_service.grpc.pb.h"
#include "core/machine/machine_json.h"
#include "core/sheet/calibration_sheet.h"
#include "core/sheet/html.h"
#include "proto/convert/calibration.h"
#include "proto/convert/session.h"
#include "proto/convert/status.h"
#include "server/http/errors.h"
#include "server/http/forward.h"
#include "server/http/plain.h"

namespace axiscal::http {
namespace {

// One call of the API with the caller's credentials.
template <typename Stub, typename Request, typename Response>
absl::Status Ask(const PlainCall& call, Stub& stub,
                 grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*), const Request& request,
                 Response* response) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded,
                   ForwardedCall::Begin(call.core, call.request, call.credentials, call.exchange));
  const grpc::Status status = (stub.*method)(&forwarded->context(), request, response);
  return status.ok() ? absl::OkStatus() : convert::FromProto(ErrorOf(status));
}

absl::StatusOr<sheet::CalibrationToPrint> LoadCalibrationToPrint(const PlainCall& call, int64_t id,
                                                                 handlers::Share& share) {
  const auto calibrations = v1::Calibrations::NewStub(call.channel);
  v1::GetCalibrationRequest asked;
  asked.set_calibration_id(id);
  v1::GetCalibrationResponse answer;
  RETURN_IF_ERROR(Ask(call, *calibrations, &v1::Calibrations::Stub::GetCalibration, asked, &answer));
  // The message, the report as text and as read, and the page.
  constexpr int64_t kTimesInMemory = 4;
  RETURN_IF_ERROR(share.Take(kTimesInMemory * static_cast<int64_t>(answer.ByteSizeLong())));
  sheet::CalibrationToPrint found;
  ASSIGN_OR_RETURN(found.stored, convert::FromProto(answer.calibration()));
  ASSIGN_OR_RETURN(found.report, reports::ReadCalibrationReport(found.stored->content.report_json));

  const auto machines = v1::Machines::NewStub(call.channel);
  v1::GetMachineRequest asked_machine;
  asked_machine.set_machine_id(found.stored->content.machine.text());
  asked_machine.set_revision(found.stored->content.machine_revision);
  v1::GetMachineResponse described;
  RETURN_IF_ERROR(Ask(call, *machines, &v1::Machines::Stub::GetMachine, asked_machine, &described));
  ASSIGN_OR_RETURN(found.machine, machine::MachineFromJson(described.machine().description_json()));

  const auto ingest = v1::Ingest::NewStub(call.channel);
  for (const SessionId& session : found.stored->content.sessions) {
    v1::GetSessionRequest asked_session;
    asked_session.set_session_id(session.number());
    v1::GetSessionResponse stored;
    RETURN_IF_ERROR(Ask(call, *ingest, &v1::Ingest::Stub::GetSession, asked_session, &stored));
    ASSIGN_OR_RETURN(records::SessionRecord read, convert::FromProto(stored.session()));
    ASSIGN_OR_RETURN(const records::SessionSchema schema, convert::FromProto(stored.schema()));
    read.header = schema.header;
    found.sessions.push_back(std::move(read));
  }
  return found;
}

}  // namespace

void GetSheet(const PlainCall& call, int64_t id) {
  handlers::Share share(call.budget, call.request.counted_as);
  const absl::StatusOr<sheet::CalibrationToPrint> found = LoadCalibrationToPrint(call, id, share);
  if (!found.ok()) {
    call.exchange.Send(ErrorAnswer(found.status()));
    return;
  }
  const auto asked = call.request.query.find("language");
  const bool is_german = asked != call.request.query.end() && asked->second == "de";
  const std::string html =
      sheet::ToHtml(sheet::CalibrationSheet(*found, is_german ? sheet::Language::kGerman : sheet::Language::kEnglish));
  call.exchange.Send(
      {200,
       {{"Content-Type", "text/html; charset=utf-8"},
        {"Cache-Control", "private, no-cache"},
        {"Content-Security-Policy", absl::StrCat("default-src 'none'; style-src ", sheet::StyleHash(),
                                                 "; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")}},
       html});
}

}  // namespace axiscal::http
