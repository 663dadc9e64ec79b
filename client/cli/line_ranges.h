// Ranges of a program's lines in a report's text.
#ifndef AXISCAL_CLIENT_CLI_LINE_RANGES_H_
#define AXISCAL_CLIENT_CLI_LINE_RANGES_H_

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "core/reports/rewrite.h"

namespace axiscal::cli {

// "not corrected: 2 ranges of lines" and the first of them, a line each; "" where there is none.
inline std::string LineRangesText(const std::string& what, const std::vector<reports::LineRange>& ranges,
                                  int64_t count) {
  constexpr size_t kShown = 5;
  if (count == 0) return "";
  std::string text = absl::StrCat(what, ": ", count, count == 1 ? " range" : " ranges", " of lines\n");
  for (size_t i = 0; i < ranges.size() && i < kShown; ++i) {
    const reports::LineRange& range = ranges[i];
    absl::StrAppend(&text, range.first == range.last ? "  line " : "  lines ", range.first);
    if (range.first != range.last) absl::StrAppend(&text, " to ", range.last);
    absl::StrAppend(&text, ": ", range.reason, "\n");
  }
  if (count > static_cast<int64_t>(kShown)) absl::StrAppend(&text, "  ... more in the report\n");
  return text;
}

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_LINE_RANGES_H_
