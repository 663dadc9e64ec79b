// axiscald.toml as the library toml++ reads it. It is included here alone, without exceptions.
#define TOML_EXCEPTIONS 0
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

#include <algorithm>
#include <filesystem>

#include "server/config.h"

namespace axiscal::server {
namespace {

class Reader {
 public:
  Reader(const std::string& path, Configured& configured) : path_(path), configured_(configured) {}

  // `name` of the table is empty at the top.
  absl::Status ReadTable(const toml::table& table, const std::string& name) {
    for (const auto& [key, node] : table) {
      const std::string full = name.empty() ? std::string(key.str()) : name + "." + std::string(key.str());
      const auto setting =
          std::find_if(Settings().begin(), Settings().end(), [&](const Setting& one) { return one.key == full; });
      if (setting != Settings().end()) {
        RETURN_IF_ERROR(ReadValue(*setting, node));
      } else if (const std::string known = KeysBelow(full); known.empty()) {
        return Refuse(key.source(), absl::StrCat("unknown key ", full, "; known ", name.empty() ? "tables" : "keys",
                                                 " here: ", KeysBelow(name)));
      } else if (!node.is_table()) {
        return Refuse(node.source(), absl::StrCat(full, " must be a table with the keys ", known));
      } else {
        RETURN_IF_ERROR(ReadTable(*node.as_table(), full));
      }
    }
    return absl::OkStatus();
  }

  absl::Status Refuse(const toml::source_region& region, const std::string& text) const {
    return absl::InvalidArgumentError(absl::StrCat(Place(region), ": ", text));
  }

 private:
  std::string Place(const toml::source_region& region) const {
    return absl::StrCat(path_, ":", static_cast<int64_t>(region.begin.line));
  }

  // "listen, drain_seconds" of "server"; the tables of "".
  static std::string KeysBelow(const std::string& table) {
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

  absl::Status ReadValue(const Setting& setting, const toml::node& node) {
    const std::string place = Place(node.source());
    const auto wrong = [&](const std::string& rule) { return Refuse(node.source(), setting.key + " must be " + rule); };
    if (std::holds_alternative<std::string Config::*>(setting.field)) {
      if (!node.is_string()) return wrong("a text in quotes");
      std::string text = node.as_string()->get();
      if (setting.is_path && !text.empty()) text = (std::filesystem::path(path_).parent_path() / text).string();
      return SetText(setting, text, place, configured_);
    }
    if (setting.is_switch()) {
      if (!node.is_boolean()) return wrong("true or false, without quotes");
      return SetText(setting, node.as_boolean()->get() ? "true" : "false", place, configured_);
    }
    if (!node.is_integer())
      return wrong(absl::StrCat("a whole number of ", setting.least, " to ", setting.most, ", without quotes"));
    return SetText(setting, absl::StrCat(node.as_integer()->get()), place, configured_);
  }

  const std::string& path_;
  Configured& configured_;
};

}  // namespace

absl::Status ReadToml(const std::string& text, const std::string& path, Configured& configured) {
  Configured read = configured;
  Reader reader(path, read);
  const toml::parse_result parsed = toml::parse(text);
  if (!parsed) return reader.Refuse(parsed.error().source(), std::string(parsed.error().description()));
  RETURN_IF_ERROR(reader.ReadTable(parsed.table(), ""));
  configured = std::move(read);
  return absl::OkStatus();
}

}  // namespace axiscal::server
