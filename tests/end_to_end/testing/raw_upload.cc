#include "tests/end_to_end/testing/raw_upload.h"

#include <grpcpp/generic/generic_stub.h>

#include <thread>

#include "core/records/chunked_session.h"
#include "google/rpc/error_details.pb.h"
#include "google/rpc/status.pb.h"
#include "proto/convert/session.h"

namespace axiscal::testing {
namespace {

template <typename Detail>
bool FindDetail(const grpc::Status& status, Detail* detail) {
  google::rpc::Status details;
  if (!details.ParseFromString(status.error_details())) return false;
  for (const auto& any : details.details()) {
    if (any.UnpackTo(detail)) return true;
  }
  return false;
}

}  // namespace

v1::CreateSessionRequest CreateRequest(const std::string& machine, const std::string& request_id,
                                       const session::Session& session) {
  v1::CreateSessionRequest request;
  request.set_machine_id(machine);
  request.set_request_id(request_id);
  *request.mutable_schema() = convert::ToProto(records::SchemaOf(session));
  return request;
}

std::vector<v1::UploadRequest> UploadMessages(int64_t session_id, const session::Session& session, int chunk_readings) {
  records::ChunkedSession chunks(session, chunk_readings);
  std::vector<v1::UploadRequest> messages(1);
  messages[0].mutable_header()->set_session_id(session_id);
  for (int64_t seq = 0; seq < chunks.chunk_count(); ++seq) {
    *messages.emplace_back().mutable_chunk() = convert::ToProto(chunks.At(seq));
  }
  *messages.emplace_back().mutable_finish()->mutable_totals() = convert::ToProto(chunks.Totals());
  return messages;
}

RawResult SendAll(v1::Ingest::Stub& stub, const std::vector<v1::UploadRequest>& messages) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
  const auto stream = stub.Upload(&context);
  RawResult result;
  std::thread reader([&] {
    v1::UploadResponse response;
    while (stream->Read(&response)) result.responses.push_back(response);
  });
  for (const v1::UploadRequest& message : messages) {
    if (!stream->Write(message)) break;
  }
  stream->WritesDone();
  reader.join();
  result.status = stream->Finish();
  return result;
}

grpc::Status SendBytes(const std::shared_ptr<grpc::Channel>& channel, const std::string& method,
                       const std::vector<std::string>& messages, const std::string& authorization,
                       bool leaves_with_first_answer) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  if (!authorization.empty()) context.AddMetadata("authorization", authorization);
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::seconds(30));
  grpc::CompletionQueue queue;
  void* tag = nullptr;
  bool ok = false;
  const auto call = stub.PrepareCall(&context, method, &queue);
  call->StartCall(nullptr);
  queue.Next(&tag, &ok);
  for (const std::string& message : messages) {
    grpc::Slice slice(message);
    call->Write(grpc::ByteBuffer(&slice, 1), nullptr);
    queue.Next(&tag, &ok);
    if (!ok) break;
  }
  call->WritesDone(nullptr);
  queue.Next(&tag, &ok);
  do {
    grpc::ByteBuffer answer;
    call->Read(&answer, nullptr);
    queue.Next(&tag, &ok);
    if (ok && leaves_with_first_answer) context.TryCancel();
  } while (ok);
  grpc::Status status;
  call->Finish(&status, nullptr);
  queue.Next(&tag, &ok);
  queue.Shutdown();
  while (queue.Next(&tag, &ok)) {
  }
  return status;
}

std::string ReasonOf(const grpc::Status& status) {
  google::rpc::ErrorInfo info;
  return FindDetail(status, &info) && info.domain() == "axiscal" ? info.reason() : "";
}

std::string FieldOf(const grpc::Status& status) {
  google::rpc::BadRequest bad_request;
  return FindDetail(status, &bad_request) && bad_request.field_violations_size() > 0
             ? bad_request.field_violations(0).field()
             : "";
}

bool HasRetryInfo(const grpc::Status& status) {
  google::rpc::RetryInfo retry;
  return FindDetail(status, &retry) && retry.retry_delay().seconds() > 0;
}

}  // namespace axiscal::testing
