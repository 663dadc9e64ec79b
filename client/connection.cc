#include "client/connection.h"

#include <algorithm>
#include <random>
#include <thread>

#include "absl/strings/match.h"
#include "core/base/error_detail.h"
#include "core/base/files.h"
#include "google/rpc/status.pb.h"
#include "proto/convert/status.h"

namespace axiscal::client {
namespace {

// Whether gRPC says so of the connection, or a proxy of what is behind it: axiscald sends details with each error. A
// stream whose server was killed ends as UNKNOWN "Stream removed"; one that a proxy cuts off is reset, with a code by
// the proxy's choice.
bool IsOfConnection(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNAVAILABLE || status.error_message() == "Stream removed" ||
         (absl::StartsWith(status.error_message(), "Received RST_STREAM") &&
          status.error_code() != grpc::StatusCode::RESOURCE_EXHAUSTED);
}

}  // namespace

bool Backoff::Wait(base::SteadyTime deadline) {
  if (base::SystemClock().SteadyNow() + next_ >= deadline) return false;
  std::this_thread::sleep_for(next_);
  next_ = std::min(2 * next_, max_);
  return true;
}

std::unique_ptr<grpc::ClientContext> Connection::NewContext(base::SteadyTime deadline) const {
  auto context = std::make_unique<grpc::ClientContext>();
  context->set_wait_for_ready(true);
  context->set_deadline(
      std::chrono::system_clock::now() +
      std::chrono::duration_cast<std::chrono::system_clock::duration>(deadline - base::SystemClock().SteadyNow()));
  context->AddMetadata("axiscal-user", options_.user);
  // Each attempt is a step of its own.
  context->AddMetadata("traceparent", absl::StrCat("00-", trace_id_, "-", NewRequestId().substr(0, 16), "-01"));
  if (!options_.identity.token_file.empty()) {
    // A file that cannot be read now is as no token: the server says what it misses.
    const absl::StatusOr<std::string> token = ReadToken(options_.identity.token_file);
    if (token.ok()) context->AddMetadata("authorization", "Bearer " + *token);
  }
  return context;
}

std::unique_ptr<grpc::ClientContext> Connection::NewStreamContext() const {
  if (!address_.empty()) channel_->WaitForConnected(std::chrono::system_clock::now() + options_.max_backoff);
  std::unique_ptr<grpc::ClientContext> context = NewContext(base::SystemClock().SteadyNow() + options_.stream_deadline);
  context->set_wait_for_ready(false);
  return context;
}

bool Connection::IsConnected() const { return address_.empty() || channel_->GetState(false) == GRPC_CHANNEL_READY; }

absl::Status Connection::Call(const std::function<grpc::Status(grpc::ClientContext*)>& attempt) const {
  return Call(attempt, options_.call_deadline);
}

absl::Status Connection::Call(const std::function<grpc::Status(grpc::ClientContext*)>& attempt,
                              std::chrono::milliseconds deadline) const {
  const base::SteadyTime end = base::SystemClock().SteadyNow() + deadline;
  Backoff backoff(options_);
  while (true) {
    const std::unique_ptr<grpc::ClientContext> context = NewContext(end);
    const absl::Status status = FromGrpc(attempt(context.get()));
    if (!absl::IsUnavailable(status) || base::ErrorReason(status) == "NO_CONNECTION" || !backoff.Wait(end))
      return status;
  }
}

absl::Status Connection::FromGrpc(const grpc::Status& status) const {
  if (status.ok()) return absl::OkStatus();
  google::rpc::Status details;
  if (!status.error_details().empty() && details.ParseFromString(status.error_details()) && details.code() != 0) {
    const absl::Status full = convert::FromProto(details);
    base::ErrorDetail detail = base::GetErrorDetail(full).value_or(base::ErrorDetail{});
    if (detail.reason.empty()) return full;
    return base::Error(full.code(), absl::StrCat(full.message(), " [", detail.reason, "]"), detail);
  }
  const bool is_timeout = status.error_code() == grpc::StatusCode::DEADLINE_EXCEEDED;
  if (is_timeout && !IsConnected()) {
    return base::Error(absl::StatusCode::kUnavailable, "no connection to " + address_ + " [NO_CONNECTION]",
                       {"NO_CONNECTION", {}});
  }
  if (IsOfConnection(status)) {
    return base::Error(
        absl::StatusCode::kUnavailable,
        absl::StrCat("the connection to ", address_.empty() ? "the server" : address_, " broke off (",
                     status.error_message().empty() ? "no reason" : status.error_message(),
                     "): the server ended, or the network did. What it had acknowledged is kept; repeat the call when "
                     "it answers again, or at another replica of it [CONNECTION_LOST]"),
        {"CONNECTION_LOST", {}});
  }
  return absl::Status(static_cast<absl::StatusCode>(status.error_code()),
                      status.error_message().empty() ? "the server gave no reason" : status.error_message());
}

bool IsBroken(const absl::Status& status) { return absl::IsUnavailable(status) || absl::IsDeadlineExceeded(status); }

absl::StatusOr<std::string> ReadToken(const std::string& file) {
  constexpr size_t kMaxTokenBytes = 4096;
  ASSIGN_OR_RETURN(std::string token, base::ReadFile(file, kMaxTokenBytes));
  while (!token.empty() && (token.back() == '\n' || token.back() == '\r' || token.back() == ' ')) token.pop_back();
  const bool is_one_word =
      !token.empty() && std::all_of(token.begin(), token.end(), [](char c) { return c > 0x20 && c < 0x7f; });
  if (is_one_word) return token;
  return absl::InvalidArgumentError(file + ": must hold one token on one line");
}

std::string NewRequestId() {
  std::random_device random;
  std::string id;
  for (int i = 0; i < 4; ++i) id += absl::StrFormat("%08x", random());
  return id;
}

}  // namespace axiscal::client
