// Lists are handed out in pages.
#ifndef AXISCAL_CORE_RECORDS_PAGE_H_
#define AXISCAL_CORE_RECORDS_PAGE_H_

#include <optional>
#include <string>
#include <vector>

#include "core/base/clock.h"

namespace axiscal::records {

// From `from` on, before `to`; what is absent holds nothing off.
struct TimeSpan {
  std::optional<base::UtcTime> from = {}, to = {};
  bool is_all() const { return !from && !to; }
};

struct PageRequest {
  int size = 0;       // 0: 50; at most 1000 are given, fewer where the rows are large
  std::string token;  // from the page before; empty: the first
};

// Pages stay stable: rows made later never shift rows already listed. Newest first, machines by name.
template <typename Row>
struct Page {
  std::vector<Row> rows;
  std::string next_token;  // empty: this was the last page
};

}  // namespace axiscal::records

#endif  // AXISCAL_CORE_RECORDS_PAGE_H_
