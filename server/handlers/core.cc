#include "server/handlers/core.h"

#include "core/base/error_detail.h"
#include "proto/convert/field.h"

namespace axiscal::handlers {

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

absl::Status RequireRequestId(const std::string& request_id) {
  return convert::RequireText("request_id", request_id, 1, 64);
}

}  // namespace axiscal::handlers
