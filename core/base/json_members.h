// The members of a struct as JSON, told once for writing and for reading: a function template
//   template <typename Io> void Members(Io& io, base::Like<Io, Step> step) {
//     io.Member("name", step.name);
//     io.Member("rms_um", step.rms_um);
//   }
// in the struct's namespace. With a JsonWriter it writes the members in this order, with a JsonReader it reads them.
// A number that is not finite is written as null, and null reads as NaN. A member that is absent keeps its default,
// because earlier versions wrote fewer; one that is unknown is passed over; one of a wrong kind is an error that names
// it: `errors[2].sigma = "abc", expected a number`. What was written, read and written again is the same text.
// Only readers and writers (the *_json.cc files) include this.
#ifndef AXISCAL_CORE_BASE_JSON_MEMBERS_H_
#define AXISCAL_CORE_BASE_JSON_MEMBERS_H_

#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/json_like.h"
#include "core/base/status.h"
#include "core/base/strict_json.h"

namespace axiscal::base {

// An enumeration has `const char* const* WordsOf(Enum)` in its namespace: its words in the order of its values from 0,
// ended by nullptr. Where the last one is "other", a reader takes every word that it does not know for it: what a newer
// version wrote stays readable.
template <typename E>
concept Worded = std::is_enum_v<E> && requires(E value) { WordsOf(value); };

class JsonWriter {
 public:
  static constexpr bool kReads = false;
  explicit JsonWriter(nlohmann::ordered_json* object) : object_(*object) {}

  template <typename T>
  void Member(const char* key, const T& value) {
    object_[key] = Of(value);
  }
  // Absent where unset.
  template <typename T>
  void Member(const char* key, const std::optional<T>& value) {
    if (value) object_[key] = Of(*value);
  }
  template <typename T>
  void Required(const char* key, const T& value) {
    Member(key, value);
  }
  // Absent where it is `otherwise`.
  template <typename T>
  void Unless(const T& otherwise, const char* key, const T& value) {
    if (value != otherwise) Member(key, value);
  }
  // Absent where empty.
  template <typename T>
  void IfAny(const char* key, const T& list) {
    if (!list.empty()) Member(key, list);
  }
  // The members of `value` among these, absent where unset; its own first member is `key`.
  template <typename T>
  void Flat(const char* key, const std::optional<T>& value) {
    if (value) Members(*this, *value);
  }
  // The same, with `key`: null where unset.
  template <typename T>
  void FlatOrNull(const char* key, const std::optional<T>& value) {
    if (!value) object_[key] = nullptr;
    Flat(key, value);
  }
  // A JSON document as it stands; absent where empty.
  void Document(const char* key, const std::string& text) {
    if (!text.empty()) object_[key] = nlohmann::ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
  }
  // Members that stand in an object of their own: `members` gets its writer.
  template <typename Told>
  void Group(const char* key, const Told& members) {
    Json object = Json::object();
    JsonWriter io(&object);
    members(io);
    object_[key] = std::move(object);
  }
  // What follows from other members: it is not read.
  template <typename T>
  void Derived(const char* key, const T& value) {
    Member(key, value);
  }

 private:
  using Json = nlohmann::ordered_json;

  template <typename T>
  static Json Of(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::same_as<T, std::string>) {
      return Json(value);
    } else if constexpr (Worded<T>) {
      return Json(WordsOf(value)[static_cast<int>(value)]);
    } else {
      Json object = Json::object();
      JsonWriter io(&object);
      Members(io, value);
      return object;
    }
  }
  template <typename T>
  static Json Of(const std::vector<T>& list) {
    Json array = Json::array();
    for (const T& value : list) array.push_back(Of(value));
    return array;
  }
  template <typename T, size_t kSize>
  static Json Of(const std::array<T, kSize>& list) {
    Json array = Json::array();
    for (const T& value : list) array.push_back(Of(value));
    return array;
  }
  template <typename T>
  static Json Of(const Named<T>& members) {
    Json object = Json::object();
    for (const auto& [name, value] : members) object[name] = Of(value);
    return object;
  }

  Json& object_;
};

// Keeps the first error in a status that readers of nested objects share.
class JsonReader {
 public:
  static constexpr bool kReads = true;
  JsonReader(const nlohmann::ordered_json& object, absl::Status* status) : JsonReader(object, {}, status) {}

  template <typename T>
  void Member(const char* key, T& value) {
    const auto found = object_.find(key);
    if (found != object_.end()) Read(*found, {&place_, key}, value);
  }
  template <typename T>
  void Member(const char* key, std::optional<T>& value) {
    value.reset();
    const auto found = object_.find(key);
    if (found != object_.end()) Read(*found, {&place_, key}, value.emplace());
  }
  // Must be there.
  template <typename T>
  void Required(const char* key, T& value) {
    if (!object_.contains(key)) Refuse({&place_, key}, " is missing");
    Member(key, value);
  }
  template <typename T>
  void Unless(const T& otherwise, const char* key, T& value) {
    value = otherwise;
    Member(key, value);
  }
  template <typename T>
  void IfAny(const char* key, T& list) {
    Member(key, list);
  }
  template <typename T>
  void Flat(const char* key, std::optional<T>& value) {
    value.reset();
    const auto found = object_.find(key);
    if (found != object_.end() && !found->is_null()) Members(*this, value.emplace());
  }
  template <typename T>
  void FlatOrNull(const char* key, std::optional<T>& value) {
    Flat(key, value);
  }
  void Document(const char* key, std::string& text) {
    const auto found = object_.find(key);
    text = found == object_.end() ? "" : found->dump();
  }
  template <typename Told>
  void Group(const char* key, const Told& members) {
    const auto found = object_.find(key);
    if (found == object_.end()) return;
    const Place place{&place_, key};
    if (!found->is_object()) return Expect(*found, place, "an object");
    JsonReader io(*found, place, status_);
    members(io);
  }
  template <typename T>
  void Derived(const char*, const T&) {}

 private:
  using Json = nlohmann::ordered_json;

  // Where a value stands: a member, or an entry of a list where `key` is null.
  struct Place {
    const Place* parent = nullptr;
    const char* key = nullptr;
    size_t index = 0;

    std::string Text() const {
      if (parent == nullptr) return "";
      const std::string before = parent->Text();
      if (key == nullptr) return absl::StrCat(before, "[", index, "]");
      return before.empty() ? key : absl::StrCat(before, ".", key);
    }
  };

  JsonReader(const Json& object, const Place& place, absl::Status* status)
      : object_(object), place_(place), status_(status) {}

  void Refuse(const Place& place, const std::string& what) {
    if (status_->ok()) *status_ = absl::InvalidArgumentError(place.Text() + what);
  }
  void Expect(const Json& value, const Place& place, const char* what) {
    Refuse(place, absl::StrCat(" = ", ShortJson(value), ", expected ", what));
  }

  void Read(const Json& json, const Place& place, bool& value) {
    json.is_boolean() ? void(value = json.get<bool>()) : Expect(json, place, "true or false");
  }
  void Read(const Json& json, const Place& place, std::string& value) {
    json.is_string() ? void(value = json.get<std::string>()) : Expect(json, place, "a text");
  }
  void Read(const Json& json, const Place& place, double& value) {
    if (!json.is_number() && !json.is_null()) return Expect(json, place, "a number");
    value = json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
  }
  template <std::integral T>
  void Read(const Json& json, const Place& place, T& value) {
    const bool is_in_range = json.is_number_unsigned()  ? std::in_range<T>(json.get<uint64_t>())
                             : json.is_number_integer() ? std::in_range<T>(json.get<int64_t>())
                                                        : false;
    is_in_range ? void(value = json.get<T>()) : Expect(json, place, "a whole number");
  }
  template <Worded E>
  void Read(const Json& json, const Place& place, E& value) {
    const char* const* const words = WordsOf(value);
    std::string known;
    for (int i = 0; words[i] != nullptr; ++i) {
      if (json.is_string() && json.get_ref<const std::string&>() == words[i]) return void(value = static_cast<E>(i));
      if (json.is_string() && words[i + 1] == nullptr && std::string_view(words[i]) == "other")
        return void(value = static_cast<E>(i));
      absl::StrAppend(&known, i == 0 ? "" : ", ", words[i]);
    }
    Expect(json, place, ("one of " + known).c_str());
  }
  template <typename T>
  void Read(const Json& json, const Place& place, std::vector<T>& list) {
    if (!json.is_array()) return Expect(json, place, "a list");
    list.clear();
    list.reserve(json.size());
    for (size_t i = 0; i < json.size(); ++i) {
      T value{};
      Read(json[i], {&place, nullptr, i}, value);
      list.push_back(std::move(value));
    }
  }
  template <typename T, size_t kSize>
  void Read(const Json& json, const Place& place, std::array<T, kSize>& list) {
    if (!json.is_array() || json.size() != kSize)
      return Expect(json, place, absl::StrCat("a list of ", kSize, " values").c_str());
    for (size_t i = 0; i < kSize; ++i) Read(json[i], {&place, nullptr, i}, list[i]);
  }
  template <typename T>
  void Read(const Json& json, const Place& place, Named<T>& members) {
    if (!json.is_object()) return Expect(json, place, "an object");
    members.clear();
    for (const auto& [name, member] : json.items()) {
      T value{};
      Read(member, {&place, name.c_str()}, value);
      members.emplace_back(name, std::move(value));
    }
  }
  template <typename T>
    requires std::is_class_v<T>
  void Read(const Json& json, const Place& place, T& value) {
    if (!json.is_object()) return Expect(json, place, "an object");
    JsonReader io(json, place, status_);
    Members(io, value);
  }

  const Json& object_;
  const Place place_;
  absl::Status* const status_;
};

// `value` as an object, a line per member; never fails: what is no UTF-8 is replaced.
template <typename T>
std::string WriteMembers(const T& value) {
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  JsonWriter io(&object);
  Members(io, value);
  return object.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

// INVALID_ARGUMENT where `object` is none, or naming the member that is wrong.
template <typename T>
absl::StatusOr<T> ReadMembers(const nlohmann::ordered_json& object) {
  if (!object.is_object()) return absl::InvalidArgumentError(ShortJson(object) + ", expected an object");
  T value;
  absl::Status status;
  JsonReader io(object, &status);
  Members(io, value);
  if (!status.ok()) return status;
  return value;
}

}  // namespace axiscal::base

#endif  // AXISCAL_CORE_BASE_JSON_MEMBERS_H_
