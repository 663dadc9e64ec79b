#include "server/respond.h"

#include <grpcpp/security/auth_context.h>

#include <exception>
#include <optional>

#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "core/base/mutex.h"
#include "proto/convert/field.h"
#include "proto/convert/status.h"
#include "server/access/named.h"
#include "server/call_guard.h"
#include "server/call_heads.h"
#include "server/log.h"

namespace axiscal::server {
namespace {

// The metadata key with which clients say for the log who they are. Nothing trusts it.
constexpr char kUserKey[] = "axiscal-user";
constexpr size_t kMaxUserBytes = 200;

std::optional<std::string> Metadata(const grpc::ServerContext& context, const std::string& key) {
  const auto found = context.client_metadata().find(key);
  if (found == context.client_metadata().end()) return std::nullopt;
  return std::string(found->second.data(), found->second.size());
}

// What a caller says in the metadata is written to the log: it is held to the rules of a text field, which Protobuf
// checks in messages only.
absl::Status CheckUser(const std::string& user) { return convert::RequireText(kUserKey, user, 1, kMaxUserBytes); }

// The one value of a property of the connection, if it has one.
std::optional<std::string> Property(const grpc::AuthContext& connection, const std::string& name) {
  const std::vector<grpc::string_ref> values = connection.FindPropertyValues(name);
  if (values.size() != 1) return std::nullopt;
  return std::string(values[0].data(), values[0].size());
}

// Who calls: where the call was forwarded, as whoever forwarded it has seen.
absl::StatusOr<access::ForwardedCaller> CallerOf(const handlers::Core& core, const grpc::ServerContext& context) {
  if (const std::optional<std::string> ticket = Metadata(context, access::kTicketKey)) {
    std::optional<access::ForwardedCaller> forwarded = core.forwarded.Find(*ticket);
    if (forwarded) return *std::move(forwarded);
    return base::Error(absl::StatusCode::kUnauthenticated,
                       std::string(access::kTicketKey) + " names no call that this server forwards",
                       {"IDENTITY_MISSING", {}});
  }
  access::ForwardedCaller caller{{}, context.peer()};
  access::Credentials& credentials = caller.credentials;
  if (!core.gate.asks()) {
    credentials.login = core.login_of(caller.peer);
    return caller;
  }
  credentials.authorization = Metadata(context, "authorization");
  const std::shared_ptr<const grpc::AuthContext> connection = context.auth_context();
  if (connection == nullptr || !connection->IsPeerAuthenticated()) return caller;
  TakeCertificate([&connection](const char* name) { return Property(*connection, name); }, credentials);
  return caller;
}

// One call's way through the gate, at its begin and again while it is open. Safe from any thread.
class Admission {
 public:
  Admission(const access::Gate& gate, access::Credentials credentials, std::string method)
      : gate_(gate), credentials_(std::move(credentials)), method_(std::move(method)) {}

  absl::StatusOr<access::Identity> Identify() const { return gate_.Identify(credentials_); }
  // With what the request names, once it is there. What is refused is told by the handler's status, and is not asked
  // again meanwhile: the call would be cut off before its caller reads why.
  absl::StatusOr<storage::Visible> Admit(const access::Identity& identity, const google::protobuf::Message* request) {
    std::optional<std::vector<storage::Resource>> named;
    if (request != nullptr) named = access::NamedIn(*request);
    ASSIGN_OR_RETURN(storage::Visible visible, gate_.Admit(identity, method_, named));
    const base::MutexLock lock(mutex_);
    named_ = std::move(named);
    visible_ = visible;
    return visible;
  }
  absl::Status AskAgain() {
    ASSIGN_OR_RETURN(const access::Identity identity, Identify());
    std::optional<std::vector<storage::Resource>> named;
    storage::Visible before;
    {
      const base::MutexLock lock(mutex_);
      named = named_;
      before = visible_;
    }
    ASSIGN_OR_RETURN(const storage::Visible now, gate_.Admit(identity, method_, named));
    // A stream that shows what may be seen begins anew when that has changed.
    const access::MethodRule* const rule = access::FindMethod(method_);
    const bool is_same = now.everything == before.everything && now.scopes == before.scopes;
    if (is_same || rule == nullptr || rule->reach != access::Reach::kList) return absl::OkStatus();
    return absl::PermissionDeniedError("what " + identity.name + " may see has changed");
  }

 private:
  const access::Gate& gate_;
  const access::Credentials credentials_;
  const std::string method_;
  base::Mutex mutex_;
  std::optional<std::vector<storage::Resource>> named_ AXISCAL_GUARDED_BY(mutex_);
  storage::Visible visible_ AXISCAL_GUARDED_BY(mutex_);
};

// Our bug: the caller gets the id, the log the rest.
absl::Status InternalError(const std::string& what) {
  static std::atomic<int64_t> next_id = 1;
  const std::string id = absl::StrCat(base::ToUtcUs(base::SystemClock().UtcNow()), "-", next_id++);
  Log(LogLevel::kError, "internal", {{"id", id}, {"what", what}});
  return base::Error(absl::StatusCode::kInternal, "internal error, see log entry " + id,
                     {"INTERNAL", {{"log_id", id}}});
}

absl::Status Run(const std::function<absl::Status(const handlers::Call&)>& handler, const handlers::Call& call) {
  if (call.is_cancelled()) {
    return base::Error(absl::StatusCode::kCancelled, "the caller has left", {"CALLER_GONE", {}});
  }
  // Nothing of ours throws; libraries below might.
  try {
    return handler(call);
  } catch (const std::exception& error) {
    return InternalError(error.what());
  } catch (...) {
    return InternalError("an exception of unknown type");
  }
}

// By which a repeated request is known: of the message, or of the header that a stream begins with. Empty: it has none.
std::string RequestIdOf(const google::protobuf::Message& message) {
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  if (const auto* id = message.GetDescriptor()->FindFieldByName("request_id"))
    return reflection.GetString(message, id).substr(0, handlers::kMaxRequestIdBytes);
  const auto* header = message.GetDescriptor()->FindFieldByName("header");
  const bool is_one = header != nullptr && header->message_type() != nullptr && !header->is_repeated();
  return !is_one ? "" : RequestIdOf(reflection.GetMessage(message, header));
}

// Who calls, whether it may, and then the handler.
absl::Status Pass(handlers::Core& core, const grpc::ServerContext& context, const std::shared_ptr<Admission>& admission,
                  const google::protobuf::Message* request, handlers::Call& call, std::string& request_id,
                  const std::function<absl::Status(const handlers::Call&)>& handler) {
  if (request != nullptr) request_id = RequestIdOf(*request);
  const absl::StatusOr<access::Identity> identified = admission->Identify();
  CallHeads::SetKnown(context, identified.ok());
  if (!identified.ok()) {
    // Who tries one token after the other is counted by where he is.
    RETURN_IF_ERROR(core.rates.Take(call.peer));
    return identified.status();
  }
  const access::Identity& identity = *identified;
  call.user = identity.name;
  if (!identity.is_local) {
    core.known.Add(context.peer());
    RETURN_IF_ERROR(core.rates.Take(identity.name));
    call.counted_as = identity.name;
  }
  call.grants = identity.grants;
  ASSIGN_OR_RETURN(call.visible, admission->Admit(identity, request));
  call.admit = [&](const google::protobuf::Message& first) {
    request_id = RequestIdOf(first);
    return admission->Admit(identity, &first).status();
  };
  const handlers::OpenCalls::Place open(core.open, {[admission] { return admission->AskAgain(); }, call.cut_off});
  return Run(handler, call);
}

}  // namespace

grpc::Status ToGrpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const google::rpc::Status details = convert::ToProto(status);
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), details.message(), details.SerializeAsString());
}

grpc::Status RespondStream(handlers::Core& core, grpc::ServerContext* context, const std::string& method,
                           const google::protobuf::Message* request,
                           const std::function<absl::Status(const handlers::Call&)>& handler) {
  const InHandler in_handler(context);
  const base::SteadyTime start = base::SystemClock().SteadyNow();
  handlers::Call call;
  call.is_cancelled = [context] { return context->IsCancelled(); };
  call.cut_off = [context] { context->TryCancel(); };
  const std::string says = Metadata(*context, kUserKey).value_or("anonymous");
  // W3C Trace Context: which call of whoever called this one belongs to.
  call.trace = Metadata(*context, handlers::kTraceKey).value_or("");
  if (!handlers::IsTraceParent(call.trace)) call.trace.clear();
  ++core.open_calls;
  core.metrics->CallStarted(method);
  const absl::StatusOr<access::ForwardedCaller> caller = CallerOf(core, *context);
  call.peer = access::PeerHost(caller.ok() ? caller->peer : context->peer());
  if (GetLogLevel() == LogLevel::kDebug) {
    Log(LogLevel::kDebug, "call_begin",
        {{"method", method}, {"peer", call.peer}, {"says", says.substr(0, kMaxUserBytes)}, {"trace", call.trace}});
  }
  std::string request_id;
  absl::Status status = caller.ok() ? CheckUser(says) : caller.status();
  if (status.ok()) {
    const auto admission = std::make_shared<Admission>(core.gate, caller->credentials, method);
    status = Pass(core, *context, admission, request, call, request_id, handler);
  }
  core.denied(call, method, status);
  --core.open_calls;
  const std::chrono::duration<double, std::milli> took = base::SystemClock().SteadyNow() - start;
  core.metrics->CallEnded(method, status.code(), took);
  if (base::ErrorReason(status) == "RATE_EXCEEDED" && !core.told_refusals.Take("log").ok()) return ToGrpc(status);
  LogFields fields = {{"method", method},
                      {"peer", caller.ok() ? caller->peer : context->peer()},
                      {"user", call.user},
                      {"says", says.substr(0, kMaxUserBytes)},
                      {"code", absl::StatusCodeToString(status.code())},
                      {"ms", absl::StrFormat("%.3f", took.count())}};
  if (!request_id.empty()) fields.push_back({"request", request_id});
  if (!call.trace.empty()) fields.push_back({"trace", call.trace});
  if (!status.ok()) {
    fields.push_back({"reason", base::ErrorReason(status)});
    fields.push_back({"text", std::string(status.message())});
  }
  Log(status.ok() ? LogLevel::kInfo : LogLevel::kWarning, "call", fields);
  return ToGrpc(status);
}

}  // namespace axiscal::server
