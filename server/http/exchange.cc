#include "server/http/exchange.h"

#include "absl/strings/ascii.h"
#include "absl/strings/str_split.h"

namespace axiscal::http {
namespace {

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

}  // namespace

std::optional<std::string> PercentDecoded(const std::string& text) {
  std::string decoded;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    const int high = i + 2 < text.size() ? HexDigit(text[i + 1]) : -1;
    const int low = i + 2 < text.size() ? HexDigit(text[i + 2]) : -1;
    if (high < 0 || low < 0) return std::nullopt;
    decoded += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return decoded;
}

bool SplitTarget(const std::string& target, std::string* path, std::map<std::string, std::string>* query) {
  if (target.empty() || target[0] != '/') return false;
  const size_t question = target.find('?');
  *path = target.substr(0, question);
  if (question == std::string::npos) return true;
  for (const std::string& pair : Words(target.substr(question + 1), '&')) {
    if (pair.empty()) continue;
    const size_t equals = pair.find('=');
    const auto name = PercentDecoded(pair.substr(0, equals));
    const auto value = PercentDecoded(equals == std::string::npos ? "" : pair.substr(equals + 1));
    if (!name || !value) return false;
    (*query)[*name] = *value;
  }
  return true;
}

std::vector<std::string> Words(const std::string& text, char separator) {
  std::vector<std::string> words;
  for (absl::string_view word : absl::StrSplit(text, separator)) words.emplace_back(absl::StripAsciiWhitespace(word));
  return words;
}

}  // namespace axiscal::http
