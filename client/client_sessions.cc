// Sessions and programs of the client.
#include "client/client_impl.h"
#include "client/transfer.h"
#include "client/upload.h"
#include "core/base/sha256.h"
#include "proto/convert/time.h"

namespace axiscal::client {
namespace {

ReadAt PartsOf(const std::string& bytes) {
  return [&bytes](int64_t offset, int64_t size) -> absl::StatusOr<std::string> {
    return bytes.substr(static_cast<size_t>(offset), static_cast<size_t>(size));
  };
}

}  // namespace

absl::StatusOr<UploadResult> Client::Upload(const MachineId& machine, const session::Session& session,
                                            const ProgressCallback& progress) {
  return UploadSession(impl_->connection, machine, session, progress);
}

absl::StatusOr<SessionRecord> Client::GetSession(SessionId id) {
  v1::GetSessionRequest request;
  request.set_session_id(id.number());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::GetSessionResponse>(*impl_->ingest, &v1::Ingest::Stub::GetSession, request));
  ASSIGN_OR_RETURN(SessionRecord record, convert::FromProto(response.session()));
  ASSIGN_OR_RETURN(records::SessionSchema schema, convert::FromProto(response.schema()));
  record.header = std::move(schema.header);
  record.columns = std::move(schema.columns);
  return record;
}

absl::StatusOr<Page<SessionRecord>> Client::ListSessions(const SessionFilter& filter, const PageRequest& page) {
  auto request = PageOf<v1::ListSessionsRequest>(page);
  if (filter.machine) request.set_machine_id(filter.machine->text());
  if (filter.state) request.set_state(convert::ToProto(*filter.state));
  SET_OPTIONAL_UTC(request, from_utc_us, filter.measured.from);
  SET_OPTIONAL_UTC(request, to_utc_us, filter.measured.to);
  request.set_instrument(filter.instrument);
  request.set_name(filter.name);
  request.set_label(filter.label);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListSessionsResponse>(*impl_->ingest, &v1::Ingest::Stub::ListSessions, request));
  return ReadPage<SessionRecord>(response.sessions(), response.next_page_token());
}

absl::StatusOr<SessionRecord> Client::AnnotateSession(SessionId id, const std::string& note,
                                                      const std::vector<std::string>& labels, int64_t etag) {
  v1::AnnotateSessionRequest request;
  request.set_session_id(id.number());
  request.set_note(note);
  for (const std::string& label : labels) request.add_labels(label);
  request.set_etag(etag);
  ASSIGN_OR_RETURN(const auto response, impl_->Call<v1::AnnotateSessionResponse>(
                                            *impl_->ingest, &v1::Ingest::Stub::AnnotateSession, request));
  return convert::FromProto(response.session());
}

absl::StatusOr<Client::RejectedSession> Client::RejectSession(SessionId id, bool is_rejected,
                                                              const std::string& reason) {
  v1::RejectSessionRequest request;
  request.set_session_id(id.number());
  request.set_is_rejected(is_rejected);
  request.set_reason(reason);
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::RejectSessionResponse>(*impl_->ingest, &v1::Ingest::Stub::RejectSession, request));
  RejectedSession rejected;
  ASSIGN_OR_RETURN(rejected.session, convert::FromProto(response.session()));
  for (const int64_t number : response.calibration_ids()) rejected.calibrations.push_back(CalibrationId(number));
  return rejected;
}

absl::StatusOr<SessionRecord> Client::AbortSession(SessionId id) {
  v1::AbortSessionRequest request;
  request.set_session_id(id.number());
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::AbortSessionResponse>(*impl_->ingest, &v1::Ingest::Stub::AbortSession, request));
  return convert::FromProto(response.session());
}

absl::StatusOr<records::StoredLog> Client::PutLog(const MachineId& machine, const std::string& name,
                                                  const std::string& bytes, const records::LogForm& form) {
  return client::PutLog(impl_->connection, machine, name, bytes, form);
}

absl::StatusOr<session::Session> Client::DownloadSession(SessionId id) {
  return client::DownloadSession(impl_->connection, id);
}

absl::StatusOr<ProgramRecord> Client::PutProgram(const std::string& name, const std::string& bytes,
                                                 const ProgressCallback& progress) {
  const ProgramSource source{name, static_cast<int64_t>(bytes.size()), base::Sha256Hex(bytes), PartsOf(bytes)};
  return client::PutProgram(impl_->connection, source, progress);
}

absl::StatusOr<std::string> Client::RewriteProgram(const records::CompensateParams& params, const std::string& bytes,
                                                   const TakeBytes& take) {
  const ProgramSource source{"the program", static_cast<int64_t>(bytes.size()), "", PartsOf(bytes)};
  return client::RewriteProgram(impl_->connection, params, source, take);
}

absl::StatusOr<std::string> Client::RewriteProgramFile(const records::CompensateParams& params, const std::string& path,
                                                       const TakeBytes& take) {
  ASSIGN_OR_RETURN(const ProgramSource source, FileSource(path));
  return client::RewriteProgram(impl_->connection, params, source, take);
}

absl::StatusOr<ProgramRecord> Client::PutProgramFile(const std::string& path, const ProgressCallback& progress) {
  ASSIGN_OR_RETURN(const ProgramSource source, FileSource(path));
  return client::PutProgram(impl_->connection, source, progress);
}

absl::StatusOr<std::string> Client::GetProgram(ProgramId id, const ProgressCallback& progress) {
  std::string bytes;
  const TakeBytes take = [&](const std::string& part) {
    bytes += part;
    return absl::OkStatus();
  };
  RETURN_IF_ERROR(client::GetProgram(impl_->connection, id, take, progress).status());
  return bytes;
}

absl::StatusOr<ProgramRecord> Client::GetProgram(ProgramId id,
                                                 const std::function<absl::Status(const std::string& bytes)>& take,
                                                 const ProgressCallback& progress) {
  return client::GetProgram(impl_->connection, id, take, progress);
}

absl::StatusOr<Page<ProgramRecord>> Client::ListPrograms(const PageRequest& page) {
  ASSIGN_OR_RETURN(const auto response,
                   impl_->Call<v1::ListProgramsResponse>(*impl_->programs, &v1::Programs::Stub::ListPrograms,
                                                         PageOf<v1::ListProgramsRequest>(page)));
  return ReadPage<ProgramRecord>(response.programs(), response.next_page_token());
}

}  // namespace axiscal::client
