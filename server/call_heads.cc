#include "server/call_heads.h"

#include <grpc/grpc.h>
#include <grpc/slice.h>
#include <grpcpp/security/auth_context.h>

#include <string_view>
#include <utility>

#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "server/certificates.h"

namespace axiscal::server {
namespace {

// What is noted of a connection. It lies in the value of one of the connection's properties and goes with it: gRPC says
// nowhere that a connection has ended.
struct Notes {
  int32_t open;      // calls that wait for their message, or are of health
  int32_t is_known;  // 1: its caller has shown who he is
};
constexpr char kNotesKey[] = "axiscal_notes";
constexpr std::string_view kHealth = "/grpc.health.v1.Health/";

Notes* NotesAt(const char* value, size_t size) {
  DEMAND(size == sizeof(Notes));
  // gRPC has it from malloc(), and no other thread changes it but as an atomic.
  return reinterpret_cast<Notes*>(const_cast<char*>(value));
}
std::atomic_ref<int32_t> Open(Notes& notes) { return std::atomic_ref(notes.open); }
std::atomic_ref<int32_t> IsKnown(Notes& notes) { return std::atomic_ref(notes.is_known); }

const grpc_auth_property* Find(const grpc_auth_context* connection, const char* name) {
  grpc_auth_property_iterator found = grpc_auth_context_find_properties_by_name(connection, name);
  return grpc_auth_property_iterator_next(&found);
}

// Null where the connection is not looked at. As long as `connection` lives.
Notes* Find(const grpc::AuthContext* connection) {
  if (connection == nullptr) return nullptr;
  const std::vector<grpc::string_ref> values = connection->FindPropertyValues(kNotesKey);
  return values.empty() ? nullptr : NotesAt(values[0].data(), values[0].size());
}

// The one value of a property of the connection, if it has one.
std::optional<std::string> Property(const grpc_auth_context* connection, const char* name) {
  grpc_auth_property_iterator found = grpc_auth_context_find_properties_by_name(connection, name);
  const grpc_auth_property* const one = grpc_auth_property_iterator_next(&found);
  if (one == nullptr || grpc_auth_property_iterator_next(&found) != nullptr) return std::nullopt;
  return std::string(one->value, one->value_length);
}

std::string_view TextOf(const grpc_slice& slice) {
  return {reinterpret_cast<const char*>(GRPC_SLICE_START_PTR(slice)), GRPC_SLICE_LENGTH(slice)};
}

std::optional<std::string> Metadata(const grpc_metadata* metadata, size_t count, std::string_view key) {
  for (const grpc_metadata* one = metadata; one != metadata + count; ++one) {
    if (TextOf(one->key) == key) return std::string(TextOf(one->value));
  }
  return std::nullopt;
}

access::Credentials CredentialsOf(const grpc_auth_context* connection, const grpc_metadata* metadata, size_t count) {
  access::Credentials credentials;
  credentials.authorization = Metadata(metadata, count, "authorization");
  if (grpc_auth_context_peer_is_authenticated(connection) == 0) return credentials;
  TakeCertificate([connection](const char* name) { return Property(connection, name); }, credentials);
  return credentials;
}

class PlainCredentialsOfHeads final : public grpc::ServerCredentials {
 public:
  explicit PlainCredentialsOfHeads(CallHeads& heads) : credentials_(grpc_insecure_server_credentials_create()) {
    heads.LookAt(credentials_);
  }
  ~PlainCredentialsOfHeads() override { grpc_server_credentials_release(credentials_); }
  void SetAuthMetadataProcessor(const std::shared_ptr<grpc::AuthMetadataProcessor>&) override {}

 private:
  int AddPortToServer(const std::string& address, grpc_server* server) override {
    return grpc_server_add_http2_port(server, address.c_str(), credentials_);
  }

  grpc_server_credentials* const credentials_;
};

// gRPC answers health by itself: no guard hears of those calls. This lives as long as one of them whose message has
// come.
class HealthCall final : public grpc::experimental::Interceptor {
 public:
  explicit HealthCall(grpc::ServerContextBase* call) : call_(call) {}
  ~HealthCall() override {
    if (Notes* const notes = Find(connection_.get())) --Open(*notes);
  }
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    // The context has a call, and by it a connection, only after this object was made.
    if (connection_ == nullptr) connection_ = call_->auth_context();
    methods->Proceed();
  }

 private:
  grpc::ServerContextBase* const call_;
  std::shared_ptr<const grpc::AuthContext> connection_;
};

class HealthCounterFactory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override {
    const bool is_health = std::string_view(info->method()).starts_with(kHealth);
    return is_health ? new HealthCall(info->server_context()) : nullptr;
  }
};

}  // namespace

void TakeCertificate(const std::function<std::optional<std::string>(const char* name)>& property,
                     access::Credentials& credentials) {
  credentials.certificate_name = property("x509_common_name");
  if (const auto pem = property("x509_pem_cert")) credentials.certificate_ends = EndOfCertificate(*pem);
}

void CallHeads::LookAt(grpc_server_credentials* credentials) {
  grpc_server_credentials_set_auth_metadata_processor(credentials, {&CallHeads::Process, nullptr, this});
}

std::shared_ptr<grpc::ServerCredentials> CallHeads::PlainCredentials() {
  return std::make_shared<PlainCredentialsOfHeads>(*this);
}

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> CallHeads::HealthCounter() {
  return std::make_unique<HealthCounterFactory>();
}

void CallHeads::Hear(const grpc::ServerContextBase& call) {
  if (Notes* const notes = Find(call.auth_context().get())) --Open(*notes);
}

void CallHeads::SetKnown(const grpc::ServerContextBase& call, bool is_known) {
  if (Notes* const notes = Find(call.auth_context().get())) IsKnown(*notes) = is_known ? 1 : 0;
}

void CallHeads::Process(void* heads, grpc_auth_context* connection, const grpc_metadata* metadata, size_t count,
                        grpc_process_auth_metadata_done_cb done, void* done_data) {
  const absl::Status status = static_cast<CallHeads*>(heads)->Look(connection, metadata, count);
  const std::string words(status.message());
  done(done_data, nullptr, 0, nullptr, 0, static_cast<grpc_status_code>(status.code()), words.c_str());
}

absl::Status CallHeads::Look(grpc_auth_context* connection, const grpc_metadata* metadata, size_t count) {
  const grpc_auth_property* property = nullptr;
  {
    const base::MutexLock lock(mutex_);
    property = Find(connection, kNotesKey);
    if (property == nullptr) {
      const Notes none = {0, 0};
      grpc_auth_context_add_property(connection, kNotesKey, reinterpret_cast<const char*>(&none), sizeof(none));
      property = Find(connection, kNotesKey);
    }
  }
  DEMAND(property != nullptr);
  Notes& notes = *NotesAt(property->value, property->value_length);
  const int32_t open = ++Open(notes);
  if (open <= kMostOfAStranger || IsKnown(notes) != 0) return absl::OkStatus();
  absl::Status status = identify_(CredentialsOf(connection, metadata, count));
  if (status.ok()) {
    IsKnown(notes) = 1;
    return status;
  }
  --Open(notes);
  ++refused_;
  if (!absl::IsUnauthenticated(status) || !Metadata(metadata, count, ":path").value_or("").starts_with(kHealth))
    return status;
  return absl::ResourceExhaustedError(absl::StrCat("a connection that has shown no identity has at most ",
                                                   kMostOfAStranger, " calls of grpc.health.v1 at a time"));
}

}  // namespace axiscal::server
