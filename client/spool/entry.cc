#include "client/spool/entry.h"

#include "absl/strings/escaping.h"
#include "core/base/sha256.h"
#include "core/base/strict_json.h"
#include "core/base/utf8.h"

namespace axiscal::spool {
namespace {

using Json = nlohmann::ordered_json;

// One field of `json` into `to`; false where it is missing or of another type.
bool Take(const Json& json, const char* key, std::string* to) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_string()) return false;
  *to = found->get<std::string>();
  return true;
}
bool Take(const Json& json, const char* key, int64_t* to) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number_integer()) return false;
  *to = found->get<int64_t>();
  return true;
}
bool Take(const Json& json, const char* key, bool* to) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_boolean()) return false;
  *to = found->get<bool>();
  return true;
}

std::string TextOf(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace

std::string EntryId(const Item& item, const std::string& sha256) {
  return base::Sha256Hex((item.is_log ? "log " : "session ") +
                         records::LogId(item.machine, item.name, item.form, sha256));
}

std::string WriteEntry(const Entry& entry) {
  Json json = {{"number", entry.number},
               {"id", entry.id},
               {"is_log", entry.item.is_log},
               {"machine", entry.item.machine},
               {"name", entry.item.name},
               {"source", entry.item.source},
               {"removes_source", entry.item.removes_source},
               {"template_name", entry.item.form.template_name},
               {"plan_name", entry.item.form.plan_name},
               {"session", entry.item.form.session},
               {"sha256", entry.sha256},
               {"size_bytes", entry.size_bytes}};
  // JSON has no other bytes than UTF-8, paths have.
  if (!base::IsUtf8(entry.item.source)) json["source_hex"] = absl::BytesToHexString(entry.item.source);
  if (entry.item.form.start_s) json["start_s"] = *entry.item.form.start_s;
  return TextOf(json);
}

absl::StatusOr<Entry> ReadEntry(const std::string& text) {
  ASSIGN_OR_RETURN(const Json json, base::ParseStrictJson(text));
  Entry entry;
  Item& item = entry.item;
  const bool is_whole = json.is_object() && Take(json, "number", &entry.number) && Take(json, "id", &entry.id) &&
                        Take(json, "is_log", &item.is_log) && Take(json, "machine", &item.machine) &&
                        Take(json, "name", &item.name) && Take(json, "source", &item.source) &&
                        Take(json, "removes_source", &item.removes_source) &&
                        Take(json, "template_name", &item.form.template_name) &&
                        Take(json, "plan_name", &item.form.plan_name) && Take(json, "session", &item.form.session) &&
                        Take(json, "sha256", &entry.sha256) && Take(json, "size_bytes", &entry.size_bytes);
  if (!is_whole) return absl::InvalidArgumentError("is no entry of a spool");
  if (std::string hex; Take(json, "source_hex", &hex)) item.source = absl::HexStringToBytes(hex);
  if (const auto start = json.find("start_s"); start != json.end()) {
    if (!start->is_number()) return absl::InvalidArgumentError("start_s must be a number");
    item.form.start_s = start->get<double>();
  }
  return entry;
}

std::string WriteNote(const Note& note) { return TextOf(Json(note)); }

absl::StatusOr<Note> ReadNote(const std::string& text) {
  ASSIGN_OR_RETURN(const Json json, base::ParseStrictJson(text));
  if (!json.is_object()) return absl::InvalidArgumentError("is no note of a spool");
  Note note;
  for (const auto& [key, value] : json.items()) {
    if (!value.is_string()) return absl::InvalidArgumentError(key + " must be a text");
    note[key] = value.get<std::string>();
  }
  return note;
}

}  // namespace axiscal::spool
