#include "server/respond.h"

#include <exception>

#include "core/base/clock.h"
#include "core/base/error_detail.h"
#include "proto/convert/field.h"
#include "proto/convert/status.h"
#include "server/call_guard.h"
#include "server/log.h"

namespace axiscal::server {
namespace {

// The metadata key with which clients say who they are.
constexpr char kUserKey[] = "axiscal-user";
constexpr size_t kMaxUserBytes = 200;

handlers::Call CallOf(grpc::ServerContext* context) {
  handlers::Call call;
  const auto found = context->client_metadata().find(kUserKey);
  call.user =
      found == context->client_metadata().end() ? "anonymous" : std::string(found->second.data(), found->second.size());
  call.is_cancelled = [context] { return context->IsCancelled(); };
  call.cut_off = [context] { context->TryCancel(); };
  return call;
}

// What a caller says in the metadata is stored and sent to others: it is held to the rules of a text field, which
// Protobuf checks in messages only.
absl::Status CheckUser(const std::string& user) { return convert::RequireText(kUserKey, user, 1, kMaxUserBytes); }

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

}  // namespace

grpc::Status ToGrpc(const absl::Status& status) {
  if (status.ok()) return grpc::Status::OK;
  const google::rpc::Status details = convert::ToProto(status);
  return grpc::Status(static_cast<grpc::StatusCode>(status.code()), details.message(), details.SerializeAsString());
}

grpc::Status RespondStream(handlers::Core& core, grpc::ServerContext* context, const std::string& method,
                           const std::function<absl::Status(const handlers::Call&)>& handler) {
  const InHandler in_handler(context);
  const base::SteadyTime start = base::SystemClock().SteadyNow();
  const handlers::Call call = CallOf(context);
  ++core.open_calls;
  const absl::Status known = CheckUser(call.user);
  const absl::Status status = known.ok() ? Run(handler, call) : known;
  --core.open_calls;
  const std::chrono::duration<double, std::milli> took = base::SystemClock().SteadyNow() - start;
  LogFields fields = {{"method", method},
                      {"peer", context->peer()},
                      {"user", call.user.substr(0, kMaxUserBytes)},
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
