#include "core/toolsetter/cutter_keys.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/base/files.h"
#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/toolsetter/header_numbers.h"

namespace axiscal::toolsetter {
namespace {

using base::kRadPerDeg;

using Numbers = std::map<std::string, std::vector<double>>;

struct Key {
  const char* name;
  bool is_required;
  double unit;
  double* (*field)(CutterDescription&);
};

const std::vector<Key>& Keys() {
  static const auto& keys = *new std::vector<Key>{
      {"tool_radius_mm", true, 1.0, [](CutterDescription& d) { return &d.cutter.tool_radius_mm; }},
      {"insert_radius_mm", true, 1.0, [](CutterDescription& d) { return &d.cutter.insert_radius_mm; }},
      {"radial_angle_deg", true, kRadPerDeg, [](CutterDescription& d) { return &d.cutter.radial_rad; }},
      {"axial_angle_deg", true, kRadPerDeg, [](CutterDescription& d) { return &d.cutter.axial_rad; }},
      {"theta_t_deg", false, kRadPerDeg, [](CutterDescription& d) { return &d.cutter.theta_t_rad; }},
      {"clearance_deg", false, kRadPerDeg, [](CutterDescription& d) { return &d.cutter.clearance_rad; }},
      {"insert_thickness_mm", false, 1.0, [](CutterDescription& d) { return &d.cutter.insert_thickness_mm; }},
      {"offset_d_mm", true, 1.0, [](CutterDescription& d) { return &d.run.offset_mm; }},
      {"beam_radius_mm", true, 1.0, [](CutterDescription& d) { return &d.run.beam_radius_mm; }},
      {"spindle_rpm", true, 1.0, [](CutterDescription& d) { return &d.run.spindle_rpm; }},
      {"feed_mm_min", true, 1.0, [](CutterDescription& d) { return &d.run.feed_mm_min; }},
      {"start_height_mm", false, 1.0, [](CutterDescription& d) { return &d.run.start_height_mm; }},
  };
  return keys;
}

absl::Status Missing(const std::string& key) {
  return absl::InvalidArgumentError(key + " is missing, a cutter and its run need it");
}

absl::StatusOr<CutterDescription> FromNumbers(const Numbers& numbers) {
  CutterDescription out;
  out.run.start_height_mm = 1.0;
  for (const Key& key : Keys()) {
    const auto found = numbers.find(key.name);
    if (found == numbers.end()) {
      if (key.is_required) return Missing(key.name);
      continue;
    }
    if (found->second.size() != 1) return absl::InvalidArgumentError(absl::StrCat(key.name, ": expected one number"));
    *key.field(out) = found->second[0] * key.unit;
  }
  const auto inserts = numbers.find("inserts");
  if (inserts == numbers.end()) return Missing("inserts");
  const double count = inserts->second.size() == 1 ? inserts->second[0] : 0.0;
  if (!(count >= 1.0 && count <= 1000.0 && count == std::floor(count)))
    return absl::InvalidArgumentError("inserts: expected a whole number from 1");
  out.cutter.inserts = static_cast<int>(count);
  if (const auto angles = numbers.find("insert_angles_deg"); angles != numbers.end()) {
    for (const double angle_deg : angles->second) out.cutter.insert_angles_rad.push_back(angle_deg * kRadPerDeg);
  }
  const auto wear = numbers.find("wear_mm");
  out.wear_mm = wear != numbers.end() ? wear->second : std::vector<double>(out.cutter.inserts, 0.0);
  RETURN_IF_ERROR(Validate(out.cutter, out.run));
  RETURN_IF_ERROR(ValidateWear(out.cutter, out.wear_mm));
  return out;
}

bool IsKey(const std::string& name) {
  if (name == "inserts" || name == "insert_angles_deg" || name == "wear_mm") return true;
  return std::any_of(Keys().begin(), Keys().end(), [&](const Key& key) { return name == key.name; });
}

}  // namespace

absl::StatusOr<CutterDescription> ReadCutterJson(const std::string& text) {
  ASSIGN_OR_RETURN(const nlohmann::ordered_json json, base::ParseStrictJson(text));
  if (!json.is_object()) return absl::InvalidArgumentError("expected an object with the fields of one cutter");
  Numbers numbers;
  std::string id;
  for (const auto& [name, field] : json.items()) {
    const auto refuse = [&, key = name, shown = base::ShortJson(field)](const std::string& expected) {
      return absl::InvalidArgumentError(absl::StrCat(key, ": ", shown, ", expected ", expected));
    };
    if (name == "id" || name == "note" || name == "source") {
      if (!field.is_string()) return refuse("a text");
      if (name == "id") id = field.get<std::string>();
      continue;
    }
    if (!IsKey(name)) return refuse("no such field: docs/formats.md lists those of a cutter");
    const nlohmann::ordered_json list = field.is_array() ? field : nlohmann::ordered_json::array({field});
    for (const auto& number : list) {
      if (!number.is_number()) return refuse("a number or a list of numbers");
      numbers[name].push_back(number.get<double>());
    }
    if (list.empty()) return refuse("at least one number");
  }
  ASSIGN_OR_RETURN(CutterDescription out, FromNumbers(numbers));
  out.cutter.id = id;
  return out;
}

absl::StatusOr<CutterDescription> ReadCutterFile(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path, base::kMaxJsonBytes));
  auto out = ReadCutterJson(text);
  if (!out.ok()) return base::Within(path, out.status());
  return out;
}

absl::StatusOr<std::string> HeaderOfCutter(const std::string& cutter_json) {
  ASSIGN_OR_RETURN(const nlohmann::ordered_json cutter, base::ParseStrictJson(cutter_json));
  std::string text;
  for (const auto& [key, value] : cutter.items()) {
    if (value.is_number()) absl::StrAppend(&text, "# ", key, ": ", value.dump(), "\n");
    if (!value.is_array() || key == "wear_mm") continue;
    absl::StrAppend(&text, "# ", key, ":");
    for (const auto& number : value) absl::StrAppend(&text, " ", number.dump());
    text += "\n";
  }
  return text;
}

absl::StatusOr<CutterDescription> ReadCutterKeys(const session::Session& session) {
  Numbers numbers;
  for (const session::HeaderEntry& entry : session.header) {
    if (!IsKey(entry.key) || entry.key == "wear_mm") continue;
    if (numbers.count(entry.key) > 0)
      return absl::InvalidArgumentError(entry.key + ": stands there twice, expected once");
    ASSIGN_OR_RETURN(numbers[entry.key], HeaderList(session, entry.key, "numbers"));
  }
  ASSIGN_OR_RETURN(CutterDescription out, FromNumbers(numbers));
  out.cutter.id = session::FindHeader(session, "cutter").value_or("");
  return out;
}

}  // namespace axiscal::toolsetter
