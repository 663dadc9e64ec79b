#include "core/nc/mark.h"

#include "absl/strings/str_format.h"

namespace axiscal::nc {
namespace {
constexpr char kMark[] = "AXISCAL COMPENSATED";
}

bool HasMark(const char* begin, const char* end) {
  while (begin != end && (*begin == ' ' || *begin == '\t')) ++begin;
  for (const char* expected = kMark; *expected != 0; ++expected, ++begin) {
    if (begin == end) return false;
    const char capital = *begin >= 'a' && *begin <= 'z' ? static_cast<char>(*begin - 'a' + 'A') : *begin;
    if (capital != *expected) return false;
  }
  return true;
}

std::string MarkComment(const Dialect& dialect, const std::string& calibration, uint32_t source_crc32c) {
  const std::string text = absl::StrFormat("%s BY %s SOURCE CRC32C %08X", kMark, calibration, source_crc32c);
  return dialect.has_parenthesis_comments ? "(" + text + ")" : std::string(1, dialect.line_comment) + text;
}

}  // namespace axiscal::nc
