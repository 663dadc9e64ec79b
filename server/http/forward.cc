#include "server/http/forward.h"

#include <grpcpp/generic/generic_stub.h>

#include <algorithm>

#include "absl/strings/numbers.h"
#include "proto/convert/field.h"

namespace axiscal::http {
namespace {

constexpr char kUserKey[] = "axiscal-user";
constexpr size_t kMaxTimeoutDigits = 10;

std::string TextOf(const grpc::ByteBuffer& buffer) {
  std::vector<grpc::Slice> slices;
  std::string text;
  if (!buffer.Dump(&slices).ok()) return text;
  for (const grpc::Slice& slice : slices) text.append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  return text;
}

absl::Status SetDeadline(const Request& request, grpc::ClientContext& context) {
  const std::string text = request.Field("connect-timeout-ms");
  if (request.fields.count("connect-timeout-ms") == 0) return absl::OkStatus();
  int64_t ms = 0;
  const bool is_number = text.find_first_not_of("0123456789") == std::string::npos && absl::SimpleAtoi(text, &ms);
  if (!is_number || text.size() > kMaxTimeoutDigits)
    return convert::FieldError("Connect-Timeout-Ms", "must be a number of 1 to 10 digits, milliseconds");
  context.set_deadline(std::chrono::system_clock::now() + std::chrono::milliseconds(ms));
  return absl::OkStatus();
}

// gRPC ends the process for metadata of other bytes.
absl::Status AddUser(const Request& request, grpc::ClientContext& context) {
  const auto user = request.fields.find(kUserKey);
  if (user == request.fields.end()) return absl::OkStatus();
  const bool is_plain =
      std::all_of(user->second.begin(), user->second.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (!is_plain) return convert::FieldError(kUserKey, "must be printable ASCII characters");
  context.AddMetadata(kUserKey, user->second);
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<ForwardedCall>> ForwardedCall::Begin(handlers::Core& core, const Request& request,
                                                                    const access::Credentials& credentials,
                                                                    Exchange& exchange) {
  std::unique_ptr<ForwardedCall> call(new ForwardedCall(core, {credentials, request.peer.address}, exchange));
  RETURN_IF_ERROR(SetDeadline(request, call->context_));
  RETURN_IF_ERROR(AddUser(request, call->context_));
  if (const std::string trace = request.Field(handlers::kTraceKey); handlers::IsTraceParent(trace))
    call->context_.AddMetadata(handlers::kTraceKey, trace);
  call->context_.AddMetadata(access::kTicketKey, call->place_.ticket());
  exchange.OnLeave([context = &call->context_] { context->TryCancel(); });
  return call;
}

ForwardedCall::~ForwardedCall() { exchange_.OnLeave(nullptr); }

grpc::Status ForwardedCall::Run(const std::shared_ptr<grpc::Channel>& channel, const std::string& path,
                                const std::string& message, const std::function<bool(std::string)>& take) {
  grpc::GenericStub stub(channel);
  grpc::CompletionQueue queue;
  void* const tag = this;
  // Each step ends before the next begins.
  const auto is_done = [&] {
    void* ended = nullptr;
    bool is_good = false;
    return queue.Next(&ended, &is_good) && is_good;
  };
  const std::unique_ptr<grpc::GenericClientAsyncReaderWriter> call = stub.PrepareCall(&context_, path, &queue);
  call->StartCall(tag);
  if (is_done()) {
    const grpc::Slice slice(message);
    call->WriteLast(grpc::ByteBuffer(&slice, 1), {}, tag);
    is_done();
    grpc::ByteBuffer part;
    for (call->Read(&part, tag); is_done(); call->Read(&part, tag)) {
      if (!take(TextOf(part))) context_.TryCancel();
    }
  }
  grpc::Status status;
  call->Finish(&status, tag);
  is_done();
  queue.Shutdown();
  is_done();
  return status;
}

}  // namespace axiscal::http
