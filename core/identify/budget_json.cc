#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/identify/budget.h"
#include "core/machine/error_json.h"

namespace axiscal::identify {
namespace {

using json = nlohmann::ordered_json;

constexpr char kKind[] = "budget/1";
// Members of a source that are its own; the others describe its error term.
const std::set<std::string>& OwnMembers() {
  static const auto* const kMembers =
      new std::set<std::string>{"name", "reading", "half_width", "sigma", "drawn", "sessions"};
  return *kMembers;
}

absl::Status Refuse(const std::string& where, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("budget: ", where, ": ", what));
}

absl::StatusOr<std::string> Name(const json& object, const std::string& where) {
  const auto found = object.find("name");
  if (found == object.end()) return Refuse(where, "'name' is missing");
  if (!found->is_string() || found->get<std::string>().empty() || found->get<std::string>().size() > 100) {
    return Refuse(where, absl::StrCat("'name' = ", base::ShortJson(*found), ", expected a text of 1 to 100 bytes"));
  }
  return found->get<std::string>();
}

absl::Status ReadScale(const json& object, const std::string& where, Source* source) {
  if (object.contains("half_width") == object.contains("sigma")) {
    return Refuse(where, "expected one of 'half_width' (uniform) and 'sigma' (normal)");
  }
  source->distribution = object.contains("sigma") ? Distribution::kNormal : Distribution::kUniform;
  const char* const key = object.contains("sigma") ? "sigma" : "half_width";
  const json& value = object[key];
  if (!value.is_number() || !std::isfinite(value.get<double>()) || value.get<double>() <= 0.0) {
    return Refuse(where, absl::StrCat("'", key, "' = ", base::ShortJson(value), ", expected a number > 0"));
  }
  source->scale = value.get<double>();
  return absl::OkStatus();
}

absl::Status ReadDrawn(const json& object, const std::string& where, Source* source) {
  const auto found = object.find("drawn");
  const std::string text =
      found == object.end() ? "'drawn' is missing" : absl::StrCat("'drawn' = ", base::ShortJson(*found));
  const std::string word = found != object.end() && found->is_string() ? found->get<std::string>() : "";
  if (word == "reading") {
    source->drawn_per = DrawnPer::kReading;
  } else if (word == "session") {
    source->drawn_per = DrawnPer::kSession;
  } else if (word == "run") {
    source->drawn_per = DrawnPer::kRun;
  } else {
    return Refuse(where, text + ", expected \"reading\", \"session\" or \"run\"");
  }
  return absl::OkStatus();
}

absl::Status ReadSessions(const json& object, const std::string& where, Source* source) {
  const auto found = object.find("sessions");
  if (found == object.end()) return absl::OkStatus();
  const bool is_list = found->is_array() && !found->empty();
  if (!is_list || !std::all_of(found->begin(), found->end(), [](const json& name) { return name.is_string(); })) {
    return Refuse(where, absl::StrCat("'sessions' = ", base::ShortJson(*found), ", expected names of sessions"));
  }
  for (const json& name : *found) source->sessions.push_back(name.get<std::string>());
  return absl::OkStatus();
}

// What the source does: an error term (the members that are not a source's own), or the readings' own scatter, um.
absl::Status ReadEffect(const json& object, const std::string& where, const machine::Machine& machine, Source* source) {
  json term = json::object();
  for (const auto& [key, value] : object.items()) {
    if (!OwnMembers().contains(key)) term[key] = value;
  }
  if (object.contains("reading")) {
    if (object["reading"] != true) return Refuse(where, "'reading' must be true where it is there");
    if (!term.empty()) return Refuse(where, absl::StrCat("'", term.begin().key(), "' does not go with 'reading'"));
    source->is_reading = true;
    source->scale *= base::kMmPerUm;
    return absl::OkStatus();
  }
  for (const char* const drawn : {"amplitude", "phase_deg"}) {
    if (term.contains(drawn)) return Refuse(where, absl::StrCat("'", drawn, "' is what is drawn, expected none"));
  }
  term["amplitude"] = 1.0;
  if (!term.contains("shape")) term["shape"] = shapes::Constant::kName;
  if (term["shape"] == shapes::Harmonic::kName || term["shape"] == shapes::Lobe::kName) term["phase_deg"] = 0.0;
  const absl::StatusOr<machine::ErrorModel> model =
      machine::ReadErrors(json({{"terms", json::array({term})}}).dump(), machine);
  if (!model.ok()) return base::Within("budget: " + where, model.status());
  if (model->terms.size() != 1) return Refuse(where, "expected an error of one amplitude, no map");
  source->term = model->terms[0];
  source->scale *= machine::AmplitudeFactor(source->term);
  return absl::OkStatus();
}

absl::StatusOr<Source> ReadSource(const json& object, const std::string& where, const machine::Machine& machine) {
  if (!object.is_object()) return Refuse(where, absl::StrCat(base::ShortJson(object), ", expected an object"));
  Source source;
  ASSIGN_OR_RETURN(source.name, Name(object, where));
  RETURN_IF_ERROR(ReadScale(object, where, &source));
  RETURN_IF_ERROR(ReadDrawn(object, where, &source));
  RETURN_IF_ERROR(ReadSessions(object, where, &source));
  RETURN_IF_ERROR(ReadEffect(object, where, machine, &source));
  return source;
}

}  // namespace

absl::StatusOr<Budget> ReadBudget(const std::string& text, const machine::Machine& machine) {
  const auto parsed = base::ParseStrictJson(text);
  if (!parsed.ok()) return base::Within("budget", parsed.status());
  const json& root = *parsed;
  if (!root.is_object() || root.value("axiscal", json()) != kKind) {
    return absl::InvalidArgumentError(absl::StrCat("budget: expected an object with \"axiscal\": \"", kKind, "\""));
  }
  for (const auto& [key, value] : root.items()) {
    if (key == "axiscal" || key == "reading_noise" || key == "sources" || key == "note") continue;
    return Refuse(key, "unknown member, expected axiscal, reading_noise, sources, note");
  }
  Budget budget;
  if (root.contains("reading_noise")) {
    if (!root["reading_noise"].is_boolean()) {
      return Refuse("reading_noise", base::ShortJson(root["reading_noise"]) + ", expected true or false");
    }
    budget.with_reading_noise = root["reading_noise"].get<bool>();
  }
  const json sources = root.value("sources", json::array());
  if (!sources.is_array() || sources.size() > kMaxSources) {
    return Refuse("sources", absl::StrCat("expected a list of at most ", kMaxSources, " sources"));
  }
  std::set<std::string> names;
  for (size_t i = 0; i < sources.size(); ++i) {
    const std::string where = absl::StrCat("sources[", i, "]");
    ASSIGN_OR_RETURN(Source source, ReadSource(sources[i], where, machine));
    if (!names.insert(source.name).second) return Refuse(where, absl::StrCat("'", source.name, "' is there twice"));
    budget.sources.push_back(std::move(source));
  }
  if (!budget.with_reading_noise && budget.sources.empty()) {
    return absl::InvalidArgumentError("budget: no source and no reading noise: nothing would be drawn");
  }
  return budget;
}

}  // namespace axiscal::identify
