// scenario.json read, truth.json written (docs/formats.md, "Scenario").
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>

#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/machine/error_json.h"
#include "core/synthetic/scenario.h"

namespace axiscal::synthetic {
namespace {

using base::kMmPerUm;
using base::kRadPerDeg;
using instruments::Carrier;
using json = nlohmann::ordered_json;

constexpr char kKind[] = "scenario/1";
constexpr size_t kMostEntries = 1000;  // of a list: effects, faults, sessions

// One object, of which every member must be asked for. Keeps the first error; values keep their defaults after it.
class Fields {
 public:
  Fields(const json& object, std::string where, absl::Status* status)
      : object_(object), where_(std::move(where)), status_(status) {
    if (!object_.is_object()) Refuse("", absl::StrCat(base::ShortJson(object_), ", expected an object"));
  }
  // Refuses members that nobody asked for.
  ~Fields() {
    if (!object_.is_object()) return;
    for (const auto& [key, value] : object_.items()) {
      if (!asked_.contains(key)) Refuse(key, "unknown field, expected some of " + Known());
    }
  }

  bool Has(const std::string& key) const { return object_.is_object() && object_.contains(key); }
  const json* Find(const std::string& key) {
    asked_.insert(key);
    return Has(key) ? &object_[key] : nullptr;
  }
  const json* Require(const std::string& key) {
    const json* value = Find(key);
    if (value == nullptr) Refuse(key, "is missing");
    return value;
  }

  // `value` = number x unit, `low` <= number <= `high`.
  bool Number(const std::string& key, double low, double high, double unit, double* value) {
    const json* found = Find(key);
    if (found == nullptr) return false;
    const double number = found->is_number() ? found->get<double>() : NAN;
    if (!(number >= low && number <= high)) {
      Refuse(key, absl::StrFormat("%s, expected a number from %g to %g", base::ShortJson(*found), low, high));
      return false;
    }
    *value = number * unit;
    return true;
  }
  void RequireNumber(const std::string& key, double low, double high, double unit, double* value) {
    if (!Has(key)) Refuse(key, "is missing");
    Number(key, low, high, unit, value);
  }
  void Whole(const std::string& key, int low, int high, int* value) {
    double number = *value;
    if (!Number(key, low, high, 1.0, &number)) return;
    if (number != std::floor(number)) Refuse(key, absl::StrCat(number, ", expected a whole number"));
    *value = static_cast<int>(number);
  }
  bool Text(const std::string& key, std::string* value) {
    const json* found = Find(key);
    if (found == nullptr) return false;
    if (!found->is_string() || found->get<std::string>().empty()) {
      Refuse(key, base::ShortJson(*found) + ", expected a text");
      return false;
    }
    *value = found->get<std::string>();
    return true;
  }
  void Flag(const std::string& key, bool* value) {
    const json* found = Find(key);
    if (found == nullptr) return;
    if (!found->is_boolean()) return Refuse(key, base::ShortJson(*found) + ", expected true or false");
    *value = found->get<bool>();
  }
  bool Vector(const std::string& key, double largest, double unit, Eigen::Vector3d* value) {
    const json* found = Find(key);
    if (found == nullptr) return false;
    bool is_fine = found->is_array() && found->size() == 3;
    for (size_t i = 0; is_fine && i < 3; ++i) {
      is_fine = (*found)[i].is_number() && std::abs((*found)[i].get<double>()) <= largest;
      if (is_fine) (*value)[static_cast<int>(i)] = unit * (*found)[i].get<double>();
    }
    if (!is_fine)
      Refuse(key, absl::StrFormat("%s, expected three numbers within +-%g", base::ShortJson(*found), largest));
    return is_fine;
  }
  void Texts(const std::string& key, std::vector<std::string>* values) {
    const json* found = Find(key);
    if (found == nullptr) return;
    const auto is_text = [](const json& one) { return one.is_string() && !one.get<std::string>().empty(); };
    if (!found->is_array() || found->size() > kMostEntries || !std::all_of(found->begin(), found->end(), is_text))
      return Refuse(key,
                    absl::StrCat(base::ShortJson(*found), ", expected a list of at most ", kMostEntries, " texts"));
    for (const json& one : *found) values->push_back(one.get<std::string>());
  }
  // The word's place in a list that nullptr ends.
  template <typename Enum>
  bool Word(const std::string& key, const char* const* words, Enum* value) {
    const json* found = Find(key);
    if (found == nullptr) return false;
    std::string known;
    for (int i = 0; words[i] != nullptr; ++i) {
      if (found->is_string() && found->get_ref<const std::string&>() == words[i]) {
        *value = static_cast<Enum>(i);
        return true;
      }
      absl::StrAppend(&known, i == 0 ? "" : ", ", words[i]);
    }
    Refuse(key, absl::StrCat(base::ShortJson(*found), ", expected one of ", known));
    return false;
  }
  // Every entry of a list of objects: `read(fields)`.
  template <typename Read>
  void List(const std::string& key, Read read) {
    const json* found = Find(key);
    if (found == nullptr) return;
    if (!found->is_array() || found->size() > kMostEntries)
      return Refuse(key,
                    absl::StrCat(base::ShortJson(*found), ", expected a list of at most ", kMostEntries, " objects"));
    for (size_t i = 0; i < found->size(); ++i) {
      Fields entry((*found)[i], absl::StrCat(Place(key), "[", i, "]"), status_);
      if (status_->ok()) read(entry);
    }
  }
  template <typename Read>
  void Object(const std::string& key, Read read) {
    const json* found = Find(key);
    if (found == nullptr) return;
    Fields members(*found, Place(key), status_);
    if (status_->ok()) read(members);
  }

  void Refuse(const std::string& key, const std::string& what) {
    if (!status_->ok()) return;
    const std::string place = Place(key);
    *status_ = absl::InvalidArgumentError(absl::StrCat(place, place.empty() ? "" : ": ", what));
  }
  std::string Place(const std::string& key) const {
    return absl::StrCat(where_, where_.empty() || key.empty() ? "" : ".", key);
  }

 private:
  std::string Known() const {
    std::string known;
    for (const std::string& key : asked_) absl::StrAppend(&known, known.empty() ? "" : ", ", key);
    return known;
  }

  const json& object_;
  const std::string where_;
  absl::Status* const status_;
  std::set<std::string> asked_;
};

constexpr double kMostMm = 1e5, kMostUm = 1e4, kMostSeconds = 1e8, kMostLength = 1e5;

void ReadPlan(Fields& plan, PlanSource* source) {
  plan.Text("case", &source->case_folder);
  plan.Texts("fit", &source->fit);
  plan.Texts("check", &source->check);
  plan.Texts("tests", &source->tests);
  plan.Texts("check_tests", &source->check_tests);
  Eigen::Vector3d point_mm;
  if (plan.Vector("tool_tip_mm", kMostMm, 1.0, &point_mm)) source->tool_tip_mm = point_mm;
  if (plan.Vector("table_ball_mm", kMostMm, 1.0, &point_mm)) source->table_ball_mm = point_mm;
  double bar_mm = 0.0;
  if (plan.Number("bar_mm", 10.0, 5000.0, 1.0, &bar_mm)) source->bar_mm = bar_mm;
  plan.Object("travel_deg", [&](Fields&) {});
  const int ways =
      (source->case_folder.empty() ? 0 : 1) + (source->fit.empty() ? 0 : 1) + (source->tests.empty() ? 0 : 1);
  if (ways != 1) plan.Refuse("", "expected one of 'case', 'fit' (session files) and 'tests'");
  if (!source->check.empty() && source->fit.empty()) plan.Refuse("check", "expected 'fit' with it");
  for (const char* const key : {"check_tests", "tool_tip_mm", "table_ball_mm", "bar_mm", "travel_deg"}) {
    if (plan.Has(key) && source->tests.empty()) plan.Refuse(key, "expected 'tests' with it");
  }
}

// Axis names are the members.
absl::Status ReadTravels(const json& travels, PlanSource* source) {
  for (const auto& [axis, limits] : travels.items()) {
    const bool are_limits = limits.is_array() && limits.size() == 2 && limits[0].is_number() && limits[1].is_number() &&
                            limits[0].get<double>() < limits[1].get<double>();
    if (!are_limits)
      return absl::InvalidArgumentError(
          absl::StrCat("plan.travel_deg.", axis, ": ", base::ShortJson(limits), ", expected [min, max] in deg"));
    source->travel_deg.push_back({axis, {limits[0].get<double>(), limits[1].get<double>()}});
  }
  return absl::OkStatus();
}

// An axis, T or W.
bool ReadJoint(Fields& fields, const std::string& key, const machine::Machine& machine, bool only_axes, int* joint) {
  std::string name;
  if (!fields.Text(key, &name)) return false;
  *joint = only_axes ? machine::FindAxis(machine, name) : machine::FindJoint(machine, name);
  if (*joint < 0) {
    fields.Refuse(key,
                  absl::StrCat("'", name, "', expected an axis of machine ", machine.id, only_axes ? "" : ", T or W"));
    return false;
  }
  return true;
}

bool IsRotary(const machine::Machine& machine, int axis) {
  return machine.axes[axis].kind == machine::AxisKind::kRotary;
}

// The effect's own axis, or the one that is named.
void ReadVariable(Fields& fields, const machine::Machine& machine, Effect* effect) {
  if (effect->joint < machine.axis_count()) effect->axis = effect->joint;
  ReadJoint(fields, "variable", machine, /*only_axes=*/true, &effect->axis);
  if (effect->axis < 0) fields.Refuse("variable", "is missing: the symbol names no axis");
}

void ReadLength(Fields& fields, const machine::Machine& machine, Effect* effect) {
  if (effect->axis < 0) return;
  if (IsRotary(machine, effect->axis)) {
    fields.Number("length_deg", 1e-3, 1e4, kRadPerDeg, &effect->length);
  } else {
    fields.Number("length_mm", 1e-3, kMostLength, 1.0, &effect->length);
  }
}

void ReadRipple(Fields& fields, const machine::Machine& machine, Effect* effect) {
  if (effect->axis < 0) return;
  if (IsRotary(machine, effect->axis)) {
    fields.RequireNumber("order", 1e-3, 1e4, 1.0, &effect->frequency);
  } else {
    double period_mm = 1.0;
    fields.RequireNumber("period_mm", 1e-3, kMostLength, 1.0, &period_mm);
    effect->frequency = 2.0 * std::numbers::pi / period_mm;
  }
}

void ReadKind(Fields& fields, const machine::Machine& machine, Effect* effect) {
  switch (effect->kind) {
    case EffectKind::kTimeCurve:
      fields.Number("length_s", 1.0, kMostSeconds, 1.0, &effect->length);
      return;
    case EffectKind::kGravity:
      ReadJoint(fields, "body", machine, /*only_axes=*/false, &effect->body);
      return;
    case EffectKind::kHeat:
      fields.Text("channel", &effect->channel);
      if (effect->channel.empty())
        fields.Refuse("channel", absl::StrCat("is missing, expected a temperature's name or \"", kTimeChannel, "\""));
      fields.RequireNumber("tau_s", 1e-3, kMostSeconds, 1.0, &effect->tau_s);
      ReadJoint(fields, "times", machine, /*only_axes=*/true, &effect->axis);
      return;
    case EffectKind::kCrossed: {
      std::vector<std::string> names;
      fields.Texts("variables", &names);
      const auto axis = [&](size_t i) { return i < names.size() ? machine::FindAxis(machine, names[i]) : -1; };
      effect->axis = axis(0);
      effect->second_axis = axis(1);
      if (names.size() != 2 || effect->axis < 0 || effect->second_axis < 0 || effect->axis == effect->second_axis)
        fields.Refuse("variables", absl::StrCat("expected two axes of machine ", machine.id));
      return;
    }
    default:
      break;
  }
  ReadVariable(fields, machine, effect);
  if (effect->kind == EffectKind::kRipple) return ReadRipple(fields, machine, effect);
  if (effect->kind == EffectKind::kFollowing) {
    fields.Number("delay_ms", 0.01, 1e4, 1e-3, &effect->delay_s);
    static const char* const kOf[] = {"acceleration", "speed", nullptr};
    fields.Word("of", kOf, &effect->is_of_speed);
    return;
  }
  ReadLength(fields, machine, effect);
}

void ReadEffect(Fields& fields, const machine::Machine& machine, Effect* effect) {
  if (fields.Require("kind") == nullptr || !fields.Word("kind", EffectWords(), &effect->kind)) return;
  std::string text;
  if (fields.Require("symbol") == nullptr || !fields.Text("symbol", &text)) return;
  const auto symbol = machine::ParseErrorSymbol(text);
  if (!symbol.ok()) return fields.Refuse("symbol", std::string(symbol.status().message()));
  effect->component = symbol->component;
  effect->joint = machine::FindJoint(machine, symbol->axis);
  if (effect->joint < 0)
    return fields.Refuse("symbol", absl::StrCat(text, ": machine ", machine.id, " has no axis ", symbol->axis));
  if (symbol->is_constant) return fields.Refuse("symbol", text + ": a 0 means constant, which belongs into 'errors'");
  fields.RequireNumber("rms", 1e-6, kMostUm, kMmPerUm, &effect->rms);
  if (machine::IsAngle(effect->component)) effect->rms *= base::kRadPerUrad / kMmPerUm;
  fields.Find("note");
  ReadKind(fields, machine, effect);
}

void ReadTemperature(Fields& fields, Temperature* temperature) {
  fields.Text("name", &temperature->name);
  fields.Flag("recorded", &temperature->is_recorded);
  constexpr double kMost = 200.0;
  fields.Number("start_C", -80.0, kMost, 1.0, &temperature->start_celsius);
  fields.Number("rise_C", -kMost, kMost, 1.0, &temperature->rise_celsius);
  fields.Number("tau_s", 1.0, kMostSeconds, 1.0, &temperature->tau_s);
  fields.Number("C_per_h", -kMost, kMost, 1.0, &temperature->celsius_per_hour);
  fields.Number("swing_C", -kMost, kMost, 1.0, &temperature->swing_celsius);
  fields.Number("period_s", 1.0, kMostSeconds, 1.0, &temperature->period_s);
  if (temperature->name == kTimeChannel) fields.Refuse("name", "'time' is the time, expected another name");
  const bool is_column =
      temperature->name == "temp_C" || (temperature->name.starts_with("T_") && temperature->name.ends_with("_C"));
  if (temperature->is_recorded && !is_column)
    fields.Refuse("name",
                  absl::StrCat("'", temperature->name, "', expected temp_C or T_NAME_C, or \"recorded\": false"));
}

void ReadFault(Fields& fields, Fault* fault) {
  if (fields.Require("kind") == nullptr || !fields.Word("kind", FaultWords(), &fault->kind)) return;
  fields.Texts("sessions", &fault->sessions);
  fields.Find("note");
  static const char* const kCarriers[] = {"table", "tool", nullptr};
  switch (fault->kind) {
    case FaultKind::kGain:
      fields.Number("gain_percent", 0.0, 50.0, 0.01, &fault->gain);
      fields.Number("crosstalk_percent", 0.0, 50.0, 0.01, &fault->crosstalk);
      return;
    case FaultKind::kScale:
      fields.Number("ppm", -1e4, 1e4, 1e-6, &fault->scale);
      fields.Number("ppm_per_K", -1e3, 1e3, 1e-6, &fault->scale_per_kelvin);
      return;
    case FaultKind::kLobes:
      fields.Whole("order", 1, 60, &fault->order);
      [[fallthrough]];
    case FaultKind::kBall:
      fault->carrier = Carrier::kTool;
      [[fallthrough]];
    case FaultKind::kMotion:
      fields.Word("carrier", kCarriers, &fault->carrier);
      fields.RequireNumber("rms_um", 1e-6, kMostUm, kMmPerUm, &fault->rms_mm);
      return;
    case FaultKind::kGrowth:
      fields.RequireNumber("rms_um", 1e-6, kMostUm, kMmPerUm, &fault->rms_mm);
      fields.Number("tau_s", 1e-3, kMostSeconds, 1.0, &fault->tau_s);
      return;
    case FaultKind::kClock:
    case FaultKind::kLoggedLate:
      fields.RequireNumber("delay_ms", -1e4, 1e4, 1e-3, &fault->delay_s);
      if (fault->delay_s == 0.0) fields.Refuse("delay_ms", "0, expected a delay");
      return;
    case FaultKind::kSlip:
      fields.Word("carrier", kCarriers, &fault->carrier);
      fields.Number("at", 0.0, 1.0, 1.0, &fault->at);
      if (fields.Require("moved_um") != nullptr) fields.Vector("moved_um", kMostUm, kMmPerUm, &fault->moved_mm);
      if (fault->sessions.empty()) fields.Refuse("sessions", "is missing, expected those in which it slips");
      return;
  }
}

void ReadNominal(Fields& fields, const machine::Machine& machine, NominalFault* fault) {
  if (fields.Require("kind") == nullptr || !fields.Word("kind", NominalWords(), &fault->kind)) return;
  fields.Find("note");
  const bool is_described = fault->kind == NominalKind::kDirection || fault->kind == NominalKind::kPivot;
  if (is_described) {
    if (fields.Require("axis") != nullptr) ReadJoint(fields, "axis", machine, /*only_axes=*/true, &fault->axis);
  } else {
    fields.Texts("sessions", &fault->sessions);
  }
  if (fault->kind == NominalKind::kDirection) {
    Eigen::Vector3d direction;
    if (!fields.Vector("direction", 1.0, 1.0, &direction)) return;
    if (std::abs(direction.norm() - 1.0) > 1e-6) return fields.Refuse("direction", "must have length 1");
    fault->direction = direction.normalized();
  } else if (fault->kind == NominalKind::kPivot || fault->kind == NominalKind::kToolLength) {
    if (fields.Require("offset_mm") != nullptr) fields.Vector("offset_mm", kMostMm, 1.0, &fault->offset_mm);
    if (fault->kind == NominalKind::kPivot && fault->axis >= 0 && !IsRotary(machine, fault->axis))
      fields.Refuse("axis", absl::StrCat(machine.axes[fault->axis].name, " is linear, expected a rotary axis"));
  } else if (fault->kind == NominalKind::kSwapped) {
    fields.Texts("columns", &fault->columns);
    if (fault->columns.size() != 2) fields.Refuse("columns", "expected the names of two columns");
  } else {
    std::string column;
    if (fields.Require("column") != nullptr && fields.Text("column", &column)) fault->columns = {column};
    fields.RequireNumber("factor", -1e6, 1e6, 1.0, &fault->factor);
  }
}

void ReadNoise(Fields& fields, Scenario* scenario) {
  NoiseOptions& noise = scenario->noise;
  fields.Number("sigma_scale", 0.0, 1e3, 1.0, &noise.sigma_scale);
  fields.Number("ar1", 0.0, 0.9999, 1.0, &noise.ar1);
  fields.Number("white_share", 0.0, 1.0, 1.0, &noise.white_share);
  fields.Number("pose_share", 0.0, 1.0, 1.0, &noise.pose_share);
  fields.Number("heavy_share", 0.0, 1.0, 1.0, &noise.heavy_share);
  fields.Whole("student_degrees", 3, 100, &noise.student_degrees);
  fields.Number("bad_share", 0.0, 0.5, 1.0, &scenario->bad_share);
  fields.Number("resolution_um", 0.0, kMostUm, kMmPerUm, &noise.resolution_mm);
  fields.Flag("draw_setup", &noise.draw_setup);
}

void ReadSampling(Fields& fields, Sampling* sampling) {
  fields.Whole("stride", 1, 1000, &sampling->stride);
  fields.Number("kept_share", 0.01, 1.0, 1.0, &sampling->kept_share);
  fields.Number("lost_share", 0.0, 0.9, 1.0, &sampling->lost_share);
  fields.Number("slower", 1e-3, 1e3, 1.0, &sampling->slower);
  fields.Number("time_jitter", 0.0, 0.9, 1.0, &sampling->time_jitter);
  fields.Number("gap_s", 0.0, kMostSeconds, 1.0, &sampling->gap_s);
}

absl::StatusOr<json> ParseScenario(const std::string& text) {
  auto parsed = base::ParseStrictJson(text);
  if (!parsed.ok()) return parsed.status();
  if (!parsed->is_object() || parsed->value("axiscal", json()) != kKind)
    return absl::InvalidArgumentError(absl::StrCat("expected an object with \"axiscal\": \"", kKind, "\""));
  return parsed;
}

std::string FormWord(Form form) { return form == Form::kOwn ? "own" : "independent"; }

}  // namespace

absl::StatusOr<PlanSource> ReadPlanSource(const std::string& text) {
  ASSIGN_OR_RETURN(const json root, ParseScenario(text));
  PlanSource source;
  absl::Status status;
  const json none = json::object();
  const json& plan = root.contains("plan") ? root["plan"] : none;
  if (!plan.is_object()) return absl::InvalidArgumentError("plan: " + base::ShortJson(plan) + ", expected an object");
  // The members of travel_deg are axes: they are read by themselves.
  json flat = plan;
  if (flat.contains("travel_deg") && flat["travel_deg"].is_object()) {
    RETURN_IF_ERROR(ReadTravels(flat["travel_deg"], &source));
    flat["travel_deg"] = json::object();
  }
  {
    Fields fields(flat, "plan", &status);
    ReadPlan(fields, &source);
  }
  RETURN_IF_ERROR(status);
  if (root.contains("machine")) {
    if (!root["machine"].is_string() || root["machine"].get<std::string>().empty())
      return absl::InvalidArgumentError("machine: " + base::ShortJson(root["machine"]) + ", expected a file's name");
    source.machine = root["machine"].get<std::string>();
  } else if (source.case_folder.empty()) {
    return absl::InvalidArgumentError("machine: is missing, expected machine.json's name (a case folder has its own)");
  }
  return source;
}

absl::StatusOr<Scenario> ReadScenario(const std::string& text, const machine::Machine& machine) {
  ASSIGN_OR_RETURN(const json root, ParseScenario(text));
  Scenario scenario;
  scenario.text = text;
  absl::Status status;
  {
    Fields fields(root, "", &status);
    for (const char* const known : {"axiscal", "note", "machine", "plan"}) fields.Find(known);
    if (const json* errors = fields.Find("errors")) {
      auto model = machine::ReadErrors(errors->dump(), machine);
      if (!model.ok()) return model.status();
      scenario.errors = *std::move(model);
    }
    if (fields.Vector("gravity", 1.0, 1.0, &scenario.surroundings.gravity_direction)) {
      if (std::abs(scenario.surroundings.gravity_direction.norm() - 1.0) > 1e-6)
        fields.Refuse("gravity", "must have length 1: the direction in which things fall");
    }
    fields.Object("sampling", [&](Fields& of) { ReadSampling(of, &scenario.sampling); });
    fields.List("temperatures", [&](Fields& of) { ReadTemperature(of, &scenario.temperatures.emplace_back()); });
    fields.List("effects", [&](Fields& of) { ReadEffect(of, machine, &scenario.effects.emplace_back()); });
    fields.List("faults", [&](Fields& of) { ReadFault(of, &scenario.faults.emplace_back()); });
    fields.List("nominal", [&](Fields& of) { ReadNominal(of, machine, &scenario.nominal.emplace_back()); });
    fields.Object("noise", [&](Fields& of) { ReadNoise(of, &scenario); });
  }
  RETURN_IF_ERROR(status);
  std::set<std::string> names;
  for (const Temperature& temperature : scenario.temperatures) {
    if (!names.insert(temperature.name).second)
      return absl::InvalidArgumentError(absl::StrCat("temperatures: '", temperature.name, "' is there twice"));
  }
  return scenario;
}

std::string WriteTruth(const SimulatedCase& simulated, const Scenario& scenario, Form form, uint64_t seed) {
  const Truth& truth = simulated.truth;
  json effects = json::array(), bad = json::array();
  for (const Truth::NamedEffect& effect : truth.effects) {
    const bool is_angle = machine::IsAngle(effect.drawn.component);
    const double rms = RmsAboutMean(effect.drawn.Errors(simulated.history));
    effects.push_back({{"name", effect.name},
                       {"rms", std::round(1e6 * rms * (is_angle ? base::kUradPerRad : base::kUmPerMm)) / 1e6},
                       {"unit", is_angle ? "urad" : "um"}});
  }
  for (const BadReading& reading : truth.bad)
    bad.push_back({{"session", reading.session}, {"row", reading.row}, {"column", reading.column + 1}});
  const Eigen::Vector3d& tip = truth.tip_mm;
  const json document = {{"axiscal", "truth/1"},
                         {"seed", seed},
                         {"form", FormWord(form)},
                         {"is_all_in_errors", truth.is_all_in_errors()},
                         {"tool_tip_mm", {tip.x(), tip.y(), tip.z()}},
                         {"errors", json::parse(machine::WriteErrors(truth.errors, truth.machine), nullptr, false)},
                         {"effects", effects},
                         {"bad_readings", bad},
                         {"scenario", json::parse(scenario.text, nullptr, false)}};
  return document.dump(1) + "\n";
}

}  // namespace axiscal::synthetic
