#include "core/session/text.h"

#include <charconv>
#include <cmath>

#include "absl/time/time.h"
#include "core/base/status.h"

namespace axiscal::session {
namespace {

// Bytes of the well-formed UTF-8 character at `at`, or 0 (RFC 3629: no overlong forms, no surrogates, at most
// U+10FFFF).
size_t CharacterBytes(const std::string& text, size_t at) {
  const auto byte = [&text](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto follows = [&byte](size_t i) { return (byte(i) & 0xC0u) == 0x80u; };
  const unsigned first = byte(at);
  if (first < 0x80) return 1;
  if (first >= 0xC2 && first <= 0xDF) return follows(at + 1) ? 2 : 0;
  if (first >= 0xE0 && first <= 0xEF) {
    const unsigned second = byte(at + 1);
    const bool bad = (first == 0xE0 && second < 0xA0) || (first == 0xED && second > 0x9F);
    return !bad && follows(at + 1) && follows(at + 2) ? 3 : 0;
  }
  if (first >= 0xF0 && first <= 0xF4) {
    const unsigned second = byte(at + 1);
    const bool bad = (first == 0xF0 && second < 0x90) || (first == 0xF4 && second > 0x8F);
    return !bad && follows(at + 1) && follows(at + 2) && follows(at + 3) ? 4 : 0;
  }
  return 0;
}

}  // namespace

bool IsPlainText(const std::string& text) {
  for (size_t at = 0; at < text.size();) {
    const unsigned char byte = static_cast<unsigned char>(text[at]);
    if ((byte < 0x20 && byte != '\t') || byte == 0x7F) return false;
    const size_t bytes = CharacterBytes(text, at);
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
