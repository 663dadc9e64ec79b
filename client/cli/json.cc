#include "client/cli/json.h"

#include <nlohmann/json.hpp>

#include "core/base/demand.h"

namespace axiscal::cli {

class JsonDump {
 public:
  static nlohmann::ordered_json Of(const Json& json) {
    nlohmann::ordered_json out =
        json.is_object_ ? nlohmann::ordered_json::object() : std::visit(JsonDump(), json.value_);
    if (!out.is_object()) return out;
    for (const auto& [name, member] : json.members_) out[name] = Of(member);
    return out;
  }

  nlohmann::ordered_json operator()(std::monostate) const { return nullptr; }
  nlohmann::ordered_json operator()(bool value) const { return value; }
  nlohmann::ordered_json operator()(double number) const { return number; }
  nlohmann::ordered_json operator()(const std::variant<int64_t, uint64_t>& number) const {
    return std::visit([](const auto whole) { return nlohmann::ordered_json(whole); }, number);
  }
  nlohmann::ordered_json operator()(const std::string& text) const { return text; }
  nlohmann::ordered_json operator()(const Json::Elements& elements) const {
    nlohmann::ordered_json array = nlohmann::ordered_json::array();
    for (const Json& element : elements) array.push_back(Of(element));
    return array;
  }
  nlohmann::ordered_json operator()(const Json::Text& text) const {
    nlohmann::ordered_json parsed = nlohmann::ordered_json::parse(text.json, nullptr, /*allow_exceptions=*/false);
    return parsed.is_discarded() ? nlohmann::ordered_json(text.json) : parsed;
  }
};

Json::Json(std::initializer_list<std::pair<std::string, Json>> members) : is_object_(true), members_(members) {}

Json Json::Array() {
  Json json;
  json.value_ = Elements();
  return json;
}

Json Json::Object() {
  Json json;
  json.is_object_ = true;
  return json;
}

Json Json::Document(std::string text) {
  Json json;
  json.value_ = Text{std::move(text)};
  return json;
}

void Json::push_back(Json element) {
  Elements* const elements = std::get_if<Elements>(&value_);
  DEMAND(elements != nullptr);
  elements->push_back(std::move(element));
}

Json& Json::operator[](const std::string& name) {
  if (std::holds_alternative<std::monostate>(value_)) is_object_ = true;
  for (auto& [known, member] : members_) {
    if (known == name) return member;
  }
  return members_.emplace_back(name, Json()).second;
}

std::string Json::Dump() const {
  return JsonDump::Of(*this).dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string Json::Line() const {
  return JsonDump::Of(*this).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace axiscal::cli
