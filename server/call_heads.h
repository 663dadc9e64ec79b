// What is decided when the head of a call is there, before its message. gRPC 1.51 tells no handler of a call whose
// message has not come, keeps it as long as its connection lives, some 12 KB, and holds a client to its limit of calls
// only once the client has acknowledged that limit.
#ifndef AXISCAL_SERVER_CALL_HEADS_H_
#define AXISCAL_SERVER_CALL_HEADS_H_

#include <grpc/grpc_security.h>
#include <grpcpp/security/server_credentials.h>
#include <grpcpp/server_context.h>
#include <grpcpp/support/server_interceptor.h>

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/mutex.h"
#include "core/base/status.h"
#include "server/access/gate.h"
#include "server/half_sent.h"

namespace axiscal::server {

// What TLS has verified of a connection, into the credentials of a call on it. `property`: the one value of a property
// of the connection, if it has one; tokens, which are of one call, are not among them.
void TakeCertificate(const std::function<std::optional<std::string>(const char* name)>& property,
                     access::Credentials& credentials);

// Lets a connection that has shown no identity have few calls that wait for their message, or are of health; what it
// begins beyond them shows an identity with its head or is refused there, with the code and words of a handler, but
// without details: gRPC sends none for it. Counts what waits of all connections. Safe from any thread.
class CallHeads {
 public:
  // Of a connection whose caller is known, as long as none of its calls has been heard: which connection it is, is told
  // with the first (WaitingOf()). More than honest clients begin before the first of their calls has a thread.
  static constexpr int kMostUnheardOfOne = 256;
  // Of each such connection. One that takes a call back before its message has come has one less from then on. Honest
  // ones have one at a time, and two thousand connections with as many each fit the memory of a small server.
  static constexpr int kMostOfAStranger = 4;
  // UNAUTHENTICATED, or why it cannot be told (Gate::Identify()).
  using Identify = std::function<absl::Status(const access::Credentials&)>;

  explicit CallHeads(Identify identify) : identify_(std::move(identify)) {}
  CallHeads(const CallHeads&) = delete;
  CallHeads& operator=(const CallHeads&) = delete;

  // From then on, of all connections that come by these credentials. They are used no longer than this lives.
  void LookAt(grpc_server_credentials* credentials);
  // Those of connections without TLS, looked at.
  std::shared_ptr<grpc::ServerCredentials> PlainCredentials();
  // What counts the calls of health, for each server whose connections are looked at.
  static std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> HealthCounter();

  // The message of a call has come, or its handler waits for it. Calls of connections that are not looked at are let
  // be.
  static void Hear(const grpc::ServerContextBase& call);
  // The same of a call of health, which counts among those of its connection until EndHealth().
  static void HearHealth(const grpc::ServerContextBase& call);
  static void EndHealth(const grpc::AuthContext& connection);
  // Whether the caller of a call on this connection is known; as long as the last one is, the connection is no
  // stranger's.
  static void SetKnown(const grpc::ServerContextBase& call, bool is_known);

  // Calls so far.
  int64_t refused() const { return refused_; }

  // At least as many calls as wait for their message, of all connections.
  int64_t waiting() const;
  // Of a connection (access::PlainPeer) of which a call has been heard; nothing of another.
  std::optional<WaitingCalls> WaitingOf(const std::string& peer);
  // Connections that WaitingOf() tells of. Each takes some 5 KB, until it is forgotten.
  size_t told() const;
  // A connection has come: who had its address before is gone.
  void Forget(const std::string& peer);
  // All that `connected`, asked after this began, does not name are gone.
  void ForgetGone(const std::function<std::vector<std::string>()>& connected);

 private:
  struct Notes;
  struct Told {
    Notes* notes;  // lies in `connection`
    std::shared_ptr<const grpc::AuthContext> connection;
  };

  static Notes* NotesAt(const char* value, size_t size);
  static Notes* Find(const grpc::AuthContext* connection);
  void Hear(const grpc::ServerContextBase& call, Notes& notes, const std::shared_ptr<const grpc::AuthContext>& on);
  static void Process(void* heads, grpc_auth_context* connection, const grpc_metadata* metadata, size_t count,
                      grpc_process_auth_metadata_done_cb done, void* done_data);
  absl::Status Look(grpc_auth_context* connection, const grpc_metadata* metadata, size_t count);
  // Of a call that is among those of `notes` already.
  absl::Status MayWait(Notes& notes, const grpc_auth_context* connection, const grpc_metadata* metadata, size_t count);

  const Identify identify_;
  std::atomic<int64_t> refused_ = 0;
  // Held while a connection gets its notes: its first calls may come on several threads.
  mutable base::Mutex mutex_;
  std::map<std::string, Told> told_ AXISCAL_GUARDED_BY(mutex_);  // by peer
  // Calls of all connections of which none has been heard, those that have ended among them until ForgetGone().
  int64_t unheard_ AXISCAL_GUARDED_BY(mutex_) = 0;
};

}  // namespace axiscal::server

#endif  // AXISCAL_SERVER_CALL_HEADS_H_
