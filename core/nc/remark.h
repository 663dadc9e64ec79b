// What the reader of a report must know of a rewriting that nothing of it is refused for.
#ifndef AXISCAL_CORE_NC_REMARK_H_
#define AXISCAL_CORE_NC_REMARK_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"

namespace axiscal::nc {

struct Remark {
  std::string kind;  // a stable name (docs/formats.md), by which a program tells them apart: "tool-change"
  std::string text;
  int64_t line = 0;  // of the source, from 1; 0: it is about none
};

// "line 7: " and the text.
inline Remark RemarkAt(int64_t line, std::string kind, const std::string& text) {
  return {std::move(kind), absl::StrCat("line ", line, ": ", text), line};
}

inline std::vector<std::string> TextsOf(const std::vector<Remark>& remarks) {
  std::vector<std::string> texts;
  texts.reserve(remarks.size());
  for (const Remark& remark : remarks) texts.push_back(remark.text);
  return texts;
}

}  // namespace axiscal::nc

#endif  // AXISCAL_CORE_NC_REMARK_H_
