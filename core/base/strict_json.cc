#include "core/base/strict_json.h"

#include <set>
#include <vector>

namespace axiscal::base {
namespace {

using Json = nlohmann::ordered_json;

// "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error ..." without the library's own words.
std::string PlainMessage(const std::string& what) {
  std::string text = what.substr(what.find("] ") + 2);
  const std::string start = "parse error at ";
  if (text.compare(0, start.size(), start) == 0) text.erase(0, start.size());
  return text;
}

}  // namespace

absl::StatusOr<Json> ParseStrictJson(const std::string& text, size_t max_bytes) {
  if (text.empty()) return absl::InvalidArgumentError("is empty, expected a JSON object");
  if (text.size() > max_bytes) {
    return absl::InvalidArgumentError(absl::StrCat(text.size(), " bytes, at most ", max_bytes, " are read"));
  }
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::string problem;
  const auto watch = [&keys, &problem](int depth, Json::parse_event_t event, Json& parsed) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(parsed.get<std::string>()).second && problem.empty()) {
      problem = absl::StrCat("'", parsed.get<std::string>(), "' is there twice");
    }
    if (depth > kMaxJsonDepth && problem.empty()) {
      problem = absl::StrCat("nested deeper than ", kMaxJsonDepth, " levels");
    }
    return true;
  };
  Json document;
  try {
    document = Json::parse(text, watch);
  } catch (const Json::exception& error) {
    return absl::InvalidArgumentError(PlainMessage(error.what()));
  }
  if (!problem.empty()) return absl::InvalidArgumentError(problem);
  return document;
}

absl::Status CheckJson(const std::string& text) { return ParseStrictJson(text).status(); }

std::string ShortJson(const Json& value) {
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

}  // namespace axiscal::base
