// axiscald.toml: its values (core/base/toml.h) into settings.
#include <algorithm>
#include <filesystem>

#include "core/base/toml.h"
#include "server/config.h"
#include "server/storage/postgres_url.h"

namespace axiscal::server {
namespace {

using base::TomlValue;

absl::Status Refuse(const TomlValue& value, const std::string& text) {
  return absl::InvalidArgumentError(absl::StrCat(value.place, ": ", text));
}

// "listen, drain_seconds" of "server"; the tables of "".
std::string KeysBelow(const std::string& table) {
  std::vector<std::string> names;
  const std::string start = table.empty() ? "" : table + ".";
  for (const Setting& setting : Settings()) {
    if (setting.key.rfind(start, 0) != 0) continue;
    const std::string name = setting.key.substr(start.size(), setting.key.find('.', start.size()) - start.size());
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  std::string text;
  for (const std::string& name : names) absl::StrAppend(&text, text.empty() ? "" : ", ", name);
  return text;
}

absl::Status ReadValue(const Setting& setting, const TomlValue& value, const std::string& path, Configured& read) {
  const auto wrong = [&](const std::string& rule) { return Refuse(value, setting.key + " must be " + rule); };
  if (std::holds_alternative<std::string Config::*>(setting.field)) {
    if (!std::holds_alternative<std::string>(value.value)) return wrong("a text in quotes");
    std::string text = std::get<std::string>(value.value);
    if (setting.is_path && !text.empty() && !storage::IsPostgresUrl(text))
      text = (std::filesystem::path(path).parent_path() / text).string();
    return SetText(setting, text, value.place, read);
  }
  if (setting.is_switch()) {
    if (!std::holds_alternative<bool>(value.value)) return wrong("true or false, without quotes");
    return SetText(setting, std::get<bool>(value.value) ? "true" : "false", value.place, read);
  }
  if (!std::holds_alternative<int64_t>(value.value))
    return wrong(absl::StrCat("a whole number of ", setting.least, " to ", setting.most, ", without quotes"));
  return SetText(setting, absl::StrCat(std::get<int64_t>(value.value)), value.place, read);
}

}  // namespace

absl::Status ReadToml(const std::string& text, const std::string& path, Configured& configured) {
  Configured read = configured;
  ASSIGN_OR_RETURN(const std::vector<TomlValue> values, base::ReadTomlValues(text, path));
  for (const TomlValue& value : values) {
    const auto setting =
        std::find_if(Settings().begin(), Settings().end(), [&](const Setting& one) { return one.key == value.key; });
    const size_t point = value.key.rfind('.');
    const std::string table = point == std::string::npos ? "" : value.key.substr(0, point);
    if (setting != Settings().end()) {
      RETURN_IF_ERROR(ReadValue(*setting, value, path, read));
    } else if (const std::string known = KeysBelow(value.key); known.empty()) {
      return Refuse(value, absl::StrCat("unknown key ", value.key, "; known ", table.empty() ? "tables" : "keys",
                                        " here: ", KeysBelow(table)));
    } else if (!std::holds_alternative<base::TomlTable>(value.value)) {
      return Refuse(value, absl::StrCat(value.key, " must be a table with the keys ", known));
    }
  }
  configured = std::move(read);
  return absl::OkStatus();
}

}  // namespace axiscal::server
