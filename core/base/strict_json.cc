#include "core/base/strict_json.h"

#include <set>
#include <utility>
#include <vector>

#include "core/base/utf8.h"

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

// Builds the document from the parser's events. The library's own builder looks for every key among all that the object
// has already, which takes 9 s for 848 KB of keys; here an object is made when its end is seen, each value moved once.
// After a problem the text is only read on, for its syntax.
class Builder final : public nlohmann::json_sax<Json> {
 public:
  bool null() override { return Add(nullptr); }
  bool boolean(bool value) override { return Add(value); }
  bool number_integer(number_integer_t value) override { return Add(value); }
  bool number_unsigned(number_unsigned_t value) override { return Add(value); }
  bool number_float(number_float_t value, const string_t&) override { return Add(value); }
  bool string(string_t& value) override { return Add(std::move(value)); }
  bool binary(binary_t&) override { return Add(nullptr); }  // no JSON text has any
  bool start_object(size_t) override { return Open(/*is_object=*/true); }
  bool end_object() override { return Close(); }
  bool start_array(size_t) override { return Open(/*is_object=*/false); }
  bool end_array() override { return Close(); }

  bool key(string_t& name) override {
    if (!problem_.empty()) return true;
    if (open_.size() > kMaxJsonDepth) return TooDeep();
    if (!open_.back().known.insert(name).second) return Refuse(absl::StrCat("'", name, "' is there twice"));
    open_.back().keys.push_back(std::move(name));
    return true;
  }
  bool parse_error(size_t, const std::string&, const nlohmann::json::exception& error) override {
    syntax_error_ = PlainMessage(error.what());
    return false;
  }

  absl::StatusOr<Json> Take() {
    if (!syntax_error_.empty()) return absl::InvalidArgumentError(syntax_error_);
    if (!problem_.empty()) return absl::InvalidArgumentError(problem_);
    return std::move(root_);
  }

 private:
  // An object or array whose end has not come.
  struct Level {
    bool is_object = false;
    std::vector<std::string> keys;  // of an object: as many as values, or one more
    std::vector<Json> values;
    std::set<std::string> known;  // the keys, sorted: no choice of keys makes the search slow
  };

  bool Refuse(const std::string& problem) {
    problem_ = problem;
    open_.clear();
    return true;
  }

  bool TooDeep() { return Refuse(absl::StrCat("nested deeper than ", kMaxJsonDepth, " levels")); }

  bool Add(Json value) {
    if (!problem_.empty()) return true;
    if (open_.size() > kMaxJsonDepth) return TooDeep();
    (open_.empty() ? root_ : open_.back().values.emplace_back()) = std::move(value);
    return true;
  }

  bool Open(bool is_object) {
    if (!problem_.empty()) return true;
    if (open_.size() > kMaxJsonDepth) return TooDeep();
    open_.emplace_back().is_object = is_object;
    return true;
  }

  bool Close() {
    if (!problem_.empty()) return true;
    Level level = std::move(open_.back());
    open_.pop_back();
    if (!level.is_object) return Add(Json(std::move(level.values)));
    Json::object_t members;
    members.reserve(level.keys.size());
    for (size_t i = 0; i < level.keys.size(); ++i) {
      members.emplace_back(std::move(level.keys[i]), std::move(level.values[i]));
    }
    return Add(Json(std::move(members)));
  }

  std::vector<Level> open_;
  Json root_;
  std::string problem_, syntax_error_;
};

}  // namespace

absl::StatusOr<Json> ParseStrictJson(const std::string& text, size_t max_bytes) {
  if (text.empty()) return absl::InvalidArgumentError("is empty, expected a JSON object");
  if (text.size() > max_bytes) {
    return absl::InvalidArgumentError(absl::StrCat(text.size(), " bytes, at most ", max_bytes, " are read"));
  }
  Builder builder;
  Json::sax_parse(text, &builder);
  return builder.Take();
}

absl::Status CheckJson(const std::string& text) { return ParseStrictJson(text).status(); }

std::string ShortJson(const Json& value) {
  const std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() <= 60) return text;
  size_t end = 0;  // no character is cut in two
  for (size_t next = 0; next <= 57; next += Utf8Bytes(text, next)) end = next;
  return text.substr(0, end) + "...";
}

}  // namespace axiscal::base
