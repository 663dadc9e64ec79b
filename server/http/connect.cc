#include "server/http/connect.h"

#include "absl/strings/ascii.h"
#include "core/base/error_detail.h"
#include "server/handlers/get_server_info.h"
#include "server/http/errors.h"
#include "server/http/forward.h"
#include "server/http/messages.h"

namespace axiscal::http {
namespace {

// Of JSON against the binary form: a double of 8 bytes may take 25 characters.
constexpr int kJsonFactor = 4;
constexpr int kEnvelopeBytes = 5;

absl::Status Unimplemented(const std::string& text, const std::string& reason) {
  return base::Error(absl::StatusCode::kUnimplemented, text, {reason, {}});
}

// What holds for every call, before its message is looked at.
absl::Status CheckHead(const google::protobuf::MethodDescriptor& method, const Request& request) {
  if (method.client_streaming()) {
    return Unimplemented(
        method.full_name() + " takes a stream, which HTTP does not carry: docs/http.md says what to POST",
        "STREAM_NOT_CARRIED");
  }
  const std::string version = request.Field("connect-protocol-version");
  if (!version.empty() && version != "1") {
    return base::Error(absl::StatusCode::kInvalidArgument, "Connect-Protocol-Version is '" + version + "', must be 1",
                       {"FIELD_INVALID", {{"field", "Connect-Protocol-Version"}, {"rule", "must be 1"}}});
  }
  const char* const coding = method.server_streaming() ? "connect-content-encoding" : "content-encoding";
  const std::string name = absl::AsciiStrToLower(request.Field(coding));
  if (!name.empty() && name != "identity" && !request.body.empty()) {
    return Unimplemented("the body is compressed by '" + name + "', must be by nothing (identity)", "CODING_UNKNOWN");
  }
  if (request.is_too_large) {
    return base::Error(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("a body of more than ", MostBodyBytes(request), " bytes"),
                       {"MESSAGE_TOO_LARGE", {}});
  }
  return absl::OkStatus();
}

class Service {
 public:
  Service(handlers::Core& core, const std::shared_ptr<grpc::Channel>& channel,
          const google::protobuf::MethodDescriptor& method, const ContentType& type, const Request& request,
          const absl::StatusOr<access::Credentials>& credentials, handlers::Budget& budget, Exchange& exchange)
      : core_(core),
        channel_(channel),
        method_(method),
        type_(type),
        request_(request),
        credentials_(credentials),
        budget_(budget),
        exchange_(exchange) {}

  void Unary() {
    std::string reply;
    absl::StatusOr<google::rpc::Status> ended = Run([&](std::string part) {
      reply = std::move(part);
      return true;
    });
    handlers::Share share(budget_, request_.counted_as);
    absl::StatusOr<std::string> body = ToBody(std::move(reply), share);
    if (!ended.ok()) {
      exchange_.Send(ErrorAnswer(ended.status()));
    } else if (ended->code() != 0) {
      exchange_.Send(ErrorAnswer(*ended));
    } else if (!body.ok()) {
      exchange_.Send(ErrorAnswer(body.status()));
    } else {
      exchange_.Send({200, {{"Content-Type", NameOf(type_)}}, *std::move(body)});
    }
  }

  // The head goes out before the first message is there: the caller sees that it was heard.
  void Stream() {
    // Proxies are asked to hand each message on as it comes.
    if (!exchange_.Begin(200, {{"Content-Type", NameOf(type_)}, {"X-Accel-Buffering", "no"}}, std::nullopt)) return;
    absl::Status written;
    absl::StatusOr<google::rpc::Status> ended = Run([&](std::string part) {
      handlers::Share share(budget_, request_.counted_as);
      absl::StatusOr<std::string> message = ToBody(std::move(part), share);
      if (!message.ok()) written = message.status();
      return message.ok() && exchange_.Write(Envelope(0, *message));
    });
    if (ended.ok() && !written.ok()) ended = written;
    const google::rpc::Status error = ended.ok() ? *ended : ErrorOf(ended.status());
    if (exchange_.Write(Envelope(kEndOfStream, EndOfStreamJson(error.code() == 0 ? nullptr : &error)))) exchange_.End();
  }

 private:
  // How the call ended; an error where it did not begin.
  absl::StatusOr<google::rpc::Status> Run(const std::function<bool(std::string)>& take) {
    RETURN_IF_ERROR(credentials_.status());
    RETURN_IF_ERROR(CheckHead(method_, request_));
    std::string unpacked;
    if (type_.is_stream) {
      ASSIGN_OR_RETURN(unpacked, OnlyMessage(request_.body));
    }
    const std::string& text = type_.is_stream ? unpacked : request_.body;
    const google::protobuf::Descriptor& type = *method_.input_type();
    handlers::Share share(budget_, request_.counted_as);
    RETURN_IF_ERROR(share.Take(BytesToRead(type, type_.codec, text)));
    ASSIGN_OR_RETURN(const std::string message, ToBinary(type, type_.codec, text, handlers::kMaxMessageBytes));
    ASSIGN_OR_RETURN(const std::unique_ptr<ForwardedCall> call,
                     ForwardedCall::Begin(core_, request_, *credentials_, exchange_));
    const grpc::Status status = call->Run(channel_, request_.path, message, take);
    return status.ok() ? google::rpc::Status() : ErrorOf(status);
  }

  // An answer as it is written; what that takes is `share`'s until the caller has it.
  absl::StatusOr<std::string> ToBody(std::string binary, handlers::Share& share) const {
    RETURN_IF_ERROR(share.Take(BytesToWrite(type_.codec, binary)));
    return FromBinary(*method_.output_type(), type_.codec, std::move(binary));
  }

  handlers::Core& core_;
  const std::shared_ptr<grpc::Channel>& channel_;
  const google::protobuf::MethodDescriptor& method_;
  const ContentType type_;
  const Request& request_;
  const absl::StatusOr<access::Credentials>& credentials_;
  handlers::Budget& budget_;
  Exchange& exchange_;
};

}  // namespace

int64_t MostBodyBytes(const Request& request) {
  const std::optional<ContentType> type = ContentTypeOf(request.Field("content-type"));
  const bool is_json = type && type->codec == Codec::kJson;
  return int64_t{handlers::kMaxMessageBytes} * (is_json ? kJsonFactor : 1) + kEnvelopeBytes;
}

void ServeConnect(handlers::Core& core, const std::shared_ptr<grpc::Channel>& channel,
                  const google::protobuf::MethodDescriptor& method, const Request& request,
                  const absl::StatusOr<access::Credentials>& credentials, handlers::Budget& budget,
                  Exchange& exchange) {
  if (request.method != "POST") {
    exchange.Send({405, {{"Allow", "POST"}}, ""});
    return;
  }
  const std::optional<ContentType> type = ContentTypeOf(request.Field("content-type"));
  const bool is_stream = method.server_streaming() || method.client_streaming();
  if (!type || type->is_stream != is_stream) {
    exchange.Send({415,
                   {{"Accept-Post", is_stream ? "application/connect+json, application/connect+proto"
                                              : "application/json, application/proto"}},
                   ""});
    return;
  }
  Service service(core, channel, method, *type, request, credentials, budget, exchange);
  if (is_stream) {
    service.Stream();
  } else {
    service.Unary();
  }
}

}  // namespace axiscal::http
