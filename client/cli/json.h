// A JSON document to print: it is put together and written, never searched. What is read comes through the readers of
// core/reports and of the formats.
#ifndef AXISCAL_CLIENT_CLI_JSON_H_
#define AXISCAL_CLIENT_CLI_JSON_H_

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace axiscal::cli {

class Json {
 public:
  // Values; conversions are implicit so that documents read like JSON.
  Json() = default;  // null
  Json(std::nullptr_t) {}
  Json(bool value) : value_(std::in_place_type<bool>, value) {}
  Json(double number) : value_(std::in_place_type<double>, number) {}  // null where it is not finite
  template <std::integral T>
  requires(!std::same_as<T, bool>) Json(T number) : value_(Whole(number)) {}
  Json(const char* text) : value_(std::string(text)) {}
  Json(std::string text) : value_(std::move(text)) {}
  template <typename T>
  Json(const std::vector<T>& list) : value_(Elements(list.begin(), list.end())) {}
  // An object: {{"name", value}, ...}, members in this order.
  Json(std::initializer_list<std::pair<std::string, Json>> members);

  static Json Array();
  static Json Object();
  // The text as the JSON document that it is, or as a text where it is none.
  static Json Document(std::string text);

  // Of arrays.
  void push_back(Json element);
  // Of objects, and of documents that are objects: the member, made where it is missing.
  Json& operator[](const std::string& name);

  // Every member and element on a line of its own; what is no UTF-8 is replaced.
  std::string Dump() const;
  // The same on one line.
  std::string Line() const;

 private:
  friend class JsonDump;
  struct Text {
    std::string json;
  };
  using Elements = std::vector<Json>;

  template <std::integral T>
  static std::variant<int64_t, uint64_t> Whole(T number) {
    if constexpr (std::signed_integral<T>) return static_cast<int64_t>(number);
    return static_cast<uint64_t>(number);
  }

  std::variant<std::monostate, bool, double, std::variant<int64_t, uint64_t>, std::string, Elements, Text> value_;
  bool is_object_ = false;
  std::vector<std::pair<std::string, Json>> members_;  // of an object; beside a document's own
};

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_JSON_H_
