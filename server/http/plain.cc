#include "server/http/plain.h"

#include <google/protobuf/util/json_util.h>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "axiscal/v1/admin_service.grpc.pb.h"
#include "axiscal/v1/ingest_service.grpc.pb.h"
#include "axiscal/v1/programs_service.grpc.pb.h"
#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "core/base/sha256.h"
#include "core/records/chunked_session.h"
#include "core/records/log.h"
#include "core/session/read_session.h"
#include "core/session/write_session.h"
#include "proto/convert/field.h"
#include "proto/convert/log.h"
#include "proto/convert/program.h"
#include "proto/convert/session.h"
#include "proto/convert/status.h"
#include "server/http/errors.h"
#include "server/http/forward.h"
#include "server/http/multipart.h"

namespace axiscal::http {
namespace {

// What a reading's cell takes at most while a session becomes a file: the double, and its decimal twice.
constexpr int64_t kBytesOfCell = 56;

absl::StatusOr<std::unique_ptr<ForwardedCall>> Begin(const PlainCall& call) {
  return ForwardedCall::Begin(call.core, call.request, call.credentials, call.exchange);
}

void Refuse(const PlainCall& call, const absl::Status& status) { call.exchange.Send(ErrorAnswer(status)); }

// The error that gRPC gives, which ended the call.
absl::Status StatusOf(const grpc::Status& status) {
  return status.ok() ? absl::OkStatus() : convert::FromProto(ErrorOf(status));
}

// Of the field Idempotency-Key, which may stand in quotes; `otherwise` where it is missing.
std::string RequestId(const Request& request, const std::string& otherwise) {
  std::string key = request.Field("idempotency-key");
  if (key.size() >= 2 && key.front() == '"' && key.back() == '"') key = key.substr(1, key.size() - 2);
  return key.empty() ? otherwise : key;
}

Answer Created(bool is_new, const std::string& location, const google::protobuf::Message& message) {
  std::string json;
  DEMAND(google::protobuf::util::MessageToJsonString(message, &json).ok());
  return {is_new ? 201 : 200, {{"Content-Type", "application/json"}, {"Location", location}}, json};
}

// Whether the caller has what has this checksum.
bool Has(const Request& request, const std::string& etag) {
  for (const std::string& word : Words(request.Field("if-none-match"), ',')) {
    if (word == etag || word == "W/" + etag || word == "*") return true;
  }
  return false;
}

// ---- sessions

absl::StatusOr<v1::CreateSessionResponse> CreateSession(const PlainCall& call, v1::Ingest::Stub& stub,
                                                        const v1::CreateSessionRequest& request) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  v1::CreateSessionResponse created;
  RETURN_IF_ERROR(StatusOf(stub.CreateSession(&forwarded->context(), request, &created)));
  return created;
}

// Sends the chunks that are missing.
absl::StatusOr<v1::Session> Upload(const PlainCall& call, v1::Ingest::Stub& stub, const v1::Session& open,
                                   records::ChunkedSession& chunks) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  v1::UploadOnceResponse stored;
  const auto writer = stub.UploadOnce(&forwarded->context(), &stored);
  v1::UploadRequest message;
  message.mutable_header()->set_session_id(open.session_id());
  message.mutable_header()->set_resume_from_seq(open.next_seq());
  bool is_open = writer->Write(message);
  for (int64_t seq = open.next_seq(); is_open && seq < chunks.chunk_count(); ++seq) {
    *message.mutable_chunk() = convert::ToProto(chunks.At(seq));
    is_open = writer->Write(message);
  }
  if (is_open) {
    *message.mutable_finish()->mutable_totals() = convert::ToProto(chunks.Totals());
    writer->Write(message);
  }
  writer->WritesDone();
  RETURN_IF_ERROR(StatusOf(writer->Finish()));
  return stored.session();
}

absl::StatusOr<Answer> StoreSession(const PlainCall& call, const std::string& machine) {
  const absl::StatusOr<session::Session> session = session::ReadSessionText(call.request.body, "session file");
  if (!session.ok()) {
    return base::Error(absl::StatusCode::kInvalidArgument, std::string(session.status().message()),
                       {"SESSION_INVALID", {}});
  }
  // As the client library does: the same file is the same session, whoever sends it.
  const int chunk_readings = records::kUsualChunkReadings;
  v1::CreateSessionRequest request;
  request.set_machine_id(machine);
  request.set_request_id(RequestId(call.request, records::ContentId(MachineId(machine), *session, chunk_readings)));
  *request.mutable_schema() = convert::ToProto(records::SchemaOf(*session));
  const auto stub = v1::Ingest::NewStub(call.channel);
  ASSIGN_OR_RETURN(const v1::CreateSessionResponse created, CreateSession(call, *stub, request));
  v1::Session stored = created.session();
  const bool is_new = stored.state() == v1::SESSION_STATE_OPEN;
  if (is_new) {
    records::ChunkedSession chunks(*session, chunk_readings);
    ASSIGN_OR_RETURN(stored, Upload(call, *stub, created.session(), chunks));
  }
  return Created(is_new, absl::StrCat("/v1/sessions/", stored.session_id()), stored);
}

absl::StatusOr<v1::Session> FindSession(const PlainCall& call, v1::Ingest::Stub& stub, int64_t id) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  v1::GetSessionRequest request;
  request.set_session_id(id);
  v1::GetSessionResponse found;
  RETURN_IF_ERROR(StatusOf(stub.GetSession(&forwarded->context(), request, &found)));
  return found.session();
}

absl::StatusOr<session::Session> Download(const PlainCall& call, v1::Ingest::Stub& stub, int64_t id,
                                          handlers::Share& share) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  v1::DownloadSessionRequest request;
  request.set_session_id(id);
  const auto reader = stub.DownloadSession(&forwarded->context(), request);
  session::Session session;
  records::SessionSchema schema;
  absl::Status taken;
  const auto take = [&](const v1::DownloadSessionResponse& message) -> absl::Status {
    if (message.has_schema()) {
      ASSIGN_OR_RETURN(schema, convert::FromProto(message.schema()));
      session.header = schema.header;
      for (const records::ColumnSpec& column : schema.columns) session.columns.push_back({column.name, {}, {}});
    } else if (message.has_chunk()) {
      ASSIGN_OR_RETURN(const records::Chunk chunk, convert::FromProto(message.chunk(), schema.columns));
      RETURN_IF_ERROR(share.Take(kBytesOfCell * chunk.reading_count() * static_cast<int64_t>(schema.columns.size())));
      for (size_t i = 0; i < chunk.columns().size(); ++i) {
        const session::Column& from = chunk.columns()[i];
        session::Column& to = session.columns[i];
        to.values.insert(to.values.end(), from.values.begin(), from.values.end());
        to.texts.insert(to.texts.end(), from.texts.begin(), from.texts.end());
      }
    }
    return absl::OkStatus();
  };
  v1::DownloadSessionResponse message;
  while (taken.ok() && reader->Read(&message)) taken = take(message);
  if (!taken.ok()) forwarded->context().TryCancel();
  const absl::Status ended = StatusOf(reader->Finish());
  RETURN_IF_ERROR(taken);
  RETURN_IF_ERROR(ended);
  return session;
}

absl::StatusOr<Answer> LoadSession(const PlainCall& call, int64_t id) {
  const auto stub = v1::Ingest::NewStub(call.channel);
  ASSIGN_OR_RETURN(const v1::Session found, FindSession(call, *stub, id));
  const std::string etag = "\"" + found.sha256() + "\"";
  if (!found.sha256().empty() && Has(call.request, etag)) return Answer{304, {{"ETag", etag}}, ""};
  handlers::Share share(call.budget, call.request.counted_as);
  ASSIGN_OR_RETURN(const session::Session session, Download(call, *stub, id, share));
  ASSIGN_OR_RETURN(std::string text, session::WriteSession(session));
  return Answer{200,
                {{"Content-Type", "text/csv; charset=utf-8"}, {"ETag", etag}, {"Cache-Control", "private, no-cache"}},
                std::move(text)};
}

// ---- logs

// The parts of a form, by name.
absl::StatusOr<std::map<std::string, FormPart>> ReadForm(const PlainCall& call) {
  absl::StatusOr<std::map<std::string, FormPart>> form =
      ReadMultipart(call.request.Field("content-type"), call.request.body);
  if (!form.ok()) return form.status();
  const auto refuse = [](const std::string& text) {
    return base::Error(absl::StatusCode::kInvalidArgument, text, {"MESSAGE_INVALID", {}});
  };
  for (const auto& [name, part] : *form) {
    if (name != "log" && name != "template" && name != "plan" && name != "session" && name != "start_s")
      return refuse("a field '" + name + "', expected log, template, plan, session, start_s");
  }
  for (const char* const name : {"log", "template"}) {
    if (form->count(name) == 0) return refuse(std::string("no field '") + name + "', expected log and template");
  }
  return form;
}

absl::StatusOr<Answer> StoreLog(const PlainCall& call, const std::string& machine) {
  handlers::Share share(call.budget, call.request.counted_as);
  RETURN_IF_ERROR(share.Take(static_cast<int64_t>(call.request.body.size())));  // the parts are copies
  ASSIGN_OR_RETURN(auto form, ReadForm(call));
  const FormPart& log = form["log"];
  records::LogForm how{form["template"].text, form["template"].file, form["plan"].text,
                       form["plan"].file,     form["session"].text,  std::nullopt};
  if (form.count("start_s") > 0) {
    double start_s = 0;
    if (!absl::SimpleAtod(form["start_s"].text, &start_s))
      return convert::FieldError("start_s", "'" + form["start_s"].text + "', must be a number");
    how.start_s = start_s;
  }
  v1::PutLogRequest message;
  v1::PutLogHeader& header = *message.mutable_header();
  header.set_machine_id(machine);
  header.set_name(log.file.empty() ? "log" : log.file);
  header.set_size_bytes(static_cast<int64_t>(log.text.size()));
  header.set_sha256(base::Sha256Hex(log.text));
  header.set_request_id(RequestId(call.request, records::LogId(machine, header.name(), how, header.sha256())));
  *header.mutable_form() = convert::ToProto(how);
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  const auto stub = v1::Ingest::NewStub(call.channel);
  v1::PutLogResponse stored;
  const auto writer = stub->PutLog(&forwarded->context(), &stored);
  bool is_open = writer->Write(message);
  for (size_t at = 0; is_open && at < log.text.size(); at += convert::kMaxProgramPartBytes) {
    message.set_data(log.text.substr(at, convert::kMaxProgramPartBytes));
    is_open = writer->Write(message);
  }
  writer->WritesDone();
  RETURN_IF_ERROR(StatusOf(writer->Finish()));
  return Created(!stored.was_there(), absl::StrCat("/v1/sessions/", stored.session().session_id()), stored);
}

// ---- metrics

absl::StatusOr<Answer> LoadMetrics(const PlainCall& call) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  v1::GetMetricsResponse metrics;
  const auto stub = v1::Admin::NewStub(call.channel);
  RETURN_IF_ERROR(StatusOf(stub->GetMetrics(&forwarded->context(), {}, &metrics)));
  return Answer{200,
                {{"Content-Type", "text/plain; version=0.0.4; charset=utf-8"}, {"Cache-Control", "no-store"}},
                std::move(*metrics.mutable_text())};
}

// ---- programs

absl::StatusOr<Answer> StoreProgram(const PlainCall& call, const std::string& name) {
  const std::string& bytes = call.request.body;
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  const auto stub = v1::Programs::NewStub(call.channel);
  v1::PutProgramResponse stored;
  const auto writer = stub->PutProgram(&forwarded->context(), &stored);
  v1::PutProgramRequest message;
  v1::PutProgramHeader& header = *message.mutable_header();
  header.set_name(name);
  header.set_size_bytes(static_cast<int64_t>(bytes.size()));
  header.set_sha256(base::Sha256Hex(bytes));
  header.set_request_id(
      RequestId(call.request, base::Sha256Hex(absl::StrCat(name.size(), ":", name, header.sha256()))));
  bool is_open = writer->Write(message);
  for (size_t at = 0; is_open && at < bytes.size(); at += convert::kMaxProgramPartBytes) {
    message.set_data(bytes.substr(at, convert::kMaxProgramPartBytes));
    is_open = writer->Write(message);
  }
  writer->WritesDone();
  RETURN_IF_ERROR(StatusOf(writer->Finish()));
  return Created(true, absl::StrCat("/v1/programs/", stored.program().program_id()), stored.program());
}

// The first byte that "Range: bytes=N-" asks for; nothing of other ranges, which may be left unanswered.
std::optional<int64_t> FirstByte(const Request& request) {
  constexpr char kStart[] = "bytes=";
  const std::string range = request.Field("range");
  if (range.rfind(kStart, 0) != 0 || range.back() != '-') return std::nullopt;
  const std::string digits = range.substr(sizeof(kStart) - 1, range.size() - sizeof(kStart));
  int64_t first = 0;
  const bool is_number = !digits.empty() && digits.find_first_not_of("0123456789") == std::string::npos;
  return is_number && absl::SimpleAtoi(digits, &first) ? std::optional(first) : std::nullopt;
}

// A name as RFC 8187 writes it.
std::string Disposition(const std::string& name) {
  std::string text = "attachment; filename*=UTF-8''";
  for (const char c : name) {
    if (absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' || c == '_' || c == '-') {
      text += c;
    } else {
      absl::StrAppendFormat(&text, "%%%02X", static_cast<unsigned char>(c));
    }
  }
  return text;
}

// From a byte on. Nothing was answered yet when it returns an error or the program's true checksum differs from what
// If-Range names, which is told by `*is_other`.
absl::Status SendProgram(const PlainCall& call, int64_t id, int64_t first, bool is_range, bool* is_other) {
  ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> forwarded, Begin(call));
  const auto stub = v1::Programs::NewStub(call.channel);
  v1::GetProgramRequest request;
  request.set_program_id(id);
  request.set_offset_bytes(first);
  const auto reader = stub->GetProgram(&forwarded->context(), request);
  v1::GetProgramResponse message;
  if (!reader->Read(&message)) return StatusOf(reader->Finish());
  const v1::Program program = message.program();
  const std::string etag = "\"" + program.sha256() + "\"";
  const std::string if_range = call.request.Field("if-range");
  *is_other = is_range && !if_range.empty() && if_range != etag;
  const bool is_over = is_range && first >= program.size_bytes();
  if (*is_other || is_over || Has(call.request, etag)) {
    forwarded->context().TryCancel();
    static_cast<void>(reader->Finish());
    if (*is_other) return absl::OkStatus();
    call.exchange.Send(is_over ? Answer{416, {{"Content-Range", absl::StrCat("bytes */", program.size_bytes())}}, ""}
                               : Answer{304, {{"ETag", etag}}, ""});
    return absl::OkStatus();
  }
  Fields fields = {{"Content-Type", "application/octet-stream"},
                   {"ETag", etag},
                   {"Cache-Control", "private, no-cache"},
                   {"Accept-Ranges", "bytes"},
                   {"Content-Disposition", Disposition(program.name())}};
  if (is_range) {
    fields.emplace_back("Content-Range",
                        absl::StrCat("bytes ", first, "-", program.size_bytes() - 1, "/", program.size_bytes()));
  }
  bool is_there = call.exchange.Begin(is_range ? 206 : 200, fields, program.size_bytes() - first);
  while (is_there && reader->Read(&message)) is_there = call.exchange.Write(std::move(*message.mutable_data()));
  if (!is_there) forwarded->context().TryCancel();
  // Without its end the answer is cut off, which the caller sees by its length.
  if (reader->Finish().ok() && is_there) call.exchange.End();
  return absl::OkStatus();
}

}  // namespace

void PutSession(const PlainCall& call, const std::string& machine) {
  absl::StatusOr<Answer> answer = StoreSession(call, machine);
  call.exchange.Send(answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status()));
}

void PutLog(const PlainCall& call, const std::string& machine) {
  absl::StatusOr<Answer> answer = StoreLog(call, machine);
  call.exchange.Send(answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status()));
}

void GetSession(const PlainCall& call, int64_t id) {
  absl::StatusOr<Answer> answer = LoadSession(call, id);
  call.exchange.Send(answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status()));
}

void PutProgram(const PlainCall& call, const std::string& name) {
  absl::StatusOr<Answer> answer = StoreProgram(call, name);
  call.exchange.Send(answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status()));
}

void GetProgram(const PlainCall& call, int64_t id) {
  const std::optional<int64_t> first = FirstByte(call.request);
  bool is_other = false;
  absl::Status status = SendProgram(call, id, first.value_or(0), first.has_value(), &is_other);
  if (status.ok() && is_other) status = SendProgram(call, id, 0, false, &is_other);
  if (!status.ok()) Refuse(call, status);
}

void GetMetrics(const PlainCall& call) {
  absl::StatusOr<Answer> answer = LoadMetrics(call);
  call.exchange.Send(answer.ok() ? *std::move(answer) : ErrorAnswer(answer.status()));
}

}  // namespace axiscal::http
