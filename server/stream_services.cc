// The services whose calls stream bytes in and out.
#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "axiscal/v1/programs_service.grpc.pb.h"
#include "server/handlers/abort_session.h"
#include "server/handlers/cells.h"
#include "server/handlers/create_session.h"
#include "server/handlers/download_session.h"
#include "server/handlers/finish_session.h"
#include "server/handlers/get_program.h"
#include "server/handlers/get_session.h"
#include "server/handlers/list_programs.h"
#include "server/handlers/list_sessions.h"
#include "server/handlers/put_log.h"
#include "server/handlers/put_program.h"
#include "server/handlers/rewrite_program.h"
#include "server/handlers/session_remarks.h"
#include "server/handlers/upload.h"
#include "server/respond.h"
#include "server/service.h"

namespace axiscal::server {
namespace {

// Messages until the caller ends its side, or sends what cannot be read: gRPC tells the two apart no more than we can.
// What the first one names, the caller must be allowed.
template <typename Request, typename Stream, typename Receiver>
absl::Status ReceiveAll(handlers::HeldCall& held, const handlers::Call& call, Stream& stream, Receiver& receiver) {
  RETURN_IF_ERROR(held.status());
  Request request;
  for (bool is_first = true; held.Await([&] { return stream.Read(&request); }); is_first = false) {
    if (is_first) RETURN_IF_ERROR(call.admit(request));
    RETURN_IF_ERROR(receiver.Receive(request));
  }
  return held.status();
}

class IngestService final : public v1::Ingest::Service {
 public:
  explicit IngestService(handlers::Core& core) : core_(core) {}

  grpc::Status CreateSession(grpc::ServerContext* context, const v1::CreateSessionRequest* request,
                             v1::CreateSessionResponse* response) override {
    return Respond(
        core_, context, "Ingest.CreateSession", request,
        [&](const auto& call) { return handlers::CreateSession(core_, call, *request); }, response);
  }
  grpc::Status GetSession(grpc::ServerContext* context, const v1::GetSessionRequest* request,
                          v1::GetSessionResponse* response) override {
    return Respond(
        core_, context, "Ingest.GetSession", request,
        [&](const auto& call) { return handlers::GetSession(core_, call, *request); }, response);
  }
  grpc::Status FinishSession(grpc::ServerContext* context, const v1::FinishSessionRequest* request,
                             v1::FinishSessionResponse* response) override {
    return Respond(
        core_, context, "Ingest.FinishSession", request,
        [&](const auto& call) { return handlers::FinishSession(core_, call, *request); }, response);
  }
  grpc::Status AbortSession(grpc::ServerContext* context, const v1::AbortSessionRequest* request,
                            v1::AbortSessionResponse* response) override {
    return Respond(
        core_, context, "Ingest.AbortSession", request,
        [&](const auto& call) { return handlers::AbortSession(core_, call, *request); }, response);
  }
  grpc::Status AnnotateSession(grpc::ServerContext* context, const v1::AnnotateSessionRequest* request,
                               v1::AnnotateSessionResponse* response) override {
    return Respond(
        core_, context, "Ingest.AnnotateSession", request,
        [&](const auto& call) { return handlers::AnnotateSession(core_, call, *request); }, response);
  }
  grpc::Status RejectSession(grpc::ServerContext* context, const v1::RejectSessionRequest* request,
                             v1::RejectSessionResponse* response) override {
    return Respond(
        core_, context, "Ingest.RejectSession", request,
        [&](const auto& call) { return handlers::RejectSession(core_, call, *request); }, response);
  }
  grpc::Status ListSessions(grpc::ServerContext* context, const v1::ListSessionsRequest* request,
                            v1::ListSessionsResponse* response) override {
    return Respond(
        core_, context, "Ingest.ListSessions", request,
        [&](const auto& call) { return handlers::ListSessions(core_, call, *request); }, response);
  }
  grpc::Status DownloadSession(grpc::ServerContext* context, const v1::DownloadSessionRequest* request,
                               grpc::ServerWriter<v1::DownloadSessionResponse>* writer) override {
    return RespondStream(core_, context, "Ingest.DownloadSession", request, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kDownload, call.cut_off,
                              call.counted_as);
      RETURN_IF_ERROR(held.status());
      return handlers::DownloadSession(core_, call, *request, [&](const auto& message) {
        return held.Await([&] { return writer->Write(message); });
      });
    });
  }
  grpc::Status Upload(grpc::ServerContext* context,
                      grpc::ServerReaderWriter<v1::UploadResponse, v1::UploadRequest>* stream) override {
    return RespondStream(core_, context, "Ingest.Upload", nullptr, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kUpload, call.cut_off,
                              call.counted_as);
      // An acknowledgement is written while the caller sends: only who does neither is silent.
      handlers::UploadStream upload(core_, call,
                                    {[&](const auto& response) { return stream->Write(response); },
                                     [&](const auto& wait) {
                                       held.Await([&] {
                                         wait();
                                         return true;
                                       });
                                     }});
      RETURN_IF_ERROR(ReceiveAll<v1::UploadRequest>(held, call, *stream, upload));
      RETURN_IF_ERROR(upload.End());
      return held.status();
    });
  }
  grpc::Status UploadOnce(grpc::ServerContext* context, grpc::ServerReader<v1::UploadRequest>* reader,
                          v1::UploadOnceResponse* response) override {
    return RespondStream(core_, context, "Ingest.UploadOnce", nullptr, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kUpload, call.cut_off,
                              call.counted_as);
      handlers::UploadStream upload(core_, call, {});
      RETURN_IF_ERROR(ReceiveAll<v1::UploadRequest>(held, call, *reader, upload));
      RETURN_IF_ERROR(upload.End());
      return handlers::Summarise(upload, response);
    });
  }

  grpc::Status PutLog(grpc::ServerContext* context, grpc::ServerReader<v1::PutLogRequest>* reader,
                      v1::PutLogResponse* response) override {
    return Respond(
        core_, context, "Ingest.PutLog", nullptr,
        [&](const auto& call) -> absl::StatusOr<v1::PutLogResponse> {
          handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kUpload, call.cut_off,
                                  call.counted_as);
          handlers::PutLogStream log(core_, call);
          RETURN_IF_ERROR(ReceiveAll<v1::PutLogRequest>(held, call, *reader, log));
          return log.End();
        },
        response);
  }
  grpc::Status ReportCell(grpc::ServerContext* context, const v1::ReportCellRequest* request,
                          v1::ReportCellResponse* response) override {
    return Respond(
        core_, context, "Ingest.ReportCell", request,
        [&](const auto& call) { return handlers::ReportCell(core_, call, *request); }, response);
  }
  grpc::Status ListCells(grpc::ServerContext* context, const v1::ListCellsRequest* request,
                         v1::ListCellsResponse* response) override {
    return Respond(
        core_, context, "Ingest.ListCells", request,
        [&](const auto& call) { return handlers::ListCells(core_, call, *request); }, response);
  }
  grpc::Status ForgetCell(grpc::ServerContext* context, const v1::ForgetCellRequest* request,
                          v1::ForgetCellResponse* response) override {
    return Respond(
        core_, context, "Ingest.ForgetCell", request,
        [&](const auto& call) { return handlers::ForgetCell(core_, call, *request); }, response);
  }

 private:
  handlers::Core& core_;
};

class ProgramsService final : public v1::Programs::Service {
 public:
  explicit ProgramsService(handlers::Core& core) : core_(core) {}

  grpc::Status ListPrograms(grpc::ServerContext* context, const v1::ListProgramsRequest* request,
                            v1::ListProgramsResponse* response) override {
    return Respond(
        core_, context, "Programs.ListPrograms", request,
        [&](const auto& call) { return handlers::ListPrograms(core_, call, *request); }, response);
  }
  grpc::Status GetProgram(grpc::ServerContext* context, const v1::GetProgramRequest* request,
                          grpc::ServerWriter<v1::GetProgramResponse>* writer) override {
    return RespondStream(core_, context, "Programs.GetProgram", request, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kDownload, call.cut_off,
                              call.counted_as);
      RETURN_IF_ERROR(held.status());
      return handlers::GetProgram(core_, call, *request, [&](const auto& message) {
        return held.Await([&] { return writer->Write(message); });
      });
    });
  }
  grpc::Status PutProgram(grpc::ServerContext* context, grpc::ServerReader<v1::PutProgramRequest>* reader,
                          v1::PutProgramResponse* response) override {
    return Respond(
        core_, context, "Programs.PutProgram", nullptr,
        [&](const auto& call) -> absl::StatusOr<v1::PutProgramResponse> {
          handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kUpload, call.cut_off,
                                  call.counted_as);
          handlers::PutProgramStream program(core_, call);
          RETURN_IF_ERROR(ReceiveAll<v1::PutProgramRequest>(held, call, *reader, program));
          return program.End();
        },
        response);
  }
  grpc::Status RewriteProgram(
      grpc::ServerContext* context,
      grpc::ServerReaderWriter<v1::RewriteProgramResponse, v1::RewriteProgramRequest>* stream) override {
    return RespondStream(core_, context, "Programs.RewriteProgram", nullptr, [&](const auto& call) -> absl::Status {
      handlers::HeldCall held(core_.held, core_.limits.held, handlers::HeldKind::kRewrite, call.cut_off,
                              call.counted_as);
      handlers::RewriteProgramStream program(
          core_, call, [&](const auto& message) { return held.Await([&] { return stream->Write(message); }); });
      RETURN_IF_ERROR(ReceiveAll<v1::RewriteProgramRequest>(held, call, *stream, program));
      return program.End();
    });
  }

 private:
  handlers::Core& core_;
};

}  // namespace

std::unique_ptr<grpc::Service> MakeIngestService(handlers::Core& core) { return std::make_unique<IngestService>(core); }

std::unique_ptr<grpc::Service> MakeProgramsService(handlers::Core& core) {
  return std::make_unique<ProgramsService>(core);
}

}  // namespace axiscal::server
