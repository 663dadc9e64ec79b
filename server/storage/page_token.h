// Keyset paging: a page starts after the last key of the page before. The token holds that key and what was listed, so
// that it cannot be used for another list, and a checksum against mistakes. The checksum has no secret: whoever makes a
// token up may name any key, so every reader of a key must take any.
#ifndef AXISCAL_SERVER_STORAGE_PAGE_TOKEN_H_
#define AXISCAL_SERVER_STORAGE_PAGE_TOKEN_H_

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "core/base/status.h"
#include "server/storage/records.h"

namespace axiscal::storage {

struct PageStart {
  std::string list;  // what is listed, with its filter
  int size = 0;
  std::optional<std::string> after;  // the last key given

  int64_t before_id = std::numeric_limits<int64_t>::max();  // the same for lists by falling number
  // Rows to ask for: one more than the page has, to see whether another page follows.
  int64_t row_limit() const { return size + 1; }
};

// A page holds no more than this, so that it fits into one message of the API (4 MB); its first row always.
inline constexpr size_t kMaxPageBytes = size_t{2} << 20;

// Of a list by rising text. INVALID_ARGUMENT PAGE_INVALID, with the field, for a negative size or a token of another
// list.
absl::StatusOr<PageStart> StartPage(const PageRequest& request, const std::string& list);
// Of a list by falling number; a token without a number is as invalid.
absl::StatusOr<PageStart> StartPageById(const PageRequest& request, const std::string& list);

std::string MakePageToken(const PageStart& start, const std::string& last_key);

// Cuts off the extra row and what does not fit, and names the page that follows. `key` gives a row's key as text,
// `bytes` about how long its texts are.
template <typename Row, typename Key, typename Bytes>
void EndPage(const PageStart& start, const Key& key, const Bytes& bytes, Page<Row>& page) {
  constexpr size_t kRowBytes = 250;  // what a row takes beside its texts
  size_t kept = 0, total = 0;
  while (kept < page.rows.size() && kept < static_cast<size_t>(start.size)) {
    total += kRowBytes + bytes(page.rows[kept]);
    if (kept > 0 && total > kMaxPageBytes) break;
    ++kept;
  }
  if (kept == page.rows.size()) return;
  page.rows.resize(kept);
  page.next_token = MakePageToken(start, key(page.rows.back()));
}

// Of a list by falling number that has looked down to `last` and no farther: the page that follows goes on there.
template <typename Row>
void GoOnBelow(const PageStart& start, const std::optional<int64_t>& last, Page<Row>& page) {
  if (last.has_value() && page.next_token.empty()) page.next_token = MakePageToken(start, std::to_string(*last));
}

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_PAGE_TOKEN_H_
