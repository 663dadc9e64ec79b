// One channel to a server and how calls over it are made: deadlines, retries with backoff, errors as absl::Status.
// Internal to the client.
#ifndef AXISCAL_CLIENT_CONNECTION_H_
#define AXISCAL_CLIENT_CONNECTION_H_

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <functional>
#include <memory>
#include <string>

#include "client/options.h"
#include "core/base/clock.h"

namespace axiscal::client {

// Waits that double from first_backoff to max_backoff.
class Backoff {
 public:
  explicit Backoff(const Options& options) : next_(options.first_backoff), max_(options.max_backoff) {}
  // Sleeps, but not beyond `deadline`; false when that is over.
  bool Wait(base::SteadyTime deadline);

 private:
  std::chrono::milliseconds next_;
  std::chrono::milliseconds max_;
};

// An id for one call whose caller did not choose one: 32 random hexadecimal digits.
std::string NewRequestId();

// Safe from any thread.
class Connection {
 public:
  // `address` is for messages; empty for a server in this process, whose channel has no state to ask.
  Connection(std::shared_ptr<grpc::Channel> channel, std::string address, const Options& options)
      : channel_(std::move(channel)),
        address_(std::move(address)),
        options_(options),
        trace_id_(options.trace_parent.empty() ? NewRequestId() : TraceIdOf(options.trace_parent)) {}

  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }
  const Options& options() const { return options_; }

  // The context of one attempt: who calls, wait for the server, deadline.
  std::unique_ptr<grpc::ClientContext> NewContext(base::SteadyTime deadline) const;

  // Of one attempt at a stream: waits a little for the server, then fails at once, so that the caller's own patience
  // counts and not the stream's long deadline.
  std::unique_ptr<grpc::ClientContext> NewStreamContext() const;

  // One unary call with its retries on UNAVAILABLE, until call_deadline or, when given, `deadline` for calls that wait.
  absl::Status Call(const std::function<grpc::Status(grpc::ClientContext*)>& attempt) const;
  absl::Status Call(const std::function<grpc::Status(grpc::ClientContext*)>& attempt,
                    std::chrono::milliseconds deadline) const;

  // Ours for gRPC's: reason and facts of the details, text ending in [REASON]. UNAVAILABLE NO_CONNECTION where the time
  // was over before there was a connection, CONNECTION_LOST where it broke off.
  absl::Status FromGrpc(const grpc::Status& status) const;

 private:
  bool IsConnected() const;

  const std::shared_ptr<grpc::Channel> channel_;
  const std::string address_;
  const Options options_;
  const std::string trace_id_;  // of all its calls
};

// Worth another attempt: the server is not there now, or cut the stream off.
bool IsBroken(const absl::Status& status);

// The token that a file holds. NOT_FOUND, INVALID_ARGUMENT.
absl::StatusOr<std::string> ReadToken(const std::string& file);

}  // namespace axiscal::client

#endif  // AXISCAL_CLIENT_CONNECTION_H_
