#include "proto/convert/status.h"

#include "core/base/error_detail.h"
#include "core/base/utf8.h"
#include "google/rpc/error_details.pb.h"

namespace axiscal::convert {
namespace {

constexpr int64_t kRetryAfterBusySeconds = 1;
constexpr int64_t kRetryAfterFullSeconds = 5;

}  // namespace

google::rpc::Status ToProto(const absl::Status& status) {
  google::rpc::Status message;
  message.set_code(static_cast<int>(status.code()));
  // A message may show a line of a program or a name in an encoding of its own.
  message.set_message(base::ToUtf8(std::string(status.message())));
  base::ErrorDetail detail = base::GetErrorDetail(status).value_or(base::ErrorDetail{});
  if (detail.reason.empty()) detail.reason = absl::StatusCodeToString(status.code());

  google::rpc::ErrorInfo info;
  info.set_reason(detail.reason);
  info.set_domain(kErrorDomain);
  for (auto& [key, value] : detail.facts) {
    value = base::ToUtf8(std::move(value));
    (*info.mutable_metadata())[key] = value;
  }
  message.add_details()->PackFrom(info);

  if (detail.facts.count("field")) {
    google::rpc::BadRequest bad_request;
    google::rpc::BadRequest::FieldViolation* violation = bad_request.add_field_violations();
    violation->set_field(detail.facts["field"]);
    violation->set_description(detail.facts.count("rule") ? detail.facts["rule"] : message.message());
    message.add_details()->PackFrom(bad_request);
  }
  const bool is_full = status.code() == absl::StatusCode::kResourceExhausted;
  if (is_full || status.code() == absl::StatusCode::kUnavailable) {
    google::rpc::RetryInfo retry;
    retry.mutable_retry_delay()->set_seconds(is_full ? kRetryAfterFullSeconds : kRetryAfterBusySeconds);
    message.add_details()->PackFrom(retry);
  }
  return message;
}

absl::Status FromProto(const google::rpc::Status& message) {
  const auto code = static_cast<absl::StatusCode>(message.code());
  if (code == absl::StatusCode::kOk) return absl::OkStatus();
  for (const google::protobuf::Any& any : message.details()) {
    google::rpc::ErrorInfo info;
    if (!any.Is<google::rpc::ErrorInfo>() || !any.UnpackTo(&info)) continue;
    base::ErrorDetail detail{info.reason(), {}};
    for (const auto& [key, value] : info.metadata()) detail.facts[key] = value;
    return base::Error(code, message.message(), detail);
  }
  return absl::Status(code, message.message());
}

}  // namespace axiscal::convert
