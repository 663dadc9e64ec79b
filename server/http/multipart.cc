#include "server/http/multipart.h"

#include <optional>

#include "absl/strings/ascii.h"
#include "core/base/error_detail.h"
#include "server/http/exchange.h"

namespace axiscal::http {
namespace {

constexpr size_t kMostParts = 16;

absl::Status NoForm(const std::string& what) {
  return base::Error(absl::StatusCode::kInvalidArgument, "the body is no form (multipart/form-data): " + what,
                     {"MESSAGE_INVALID", {}});
}

// The value of `name=` behind a ';', with or without quotes.
std::optional<std::string> ParameterOf(const std::string& field, const std::string& name) {
  for (size_t at = field.find(';'); at != std::string::npos;) {
    ++at;
    while (at < field.size() && field[at] == ' ') ++at;
    const size_t equals = field.find('=', at);
    if (equals == std::string::npos) return std::nullopt;
    const bool is_it = absl::AsciiStrToLower(field.substr(at, equals - at)) == name;
    std::string value;
    at = equals + 1;
    if (at < field.size() && field[at] == '"') {
      for (++at; at < field.size() && field[at] != '"'; ++at) {
        if (field[at] == '\\' && at + 1 < field.size()) ++at;
        value += field[at];
      }
      if (at >= field.size()) return std::nullopt;
      at = field.find(';', at);
    } else {
      const size_t end = field.find(';', at);
      value = field.substr(at, end == std::string::npos ? end : end - at);
      at = end;
    }
    if (is_it) return value;
  }
  return std::nullopt;
}

// Of the lines above a part.
std::string FieldOf(const std::string& head, const std::string& name) {
  for (size_t at = 0; at < head.size();) {
    const size_t end = std::min(head.find("\r\n", at), head.size());
    const std::string line = head.substr(at, end - at);
    const size_t colon = line.find(':');
    if (colon != std::string::npos && absl::AsciiStrToLower(line.substr(0, colon)) == name)
      return line.substr(colon + 1);
    at = end + 2;
  }
  return "";
}

}  // namespace

absl::StatusOr<std::map<std::string, FormPart>> ReadMultipart(const std::string& content_type,
                                                              const std::string& body) {
  const std::vector<std::string> words = Words(content_type, ';');
  if (words.empty() || absl::AsciiStrToLower(words[0]) != "multipart/form-data")
    return NoForm("Content-Type is '" + content_type + "'");
  const std::string boundary = ParameterOf(content_type, "boundary").value_or("");
  if (boundary.empty() || boundary.size() > 70) return NoForm("no boundary in its Content-Type");
  const std::string mark = "--" + boundary;
  if (body.rfind(mark, 0) != 0) return NoForm("it does not begin with its boundary");
  std::map<std::string, FormPart> parts;
  for (size_t at = mark.size();;) {
    if (body.compare(at, 2, "--") == 0) return parts;
    const size_t begin = body.compare(at, 2, "\r\n") == 0 ? at + 2 : std::string::npos;
    const size_t blank = begin == std::string::npos ? begin : body.find("\r\n\r\n", begin);
    const size_t end = blank == std::string::npos ? blank : body.find("\r\n" + mark, blank + 4 - 2);
    if (end == std::string::npos) return NoForm("it has no end");
    const std::string disposition = FieldOf(body.substr(begin, blank - begin), "content-disposition");
    const std::optional<std::string> name = ParameterOf(disposition, "name");
    if (!name || name->empty()) return NoForm("a part without a name");
    FormPart part;
    part.file = ParameterOf(disposition, "filename").value_or("");
    part.file.erase(0, part.file.find_last_of("/\\") + 1);  // npos + 1 is 0
    part.text = end >= blank + 4 ? body.substr(blank + 4, end - blank - 4) : "";
    if (parts.size() >= kMostParts) return NoForm(absl::StrCat("more than ", kMostParts, " parts"));
    if (!parts.emplace(*name, std::move(part)).second) return NoForm("'" + *name + "' twice");
    at = end + 2 + mark.size();
  }
}

}  // namespace axiscal::http
