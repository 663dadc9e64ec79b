#include "core/session/text.h"

#include <charconv>
#include <cmath>

#include "absl/time/time.h"
#include "core/base/status.h"
#include "core/base/utf8.h"

namespace axiscal::session {
bool IsPlainText(const std::string& text) {
  for (size_t at = 0; at < text.size();) {
    const unsigned char byte = static_cast<unsigned char>(text[at]);
    if ((byte < 0x20 && byte != '\t') || byte == 0x7F) return false;
    const size_t bytes = base::Utf8Bytes(text, at);
    if (bytes == 0) return false;
    at += bytes;
  }
  return true;
}

std::string Printable(const std::string& text) {
  constexpr size_t kShown = 40;
  std::string printable;
  for (size_t i = 0; i < text.size() && i < kShown; ++i) {
    const unsigned char byte = static_cast<unsigned char>(text[i]);
    if (byte >= 0x20 && byte < 0x7F) {
      printable += text[i];
    } else {
      absl::StrAppendFormat(&printable, "\\x%02X", byte);
    }
  }
  return text.size() > kShown ? printable + "..." : printable;
}

std::string Quoted(const std::string& text) { return "'" + Printable(text) + "'"; }

bool ParseNumbers(const std::string& text, std::vector<double>* numbers) {
  numbers->clear();
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    if (*at == ' ' || *at == '\t') {
      ++at;
      continue;
    }
    double number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    if (error != std::errc() || !std::isfinite(number)) return false;
    if (next != end && *next != ' ' && *next != '\t') return false;
    numbers->push_back(number);
    at = next;
  }
  return true;
}

std::optional<base::UtcTime> ParseIso8601(const std::string& text) {
  // Abseil would also take "infinite-future" and blanks around.
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (text.empty() || text.size() > 40 || !is_digit(text.front()) || text.back() == ' ') return std::nullopt;
  absl::Time time;
  std::string error;
  for (const char* format :
       {"%Y-%m-%d%ET%H:%M:%E*S%Ez", "%Y-%m-%d%ET%H:%M:%E*S", "%Y-%m-%d%ET%H:%M%Ez", "%Y-%m-%d%ET%H:%M",
        "%Y-%m-%d %H:%M:%E*S%Ez", "%Y-%m-%d %H:%M:%E*S", "%Y-%m-%d %H:%M", "%Y-%m-%d"}) {
    if (absl::ParseTime(format, text, &time, &error)) return base::FromUtcUs(absl::ToUnixMicros(time));
  }
  return std::nullopt;
}

}  // namespace axiscal::session
