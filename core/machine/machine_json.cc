#include "core/machine/machine_json.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "core/base/files.h"
#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/machine/machine_limits.h"
#include "core/machine/program_profile.h"
#include "core/machine/redundant_facts.h"

namespace axiscal::machine {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDirectionTolerance = 1e-6;  // a direction written with six decimals

absl::Status Refuse(const std::string& field, const Json& value, const std::string& rule) {
  return absl::InvalidArgumentError(absl::StrCat(field, ": ", base::ShortJson(value), ", ", rule));
}

// All that is missing or wrong in a description, in the order in which it is read: it is mended in one go.
class Faults {
 public:
  // Whether it is OK; otherwise it is one more.
  bool Take(const absl::Status& status) {
    if (!status.ok()) texts_.emplace_back(status.message());
    return status.ok();
  }
  // The same of a value, which goes to `value` where it is there.
  template <typename T>
  bool Take(absl::StatusOr<T> read, T* value) {
    const absl::Status status = read.status();
    if (status.ok()) *value = *std::move(read);
    return Take(status);
  }

  size_t size() const { return texts_.size(); }

  // OK, the one that there is, or INVALID_ARGUMENT with a line for each, as many as the wire carries.
  absl::Status ToStatus() const {
    if (texts_.empty()) return absl::OkStatus();
    if (texts_.size() == 1) return absl::InvalidArgumentError(texts_[0]);
    constexpr size_t kMostBytes = 1800;  // gRPC ends calls whose trailing metadata, which hold it thrice, exceed 8 KiB
    std::string text = absl::StrCat(texts_.size(), " fields are missing or wrong:");
    for (size_t i = 0; i < texts_.size(); ++i) {
      if (i > 0 && text.size() + texts_[i].size() > kMostBytes) {
        absl::StrAppend(&text, "\n  and ", texts_.size() - i, " more");
        break;
      }
      absl::StrAppend(&text, "\n  ", texts_[i]);
    }
    return absl::InvalidArgumentError(text);
  }

 private:
  std::vector<std::string> texts_;
};

void OnlyMembers(const Json& object, const std::string& where, std::initializer_list<const char*> known,
                 Faults* faults) {
  for (const auto& [name, value] : object.items()) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string list;
    for (const char* member : known) absl::StrAppend(&list, list.empty() ? "" : ", ", member);
    faults->Take(absl::InvalidArgumentError(absl::StrCat(where, name, ": unknown field, expected one of ", list)));
  }
}

// Null, and a fault, where it is not there.
const Json* Member(const Json& object, const std::string& where, const std::string& name, Faults* faults) {
  const auto found = object.find(name);
  if (found != object.end()) return &*found;
  faults->Take(absl::InvalidArgumentError(absl::StrCat(where, name, ": is missing")));
  return nullptr;
}

absl::StatusOr<std::string> ReadText(const Json& value, const std::string& field) {
  if (!value.is_string()) return Refuse(field, value, "expected a text");
  return value.get<std::string>();
}

// `take(text, "field[2]")` for each text of a list, a status: what is wrong with it.
template <typename TakeText>
void ReadTexts(const Json& value, const std::string& field, const TakeText& take, Faults* faults) {
  if (!value.is_array()) {
    faults->Take(Refuse(field, value, "expected a list of texts"));
    return;
  }
  for (size_t i = 0; i < value.size(); ++i) {
    const std::string place = absl::StrCat(field, "[", i, "]");
    std::string text;
    if (faults->Take(ReadText(value[i], place), &text)) faults->Take(take(text, place));
  }
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
  return Eigen::Vector3d(direction / direction.norm());
}

absl::StatusOr<AxisKind> ReadKind(const Json& value, const std::string& field) {
  if (value == "linear") return AxisKind::kLinear;
  if (value == "rotary") return AxisKind::kRotary;
  return Refuse(field, value, "expected \"linear\" or \"rotary\"");
}

// `is_known`: the axis' kind is; what depends on it is judged then.
absl::Status ReadPoint(const Json& object, const std::string& where, bool is_known, Axis& axis) {
  const auto found = object.find("point_mm");
  if (found == object.end()) {
    if (!is_known || axis.kind == AxisKind::kLinear) return absl::OkStatus();
    return absl::InvalidArgumentError(where + "point_mm: is missing, a rotary axis needs a point on it");
  }
  ASSIGN_OR_RETURN(const std::vector<double> xyz, ReadNumbers(*found, where + "point_mm", 3));
  axis.point_mm = Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
  if (is_known && axis.kind == AxisKind::kLinear && axis.point_mm != Eigen::Vector3d::Zero()) {
    return Refuse(where + "point_mm", *found, "a linear axis has no point: its errors act about the machine origin");
  }
  if (axis.point_mm.cwiseAbs().maxCoeff() > kFarthestPointMm)
    return Refuse(where + "point_mm", *found, "must be finite, at most 1e6 mm");
  return absl::OkStatus();
}

absl::Status ReadTravel(const Json& object, const std::string& where, bool is_known, Axis& axis) {
  const bool linear = axis.kind == AxisKind::kLinear;
  for (const bool is_mm : {true, false}) {
    const std::string field = is_mm ? "travel_mm" : "travel_deg";
    const auto found = object.find(field);
    if (found == object.end()) continue;
    if (is_known && is_mm != linear) {
      return Refuse(where + field, *found, linear ? "a linear axis has travel_mm" : "a rotary axis has travel_deg");
    }
    ASSIGN_OR_RETURN(const std::vector<double> limits, ReadNumbers(*found, where + field, 2));
    if (!(limits[0] < limits[1])) return Refuse(where + field, *found, "the lower limit must be below the upper one");
    const double unit = is_mm ? 1.0 : base::kRadPerDeg;
    axis.min_position = limits[0] * unit;
    axis.max_position = limits[1] * unit;
  }
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

absl::Status ReadRollOver(const Json& object, const std::string& where, bool is_known, Axis& axis) {
  const auto found = object.find("roll_over");
  if (found == object.end()) return absl::OkStatus();
  const std::string field = where + "roll_over";
  if (is_known && axis.kind == AxisKind::kLinear) return Refuse(field, *found, "only rotary axes may roll over");
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

// What of it is right.
Axis ReadAxis(const std::string& name, const Json& object, Faults* faults) {
  Axis axis;
  axis.name = name;
  const std::string where = absl::StrCat("axes.", name, ".");
  if (!IsAxisName(name)) {
    faults->Take(absl::InvalidArgumentError(absl::StrCat(
        "axes.", name, ": expected a capital letter other than T and W, and optional digits, as the axis name")));
  }
  if (!object.is_object()) {
    faults->Take(Refuse("axes." + name, object, "expected {\"kind\": ..., \"direction\": ...}"));
    return axis;
  }
  OnlyMembers(object, where, {"kind", "direction", "point_mm", "travel_mm", "travel_deg", "roll_over"}, faults);
  const Json* const kind = Member(object, where, "kind", faults);
  const bool is_known = kind != nullptr && faults->Take(ReadKind(*kind, where + "kind"), &axis.kind);
  if (const Json* const direction = Member(object, where, "direction", faults))
    faults->Take(ReadDirection(*direction, where + "direction"), &axis.direction);
  faults->Take(ReadPoint(object, where, is_known, axis));
  faults->Take(ReadTravel(object, where, is_known, axis));
  faults->Take(ReadRollOver(object, where, is_known, axis));
  return axis;
}

// Moves the axes that `field` names from `unplaced` to the machine, in the branch's order. `are_listed`: there are axes
// to name.
std::vector<int> ReadBranch(const Json& root, const std::string& field, bool are_listed, std::vector<Axis>& unplaced,
                            Machine& machine, Faults* faults) {
  std::vector<int> branch;
  const Json* const value = Member(root, "", field, faults);
  if (value == nullptr) return branch;
  const auto place_axis = [&](const std::string& name, const std::string& place) {
    if (!are_listed) return absl::OkStatus();
    const std::string what = absl::StrCat(place, ": '", name, "', ");
    if (FindAxis(machine, name) >= 0)
      return absl::InvalidArgumentError(what + "stands in a branch already, expected each axis once");
    const auto found =
        std::find_if(unplaced.begin(), unplaced.end(), [&](const Axis& axis) { return axis.name == name; });
    if (found == unplaced.end()) return absl::InvalidArgumentError(what + "expected the name of an axis in 'axes'");
    branch.push_back(machine.axis_count());
    machine.axes.push_back(*found);
    unplaced.erase(found);
    return absl::OkStatus();
  };
  ReadTexts(*value, field, place_axis, faults);
  return branch;
}

// The axes and the branches in which they stand. Returns whether all of them stand there, right or wrong.
bool ReadAxes(const Json& root, Machine& machine, Faults* faults) {
  std::vector<Axis> unplaced;
  if (const Json* const axes = Member(root, "", "axes", faults)) {
    if (!axes->is_object() || axes->empty()) {
      faults->Take(Refuse("axes", *axes, "expected an object with a member for each axis"));
    } else if (axes->size() > kMaxAxes) {  // before they are placed, which compares each with each
      faults->Take(absl::InvalidArgumentError(absl::StrCat("axes: ", axes->size(), " axes, expected 1 to ", kMaxAxes)));
    } else {
      for (const auto& [name, object] : axes->items()) unplaced.push_back(ReadAxis(name, object, faults));
    }
  }
  const bool are_listed = !unplaced.empty();
  const size_t before = faults->size();
  machine.tool_branch = ReadBranch(root, "tool_branch", are_listed, unplaced, machine, faults);
  machine.work_branch = ReadBranch(root, "work_branch", are_listed, unplaced, machine, faults);
  if (!are_listed || faults->size() > before) return false;
  for (const Axis& axis : unplaced) {
    faults->Take(absl::InvalidArgumentError(
        absl::StrCat("axes.", axis.name, ": is in no branch, expected it in tool_branch or work_branch")));
  }
  return unplaced.empty();
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

ProgramProfile ReadPrograms(const Json& root, Faults* faults) {
  ProgramProfile profile;
  const auto found = root.find("programs");
  if (found == root.end()) return profile;
  if (!found->is_object()) {
    faults->Take(Refuse("programs", *found, "expected an object"));
    return profile;
  }
  OnlyMembers(*found, "programs.",
              {"tool_tip", "dialect", "unit", "integer_words", "decimals", "block_delete", "harmless_m", "start",
               "tool_change_keeps", "offsets", "tool_lengths", "tool_radii"},
              faults);
  for (const ProfileText& known : kProfileTexts) {
    const auto text = found->find(known.name);
    if (text != found->end())
      faults->Take(ReadText(*text, absl::StrCat("programs.", known.name)), &(profile.*known.text));
  }
  for (const ProfileList& known : kProfileLists) {
    const auto list = found->find(known.name);
    if (list == found->end()) continue;
    const auto keep = [&](const std::string& text, const std::string&) {
      (profile.*known.texts).push_back(text);
      return absl::OkStatus();
    };
    ReadTexts(*list, absl::StrCat("programs.", known.name), keep, faults);
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

// `are_axes_known`: which axes the machine has is.
void ReadDeclared(const Json& root, bool are_axes_known, Machine& machine, Faults* faults) {
  const auto found = root.find("declared");
  if (found == root.end()) return;
  const auto declare = [&](const std::string& text, const std::string& at) {
    const auto symbol = ParseErrorSymbol(text);
    if (!symbol.ok()) return base::Within(at, symbol.status());
    const std::string place = absl::StrCat(at, ": '", text, "', ");
    if (are_axes_known && FindJoint(machine, symbol->axis) < 0) {
      return absl::InvalidArgumentError(absl::StrCat(place, "the machine has no axis ", symbol->axis));
    }
    if (!symbol->is_constant) {
      return absl::InvalidArgumentError(place + "must be a constant error, written with a 0: EX0C");
    }
    if (std::find(machine.declared.begin(), machine.declared.end(), *symbol) != machine.declared.end()) {
      return absl::InvalidArgumentError(place + "is there twice");
    }
    machine.declared.push_back(*symbol);
    return absl::OkStatus();
  };
  ReadTexts(*found, "declared", declare, faults);
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
  Faults faults;
  OnlyMembers(root, "",
              {"id", "structure", "axes", "tool_branch", "work_branch", "tool_direction", "declared", "note", "source",
               "programs"},
              &faults);
  Machine machine;
  if (const Json* const id = Member(root, "", "id", &faults)) {
    if (faults.Take(ReadText(*id, "id"), &machine.id) && !IsMachineId(machine.id))
      faults.Take(Refuse("id", *id, absl::StrCat("an ", kMachineIdRule)));
  }
  if (const auto structure = root.find("structure"); structure != root.end())
    faults.Take(ReadText(*structure, "structure"), &machine.structure);
  const bool are_axes_known = ReadAxes(root, machine, &faults);
  if (const Json* const tool_direction = Member(root, "", "tool_direction", &faults))
    faults.Take(ReadDirection(*tool_direction, "tool_direction"), &machine.tool_direction);
  ReadDeclared(root, are_axes_known, machine, &faults);
  ReadPrograms(root, &faults);
  if (are_axes_known) faults.Take(CheckStructure(machine));
  RETURN_IF_ERROR(faults.ToStatus());
  RETURN_IF_ERROR(Validate(machine));
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
  Faults none;
  return ReadPrograms(root, &none);
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
