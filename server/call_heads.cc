#include "server/call_heads.h"

#include <grpc/grpc.h>
#include <grpc/slice.h>
#include <grpcpp/security/auth_context.h>

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "core/base/demand.h"
#include "core/base/error_detail.h"
#include "server/access/known_peers.h"
#include "server/certificates.h"

namespace axiscal::server {
namespace {

constexpr char kNotesKey[] = "axiscal_notes";
constexpr std::string_view kHealth = "/grpc.health.v1.Health/";

template <typename Number>
std::atomic_ref<Number> Shared(Number& number) {
  return std::atomic_ref(number);
}

const grpc_auth_property* FindProperty(const grpc_auth_context* connection, const char* name) {
  grpc_auth_property_iterator found = grpc_auth_context_find_properties_by_name(connection, name);
  return grpc_auth_property_iterator_next(&found);
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
    if (connection_ != nullptr) CallHeads::EndHealth(*connection_);
  }
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    // The context has a call, and by it a connection, only after this object was made.
    if (connection_ == nullptr) {
      connection_ = call_->auth_context();
      CallHeads::HearHealth(*call_);
    }
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

// What is noted of a connection. It lies in the value of one of the connection's properties and goes with it: gRPC says
// nowhere that a connection has ended. But for `heads` each is changed as an atomic.
struct CallHeads::Notes {
  CallHeads* heads;
  int32_t waiting = 0;   // calls whose message has not come
  int32_t health = 0;    // calls of health whose message has come
  int32_t is_known = 0;  // 1: its caller has shown who he is
  int32_t is_told = 0;   // 1: in told_
  int32_t was_none = 0;  // 1: none waited at some time since it was asked
};

CallHeads::Notes* CallHeads::NotesAt(const char* value, size_t size) {
  DEMAND(size == sizeof(Notes));
  // gRPC has it from malloc(), and no other thread changes it but as an atomic.
  return reinterpret_cast<Notes*>(const_cast<char*>(value));
}

// Null where the connection is not looked at. As long as `connection` lives.
CallHeads::Notes* CallHeads::Find(const grpc::AuthContext* connection) {
  if (connection == nullptr) return nullptr;
  const std::vector<grpc::string_ref> values = connection->FindPropertyValues(kNotesKey);
  return values.empty() ? nullptr : NotesAt(values[0].data(), values[0].size());
}

void CallHeads::Hear(const grpc::ServerContextBase& call) {
  const std::shared_ptr<const grpc::AuthContext> connection = call.auth_context();
  if (Notes* const notes = Find(connection.get())) notes->heads->Hear(call, *notes, connection);
}

void CallHeads::HearHealth(const grpc::ServerContextBase& call) {
  const std::shared_ptr<const grpc::AuthContext> connection = call.auth_context();
  Notes* const notes = Find(connection.get());
  if (notes == nullptr) return;
  ++Shared(notes->health);  // first: the two together are never less than what is open
  notes->heads->Hear(call, *notes, connection);
}

void CallHeads::EndHealth(const grpc::AuthContext& connection) {
  if (Notes* const notes = Find(&connection)) --Shared(notes->health);
}

void CallHeads::Hear(const grpc::ServerContextBase& call, Notes& notes,
                     const std::shared_ptr<const grpc::AuthContext>& on) {
  if (Shared(notes.is_told) == 0) {
    const base::MutexLock lock(mutex_);
    if (Shared(notes.is_told).exchange(1) == 0) {
      unheard_ -= Shared(notes.waiting);
      told_.insert_or_assign(access::PlainPeer(call.peer()), Told{&notes, on});
    }
  }
  if (--Shared(notes.waiting) == 0) Shared(notes.was_none) = 1;
}

void CallHeads::SetKnown(const grpc::ServerContextBase& call, bool is_known) {
  if (Notes* const notes = Find(call.auth_context().get())) Shared(notes->is_known) = is_known ? 1 : 0;
}

int64_t CallHeads::waiting() const {
  const base::MutexLock lock(mutex_);
  int64_t sum = unheard_;
  for (const auto& [peer, one] : told_) sum += Shared(one.notes->waiting);
  return sum;
}

std::optional<WaitingCalls> CallHeads::WaitingOf(const std::string& peer) {
  const base::MutexLock lock(mutex_);
  const auto found = told_.find(peer);
  if (found == told_.end()) return std::nullopt;
  Notes& notes = *found->second.notes;
  const bool was_none = Shared(notes.was_none).exchange(0) != 0;
  const int32_t calls = Shared(notes.waiting);
  return WaitingCalls{calls, was_none || calls == 0};
}

size_t CallHeads::told() const {
  const base::MutexLock lock(mutex_);
  return told_.size();
}

void CallHeads::Forget(const std::string& peer) {
  const base::MutexLock lock(mutex_);
  told_.erase(peer);
}

void CallHeads::ForgetGone(const std::function<std::vector<std::string>()>& connected) {
  std::set<std::string> gone;
  {
    const base::MutexLock lock(mutex_);
    for (const auto& [peer, one] : told_) gone.insert(peer);
  }
  int64_t others = 0;
  for (const std::string& peer : connected()) others += gone.erase(peer) == 0 ? 1 : 0;
  const base::MutexLock lock(mutex_);
  for (const std::string& peer : gone) told_.erase(peer);
  unheard_ = std::min(unheard_, others * kMostUnheardOfOne);
}

void CallHeads::Process(void* heads, grpc_auth_context* connection, const grpc_metadata* metadata, size_t count,
                        grpc_process_auth_metadata_done_cb done, void* done_data) {
  const absl::Status status = static_cast<CallHeads*>(heads)->Look(connection, metadata, count);
  const std::string words(status.message());
  done(done_data, nullptr, 0, nullptr, 0, static_cast<grpc_status_code>(status.code()), words.c_str());
}

absl::Status CallHeads::Look(grpc_auth_context* connection, const grpc_metadata* metadata, size_t count) {
  Notes* notes = nullptr;
  {
    const base::MutexLock lock(mutex_);
    const grpc_auth_property* property = FindProperty(connection, kNotesKey);
    if (property == nullptr) {
      const Notes none = {this};
      grpc_auth_context_add_property(connection, kNotesKey, reinterpret_cast<const char*>(&none), sizeof(none));
      property = FindProperty(connection, kNotesKey);
    }
    DEMAND(property != nullptr);
    notes = NotesAt(property->value, property->value_length);
    ++Shared(notes->waiting);
    if (Shared(notes->is_told) == 0) ++unheard_;
  }
  absl::Status status = MayWait(*notes, connection, metadata, count);
  if (status.ok()) return status;
  ++refused_;
  const base::MutexLock lock(mutex_);
  --Shared(notes->waiting);
  if (Shared(notes->is_told) == 0) --unheard_;
  return status;
}

absl::Status CallHeads::MayWait(Notes& notes, const grpc_auth_context* connection, const grpc_metadata* metadata,
                                size_t count) {
  if (Shared(notes.waiting) + Shared(notes.health) <= kMostOfAStranger) return absl::OkStatus();
  if (Shared(notes.is_known) == 0) {
    const absl::Status status = identify_(CredentialsOf(connection, metadata, count));
    const bool is_health = Metadata(metadata, count, ":path").value_or("").starts_with(kHealth);
    if (absl::IsUnauthenticated(status) && is_health) {
      return absl::ResourceExhaustedError(absl::StrCat("a connection that has shown no identity has at most ",
                                                       kMostOfAStranger, " calls of grpc.health.v1 at a time"));
    }
    RETURN_IF_ERROR(status);
    Shared(notes.is_known) = 1;
  }
  if (Shared(notes.is_told) != 0 || Shared(notes.waiting) <= kMostUnheardOfOne) return absl::OkStatus();
  return absl::ResourceExhaustedError(
      absl::StrCat("a connection has at most ", kMostUnheardOfOne, " calls until the message of the first has come"));
}

}  // namespace axiscal::server
