#include "server/storage/page_token.h"

#include <algorithm>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "core/base/crc32c.h"
#include "core/base/error_detail.h"

namespace axiscal::storage {
namespace {

constexpr int kDefaultSize = 50;
constexpr int kMaxSize = 1000;
constexpr size_t kChecksumDigits = 8;

absl::Status Invalid(const std::string& field, const std::string& rule) {
  return base::Error(absl::StatusCode::kInvalidArgument, field + ": " + rule,
                     {"PAGE_INVALID", {{"field", field}, {"rule", rule}}});
}

std::string Checksum(const std::string& list, const std::string& key) {
  const std::string text = list + '\0' + key;
  return absl::StrFormat("%08x", base::Crc32c(0, text.data(), text.size()));
}

}  // namespace

absl::StatusOr<PageStart> StartPage(const PageRequest& request, const std::string& list) {
  if (request.size < 0) return Invalid("page_size", absl::StrCat(request.size, ", must be >= 0"));
  PageStart start;
  start.list = list;
  start.size = request.size == 0 ? kDefaultSize : std::min(request.size, kMaxSize);
  if (request.token.empty()) return start;
  std::string token;
  if (!absl::WebSafeBase64Unescape(request.token, &token) || token.size() < kChecksumDigits) {
    return Invalid("page_token", "is not one that a list has given");
  }
  const std::string key = token.substr(kChecksumDigits);
  if (token.substr(0, kChecksumDigits) != Checksum(list, key)) {
    return Invalid("page_token", "belongs to another list or filter");
  }
  start.after = key;
  return start;
}

absl::StatusOr<PageStart> StartPageById(const PageRequest& request, const std::string& list) {
  ASSIGN_OR_RETURN(PageStart start, StartPage(request, list));
  if (!start.after.has_value()) return start;
  const bool is_number = absl::SimpleAtoi(*start.after, &start.before_id) && start.before_id > 0;
  if (!is_number || *start.after != std::to_string(start.before_id)) {
    return Invalid("page_token", "is not one that a list has given");
  }
  return start;
}

std::string MakePageToken(const PageStart& start, const std::string& last_key) {
  return absl::WebSafeBase64Escape(Checksum(start.list, last_key) + last_key);
}

}  // namespace axiscal::storage
