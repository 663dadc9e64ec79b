#include "core/base/error_detail.h"

#include <algorithm>

#include "absl/strings/cord.h"
#include "core/base/demand.h"

namespace axiscal::base {
namespace {

constexpr char kPayloadUrl[] = "axiscal/error-detail";

// Payload: the reason, then key, value, key, value ..., each ended by a NUL. One within a value, which callers may have
// sent, would begin a fact of theirs: it becomes a blank.
std::string Encode(const ErrorDetail& detail) {
  std::string text = detail.reason + '\0';
  for (auto [key, value] : detail.facts) {
    std::replace(value.begin(), value.end(), '\0', ' ');
    text += key + '\0' + value + '\0';
  }
  return text;
}

std::string TakeField(std::string& text) {
  const size_t end = text.find('\0');
  const std::string field = text.substr(0, end);
  text.erase(0, end == std::string::npos ? end : end + 1);
  return field;
}

}  // namespace

absl::Status Error(absl::StatusCode code, const std::string& message, const ErrorDetail& detail) {
  DEMAND(code != absl::StatusCode::kOk);
  absl::Status status(code, message);
  status.SetPayload(kPayloadUrl, absl::Cord(Encode(detail)));
  return status;
}

std::optional<ErrorDetail> GetErrorDetail(const absl::Status& status) {
  const absl::optional<absl::Cord> payload = status.GetPayload(kPayloadUrl);
  if (!payload.has_value()) return std::nullopt;
  std::string text(*payload);
  ErrorDetail detail;
  detail.reason = TakeField(text);
  while (!text.empty()) {
    const std::string key = TakeField(text);
    detail.facts[key] = TakeField(text);
  }
  return detail;
}

std::string ErrorReason(const absl::Status& status) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  return detail.has_value() ? detail->reason : std::string();
}

}  // namespace axiscal::base
