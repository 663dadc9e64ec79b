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
#include "server/certificates.h"
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

access::Credentials CredentialsOf(const handlers::Core& core, const grpc::ServerContext& context) {
  access::Credentials credentials;
  if (!core.gate.asks()) {
    credentials.login = core.login_of(context.peer());
    return credentials;
  }
  credentials.authorization = Metadata(context, "authorization");
  // The connection's properties are what TLS has verified; tokens, which are of one call, are not among them.
  const std::shared_ptr<const grpc::AuthContext> connection = context.auth_context();
  if (connection == nullptr || !connection->IsPeerAuthenticated()) return credentials;
  credentials.certificate_name = Property(*connection, "x509_common_name");
  if (const auto pem = Property(*connection, "x509_pem_cert")) credentials.certificate_ends = EndOfCertificate(*pem);
  return credentials;
}

// One call's way through the gate, at its begin and again while it is open. Safe from any thread.
class Admission {
 public:
  Admission(const access::Gate& gate, access::Credentials credentials, std::string method)
      : gate_(gate), credentials_(std::move(credentials)), method_(std::move(method)) {}

  absl::StatusOr<access::Identity> Identify() const { return gate_.Identify(credentials_); }
  // With what the request names, once it is there.
  absl::StatusOr<storage::Visible> Admit(const access::Identity& identity, const google::protobuf::Message* request) {
    std::optional<std::vector<storage::Resource>> named;
    if (request != nullptr) named = access::NamedIn(*request);
    const base::MutexLock lock(mutex_);
    named_ = named;
    return gate_.Admit(identity, method_, named_);
  }
  absl::Status AskAgain() {
    ASSIGN_OR_RETURN(const access::Identity identity, Identify());
    std::optional<std::vector<storage::Resource>> named;
    {
      const base::MutexLock lock(mutex_);
      named = named_;
    }
    return gate_.Admit(identity, method_, named).status();
  }

 private:
  const access::Gate& gate_;
  const access::Credentials credentials_;
  const std::string method_;
  base::Mutex mutex_;
  std::optional<std::vector<storage::Resource>> named_ AXISCAL_GUARDED_BY(mutex_);
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

// Who calls, whether it may, and then the handler.
absl::Status Pass(handlers::Core& core, const std::shared_ptr<Admission>& admission,
                  const google::protobuf::Message* request, handlers::Call& call,
                  const std::function<absl::Status(const handlers::Call&)>& handler) {
  ASSIGN_OR_RETURN(const access::Identity identity, admission->Identify());
  call.user = identity.name;
  call.grants = identity.grants;
  ASSIGN_OR_RETURN(call.visible, admission->Admit(identity, request));
  call.admit = [&](const google::protobuf::Message& first) { return admission->Admit(identity, &first).status(); };
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
  ++core.open_calls;
  absl::Status status = CheckUser(says);
  if (status.ok()) {
    const auto admission = std::make_shared<Admission>(core.gate, CredentialsOf(core, *context), method);
    status = Pass(core, admission, request, call, handler);
  }
  --core.open_calls;
  const std::chrono::duration<double, std::milli> took = base::SystemClock().SteadyNow() - start;
  LogFields fields = {{"method", method},
                      {"peer", context->peer()},
                      {"user", call.user},
                      {"says", says.substr(0, kMaxUserBytes)},
                      {"code", absl::StatusCodeToString(status.code())},
                      {"ms", absl::StrFormat("%.3f", took.count())}};
  if (!status.ok()) {
    fields.push_back({"reason", base::ErrorReason(status)});
    fields.push_back({"text", std::string(status.message())});
  }
  Log(status.ok() ? LogLevel::kInfo : LogLevel::kWarning, "call", fields);
  return ToGrpc(status);
}

}  // namespace axiscal::server
