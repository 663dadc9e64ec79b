// Keyset paging: a page starts after the last key of the page before. The token holds that key and what was listed, so
// that it cannot be used for another list, and a checksum, so that it cannot be made up.
#ifndef AXISCAL_SERVER_STORAGE_PAGE_TOKEN_H_
#define AXISCAL_SERVER_STORAGE_PAGE_TOKEN_H_

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

  // The same for lists by falling number.
  int64_t before_id() const { return after.has_value() ? std::stoll(*after) : std::numeric_limits<int64_t>::max(); }
  // Rows to ask for: one more than the page has, to see whether another page follows.
  int64_t row_limit() const { return size + 1; }
};

// INVALID_ARGUMENT PAGE_INVALID for a negative size or a token of another list.
absl::StatusOr<PageStart> StartPage(const PageRequest& request, const std::string& list);

std::string MakePageToken(const PageStart& start, const std::string& last_key);

// Cuts the extra row off and names the page that follows. `key` gives a row's key as text.
template <typename Row, typename Key>
void EndPage(const PageStart& start, const Key& key, Page<Row>& page) {
  if (page.rows.size() <= static_cast<size_t>(start.size)) return;
  page.rows.resize(start.size);
  page.next_token = MakePageToken(start, key(page.rows.back()));
}

}  // namespace axiscal::storage

#endif  // AXISCAL_SERVER_STORAGE_PAGE_TOKEN_H_
