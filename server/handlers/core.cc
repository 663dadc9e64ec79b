#include "server/handlers/core.h"

#include "core/base/error_detail.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {

bool IsTraceParent(const std::string& text) {
  if (text.size() != 55) return false;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool is_dash = i == 2 || i == 35 || i == 52;
    const bool is_digit = (text[i] >= '0' && text[i] <= '9') || (text[i] >= 'a' && text[i] <= 'f');
    if (is_dash ? text[i] != '-' : !is_digit) return false;
  }
  return true;
}

absl::StatusOr<storage::Caller> ByWithReason(const Call& call, const std::string& reason) {
  constexpr size_t kMaxReasonBytes = 200;  // a sentence
  RETURN_IF_ERROR(convert::RequireText("reason", reason, 0, kMaxReasonBytes));
  storage::Caller caller = call.By();
  caller.reason = reason;
  return caller;
}

absl::Status RequireAccepting(const Core& core) {
  if (!core.draining) return absl::OkStatus();
  return base::Error(absl::StatusCode::kUnavailable, "the server is stopping and takes no new work", {"DRAINING", {}});
}

absl::StatusOr<records::PageRequest> PageFrom(int page_size, const std::string& page_token) {
  if (page_size < 0) {
    return base::Error(absl::StatusCode::kInvalidArgument, absl::StrCat("page_size: ", page_size, ", must be >= 0"),
                       {"PAGE_INVALID", {{"field", "page_size"}, {"rule", "must be >= 0"}}});
  }
  return records::PageRequest{page_size, page_token};
}

absl::Status RequireSpan(const records::TimeSpan& span) {
  if (!span.from || !span.to || *span.from < *span.to) return absl::OkStatus();
  return base::Error(absl::StatusCode::kInvalidArgument, "from_utc_us: must be before to_utc_us",
                     {"RANGE_INVALID", {{"field", "from_utc_us"}, {"rule", "must be before to_utc_us"}}});
}

absl::Status RequireRequestId(const std::string& request_id) {
  return convert::RequireText("request_id", request_id, 1, kMaxRequestIdBytes);
}

}  // namespace axiscal::handlers
