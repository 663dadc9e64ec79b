#include "server/storage/page_token.h"

#include <algorithm>

#include "absl/strings/escaping.h"
#include "core/base/crc32c.h"
#include "core/base/error_detail.h"

namespace axiscal::storage {
namespace {

constexpr int kDefaultSize = 50;
constexpr int kMaxSize = 1000;
constexpr size_t kChecksumDigits = 8;

absl::Status Invalid(const std::string& message) {
  return base::Error(absl::StatusCode::kInvalidArgument, message, {"PAGE_INVALID", {}});
}

std::string Checksum(const std::string& list, const std::string& key) {
  const std::string text = list + '\0' + key;
  return absl::StrFormat("%08x", base::Crc32c(0, text.data(), text.size()));
}

}  // namespace

absl::StatusOr<PageStart> StartPage(const PageRequest& request, const std::string& list) {
  if (request.size < 0) return Invalid(absl::StrCat("page size = ", request.size, ", must be >= 0"));
  PageStart start;
  start.list = list;
  start.size = request.size == 0 ? kDefaultSize : std::min(request.size, kMaxSize);
  if (request.token.empty()) return start;
  std::string token;
  if (!absl::WebSafeBase64Unescape(request.token, &token) || token.size() < kChecksumDigits) {
    return Invalid("page token is not one that a list has given");
  }
  const std::string key = token.substr(kChecksumDigits);
  if (token.substr(0, kChecksumDigits) != Checksum(list, key)) {
    return Invalid("page token belongs to another list or filter");
  }
  start.after = key;
  return start;
}

std::string MakePageToken(const PageStart& start, const std::string& last_key) {
  return absl::WebSafeBase64Escape(Checksum(start.list, last_key) + last_key);
}

}  // namespace axiscal::storage
