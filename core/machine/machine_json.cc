#include "core/machine/machine_json.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "core/base/files.h"
#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/machine/program_profile.h"
#include "core/machine/redundant_facts.h"

namespace axiscal::machine {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDirectionTolerance = 1e-6;  // a direction written with six decimals

absl::Status Refuse(const std::string& field, const Json& value, const std::string& rule) {
  return absl::InvalidArgumentError(absl::StrCat(field, ": ", base::ShortJson(value), ", ", rule));
}

absl::Status OnlyMembers(const Json& object, const std::string& where, std::initializer_list<const char*> known) {
  for (const auto& [name, value] : object.items()) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string list;
    for (const char* member : known) absl::StrAppend(&list, list.empty() ? "" : ", ", member);
    return absl::InvalidArgumentError(absl::StrCat(where, name, ": unknown field, expected one of ", list));
  }
  return absl::OkStatus();
}

absl::StatusOr<const Json*> Member(const Json& object, const std::string& where, const std::string& name) {
  const auto found = object.find(name);
  if (found == object.end()) return absl::InvalidArgumentError(absl::StrCat(where, name, ": is missing"));
  return &*found;
}

absl::StatusOr<std::string> ReadText(const Json& value, const std::string& field) {
  if (!value.is_string()) return Refuse(field, value, "expected a text");
  return value.get<std::string>();
}

absl::StatusOr<std::vector<std::string>> ReadTexts(const Json& value, const std::string& field) {
  if (!value.is_array()) return Refuse(field, value, "expected a list of texts");
  std::vector<std::string> texts;
  for (size_t i = 0; i < value.size(); ++i) {
    ASSIGN_OR_RETURN(std::string text, ReadText(value[i], absl::StrCat(field, "[", i, "]")));
    texts.push_back(std::move(text));
  }
  return texts;
}

absl::StatusOr<std::vector<double>> ReadNumbers(const Json& value, const std::string& field, size_t count) {
  const bool right = value.is_array() && value.size() == count &&
                     std::all_of(value.begin(), value.end(), [](const Json& item) { return item.is_number(); });
  if (!right)
    return Refuse(field, value,
                  absl::StrCat("expected [", count == 3 ? "x, y, z" : "min, max", "], ", count, " numbers"));
  return value.get<std::vector<double>>();
}

absl::StatusOr<Eigen::Vector3d> ReadDirection(const Json& value, const std::string& field) {
  ASSIGN_OR_RETURN(const std::vector<double> xyz, ReadNumbers(value, field, 3));
  const Eigen::Vector3d direction(xyz[0], xyz[1], xyz[2]);
  if (!(std::abs(direction.norm() - 1.0) <= kDirectionTolerance)) return Refuse(field, value, "must have length 1");
  return direction / direction.norm();
}

absl::StatusOr<AxisKind> ReadKind(const Json& value, const std::string& field) {
  if (value == "linear") return AxisKind::kLinear;
  if (value == "rotary") return AxisKind::kRotary;
  return Refuse(field, value, "expected \"linear\" or \"rotary\"");
}

absl::Status ReadPoint(const Json& object, const std::string& where, Axis& axis) {
  const auto found = object.find("point_mm");
  if (found == object.end()) {
    if (axis.kind == AxisKind::kLinear) return absl::OkStatus();
    return absl::InvalidArgumentError(where + "point_mm: is missing, a rotary axis needs a point on it");
  }
  ASSIGN_OR_RETURN(const std::vector<double> xyz, ReadNumbers(*found, where + "point_mm", 3));
  axis.point_mm = Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
  if (axis.kind == AxisKind::kLinear && axis.point_mm != Eigen::Vector3d::Zero()) {
    return Refuse(where + "point_mm", *found, "a linear axis has no point: its errors act about the machine origin");
  }
  return absl::OkStatus();
}

absl::Status ReadTravel(const Json& object, const std::string& where, Axis& axis) {
  const bool linear = axis.kind == AxisKind::kLinear;
  const std::string right = linear ? "travel_mm" : "travel_deg", wrong = linear ? "travel_deg" : "travel_mm";
  if (const auto found = object.find(wrong); found != object.end()) {
    return Refuse(where + wrong, *found, absl::StrCat("a ", linear ? "linear" : "rotary", " axis has ", right));
  }
  const auto found = object.find(right);
  if (found == object.end()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<double> limits, ReadNumbers(*found, where + right, 2));
  if (!(limits[0] < limits[1])) return Refuse(where + right, *found, "the lower limit must be below the upper one");
  const double unit = linear ? 1.0 : base::kRadPerDeg;
  axis.min_position = limits[0] * unit;
  axis.max_position = limits[1] * unit;
  return absl::OkStatus();
}

struct RollOverName {
  const char* name;
  RollOver roll_over;
};
constexpr RollOverName kRollOverNames[] = {{"none", RollOver::kNone},
                                           {"shortest", RollOver::kShortest},
                                           {"sign", RollOver::kBySign},
                                           {"difference", RollOver::kByDifference}};

absl::Status ReadRollOver(const Json& object, const std::string& where, Axis& axis) {
  const auto found = object.find("roll_over");
  if (found == object.end()) return absl::OkStatus();
  const std::string field = where + "roll_over";
  if (axis.kind == AxisKind::kLinear) return Refuse(field, *found, "only rotary axes may roll over");
  for (const RollOverName& known : kRollOverNames) {
    if (*found == known.name) axis.roll_over = known.roll_over;
  }
  if (axis.roll_over == RollOver::kUnstated)
    return Refuse(field, *found, "expected \"none\", \"shortest\", \"sign\" or \"difference\"");
  if (axis.roll_over != RollOver::kNone && axis.min_position)
    return Refuse(field, *found,
                  "an axis that rolls over has no travel limits: leave out travel_deg, or state \"none\"");
  return absl::OkStatus();
}

absl::StatusOr<Axis> ReadAxis(const std::string& name, const Json& object) {
  const std::string where = absl::StrCat("axes.", name, ".");
  if (!IsAxisName(name)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "axes.", name, ": expected a capital letter other than T and W, and optional digits, as the axis name"));
  }
  if (!object.is_object()) return Refuse("axes." + name, object, "expected {\"kind\": ..., \"direction\": ...}");
  RETURN_IF_ERROR(
      OnlyMembers(object, where, {"kind", "direction", "point_mm", "travel_mm", "travel_deg", "roll_over"}));
  Axis axis;
  axis.name = name;
  ASSIGN_OR_RETURN(const Json* kind, Member(object, where, "kind"));
  ASSIGN_OR_RETURN(axis.kind, ReadKind(*kind, where + "kind"));
  ASSIGN_OR_RETURN(const Json* direction, Member(object, where, "direction"));
  ASSIGN_OR_RETURN(axis.direction, ReadDirection(*direction, where + "direction"));
  RETURN_IF_ERROR(ReadPoint(object, where, axis));
  RETURN_IF_ERROR(ReadTravel(object, where, axis));
  RETURN_IF_ERROR(ReadRollOver(object, where, axis));
  return axis;
}

// Moves the axes that `field` names from `unplaced` to the machine, in the branch's order.
absl::StatusOr<std::vector<int>> ReadBranch(const Json& root, const std::string& field, std::vector<Axis>& unplaced,
                                            Machine& machine) {
  ASSIGN_OR_RETURN(const Json* value, Member(root, "", field));
  ASSIGN_OR_RETURN(const std::vector<std::string> names, ReadTexts(*value, field));
  std::vector<int> branch;
  for (size_t i = 0; i < names.size(); ++i) {
    const std::string place = absl::StrCat(field, "[", i, "]: '", names[i], "', ");
    if (FindAxis(machine, names[i]) >= 0) {
      return absl::InvalidArgumentError(place + "stands in a branch already, expected each axis once");
    }
    const auto found =
        std::find_if(unplaced.begin(), unplaced.end(), [&](const Axis& axis) { return axis.name == names[i]; });
    if (found == unplaced.end()) return absl::InvalidArgumentError(place + "expected the name of an axis in 'axes'");
    branch.push_back(machine.axis_count());
    machine.axes.push_back(*found);
    unplaced.erase(found);
  }
  return branch;
}

struct ProfileText {
  const char* name;
  std::string ProgramProfile::*text;
};
constexpr ProfileText kProfileTexts[] = {
    {"tool_tip", &ProgramProfile::tool_tip},
    {"dialect", &ProgramProfile::dialect},
    {"unit", &ProgramProfile::unit},
    {"integer_words", &ProgramProfile::integer_words},
    {"decimals", &ProgramProfile::decimals},
    {"block_delete", &ProgramProfile::block_delete},
    {"harmless_m", &ProgramProfile::harmless_m},
    {"start", &ProgramProfile::start},
    {"tool_change_keeps", &ProgramProfile::tool_change_keeps},
};
struct ProfileList {
  const char* name;
  std::vector<std::string> ProgramProfile::*texts;
};
constexpr ProfileList kProfileLists[] = {{"offsets", &ProgramProfile::offsets},
                                         {"tool_lengths", &ProgramProfile::tool_lengths},
                                         {"tool_radii", &ProgramProfile::tool_radii}};

absl::StatusOr<ProgramProfile> ReadPrograms(const Json& root) {
  ProgramProfile profile;
  const auto found = root.find("programs");
  if (found == root.end()) return profile;
  if (!found->is_object()) return Refuse("programs", *found, "expected an object");
  RETURN_IF_ERROR(OnlyMembers(*found, "programs.",
                              {"tool_tip", "dialect", "unit", "integer_words", "decimals", "block_delete", "harmless_m",
                               "start", "tool_change_keeps", "offsets", "tool_lengths", "tool_radii"}));
  for (const ProfileText& known : kProfileTexts) {
    if (!found->contains(known.name)) continue;
    ASSIGN_OR_RETURN(profile.*known.text, ReadText((*found)[known.name], absl::StrCat("programs.", known.name)));
  }
  for (const ProfileList& known : kProfileLists) {
    if (!found->contains(known.name)) continue;
    ASSIGN_OR_RETURN(profile.*known.texts, ReadTexts((*found)[known.name], absl::StrCat("programs.", known.name)));
  }
  return profile;
}

Json ProgramsJson(const ProgramProfile& profile) {
  Json json = Json::object();
  for (const ProfileText& known : kProfileTexts) {
    if (!(profile.*known.text).empty()) json[known.name] = profile.*known.text;
  }
  for (const ProfileList& known : kProfileLists) {
    if (!(profile.*known.texts).empty()) json[known.name] = profile.*known.texts;
  }
  return json;
}

absl::Status ReadDeclared(const Json& root, Machine& machine) {
  const auto found = root.find("declared");
  if (found == root.end()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<std::string> texts, ReadTexts(*found, "declared"));
  for (size_t i = 0; i < texts.size(); ++i) {
    const std::string place = absl::StrCat("declared[", i, "]: '", texts[i], "', ");
    const auto symbol = ParseErrorSymbol(texts[i]);
    if (!symbol.ok()) return base::Within(absl::StrCat("declared[", i, "]"), symbol.status());
    if (FindJoint(machine, symbol->axis) < 0) {
      return absl::InvalidArgumentError(absl::StrCat(place, "the machine has no axis ", symbol->axis));
    }
    if (!symbol->is_constant) {
      return absl::InvalidArgumentError(place + "must be a constant error, written with a 0: EX0C");
    }
    if (std::find(machine.declared.begin(), machine.declared.end(), *symbol) != machine.declared.end()) {
      return absl::InvalidArgumentError(place + "is there twice");
    }
    machine.declared.push_back(*symbol);
  }
  return absl::OkStatus();
}

Json Number(double number) {
  const bool whole = std::trunc(number) == number && std::abs(number) < 1e15;
  return whole ? Json(static_cast<int64_t>(number)) : Json(number);
}

Json Vector(const Eigen::Vector3d& v) { return Json{Number(v.x()), Number(v.y()), Number(v.z())}; }

// Degrees that read back as the same radians where they came from a file: 13 digits hide the rounding of the two
// factors.
Json Degrees(double angle_rad) { return Number(std::stod(absl::StrFormat("%.13g", angle_rad * base::kDegPerRad))); }

std::string Text(const Json& json) {
  // Blanks after ':' and ',' as a person would write them; texts are quoted one by one, so no text is touched.
  if (json.is_array()) {
    std::string text;
    for (const Json& item : json) absl::StrAppend(&text, text.empty() ? "" : ", ", Text(item));
    return "[" + text + "]";
  }
  if (!json.is_object()) return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  std::string text;
  for (const auto& [name, value] : json.items()) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", Json(name).dump(), ": ", Text(value));
  }
  return "{" + text + "}";
}

Json AxisJson(const Axis& axis) {
  const bool linear = axis.kind == AxisKind::kLinear;
  Json json = {{"kind", linear ? "linear" : "rotary"}, {"direction", Vector(axis.direction)}};
  if (!linear) json["point_mm"] = Vector(axis.point_mm);
  if (axis.min_position && axis.max_position) {
    json[linear ? "travel_mm" : "travel_deg"] = linear ? Json{Number(*axis.min_position), Number(*axis.max_position)}
                                                       : Json{Degrees(*axis.min_position), Degrees(*axis.max_position)};
  }
  for (const RollOverName& known : kRollOverNames) {
    if (axis.roll_over == known.roll_over) json["roll_over"] = known.name;
  }
  return json;
}

Json Names(const Machine& machine, const std::vector<int>& branch) {
  Json names = Json::array();
  for (const int axis : branch) names.push_back(machine.axes[axis].name);
  return names;
}

}  // namespace

absl::StatusOr<Machine> MachineFromJson(const std::string& text) {
  ASSIGN_OR_RETURN(const Json root, base::ParseStrictJson(text));
  if (!root.is_object()) return Refuse("machine", root, "expected a JSON object");
  RETURN_IF_ERROR(OnlyMembers(root, "",
                              {"id", "structure", "axes", "tool_branch", "work_branch", "tool_direction", "declared",
                               "note", "source", "programs"}));
  Machine machine;
  ASSIGN_OR_RETURN(const Json* id, Member(root, "", "id"));
  ASSIGN_OR_RETURN(machine.id, ReadText(*id, "id"));
  if (root.contains("structure")) {
    ASSIGN_OR_RETURN(machine.structure, ReadText(root["structure"], "structure"));
  }
  ASSIGN_OR_RETURN(const Json* axes, Member(root, "", "axes"));
  if (!axes->is_object() || axes->empty()) {
    return Refuse("axes", *axes, "expected an object with a member for each axis");
  }
  // Before they are placed, which compares each with each.
  if (axes->size() > kMaxAxes) {
    return absl::InvalidArgumentError(absl::StrCat("axes: ", axes->size(), " axes, expected 1 to ", kMaxAxes));
  }
  std::vector<Axis> unplaced;
  for (const auto& [name, object] : axes->items()) {
    ASSIGN_OR_RETURN(Axis axis, ReadAxis(name, object));
    unplaced.push_back(std::move(axis));
  }
  ASSIGN_OR_RETURN(machine.tool_branch, ReadBranch(root, "tool_branch", unplaced, machine));
  ASSIGN_OR_RETURN(machine.work_branch, ReadBranch(root, "work_branch", unplaced, machine));
  if (!unplaced.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("axes.", unplaced[0].name, ": is in no branch, expected it in tool_branch or work_branch"));
  }
  ASSIGN_OR_RETURN(const Json* tool_direction, Member(root, "", "tool_direction"));
  ASSIGN_OR_RETURN(machine.tool_direction, ReadDirection(*tool_direction, "tool_direction"));
  RETURN_IF_ERROR(ReadDeclared(root, machine));
  RETURN_IF_ERROR(ReadPrograms(root).status());
  RETURN_IF_ERROR(Validate(machine));
  RETURN_IF_ERROR(CheckStructure(machine));
  return machine;
}

absl::StatusOr<Machine> ReadMachineFile(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, base::ReadFile(path, base::kMaxJsonBytes));
  auto machine = MachineFromJson(text);
  if (!machine.ok()) return base::Within(path, machine.status());
  return machine;
}

absl::StatusOr<ProgramProfile> ProgramProfileFromJson(const std::string& description_json) {
  RETURN_IF_ERROR(MachineFromJson(description_json).status());
  ASSIGN_OR_RETURN(const Json root, base::ParseStrictJson(description_json));
  return ReadPrograms(root);
}

absl::StatusOr<std::string> WithProgramProfile(const std::string& description_json, const ProgramProfile& profile) {
  RETURN_IF_ERROR(MachineFromJson(description_json).status());
  ASSIGN_OR_RETURN(Json root, base::ParseStrictJson(description_json));
  root.erase("programs");
  if (!(profile == ProgramProfile())) root["programs"] = ProgramsJson(profile);
  std::string text;
  for (const auto& [name, value] : root.items()) {
    absl::StrAppend(&text, text.empty() ? "{\n" : ",\n", " ", Json(name).dump(), ": ");
    if (name != "axes" && name != "programs") {
      absl::StrAppend(&text, Text(value));
      continue;
    }
    std::string members;
    for (const auto& [member, of_it] : value.items())
      absl::StrAppend(&members, members.empty() ? "{\n" : ",\n", "  ", Json(member).dump(), ": ", Text(of_it));
    absl::StrAppend(&text, members, "\n }");
  }
  return text + "\n}\n";
}

std::string MachineToJson(const Machine& machine) {
  std::string axes, declared;
  for (const Axis& axis : machine.axes) {
    absl::StrAppend(&axes, axes.empty() ? "" : ",", "\n  ", Json(axis.name).dump(), ": ", Text(AxisJson(axis)));
  }
  for (const ErrorSymbol& symbol : machine.declared) {
    absl::StrAppend(&declared, declared.empty() ? "" : ", ", Json(ToString(symbol)).dump());
  }
  return absl::StrCat("{\n \"id\": ", Text(machine.id), ", \"structure\": ", Text(machine.structure), ",\n \"axes\": {",
                      axes, "\n },\n \"tool_branch\": ", Text(Names(machine, machine.tool_branch)),
                      ",\n \"work_branch\": ", Text(Names(machine, machine.work_branch)),
                      ",\n \"tool_direction\": ", Text(Vector(machine.tool_direction)), ",\n \"declared\": [", declared,
                      "]\n}\n");
}

}  // namespace axiscal::machine
