#include "core/machine/error_json.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <span>

#include "core/base/json_members.h"
#include "core/base/strict_json.h"
#include "core/base/units.h"
#include "core/base/utf8.h"
#include "core/machine/error_covariance_json.h"
#include "core/machine/error_map_json.h"

namespace axiscal::machine {
namespace {

using base::kDegPerRad;
using base::kRadPerDeg;
using json = nlohmann::ordered_json;

absl::Status Refuse(const std::string& where, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("errors: ", where, ": ", what));
}

bool IsRotary(const Machine& machine, int axis) { return machine.axes[axis].kind == AxisKind::kRotary; }

absl::StatusOr<double> Number(const json& object, const std::string& where, const std::string& key) {
  const auto it = object.find(key);
  if (it == object.end()) return Refuse(where, absl::StrCat("'", key, "' is missing"));
  if (!it->is_number() || !std::isfinite(it->get<double>())) {
    return Refuse(where, absl::StrCat("'", key, "' = ", it->dump(), ", expected a finite number"));
  }
  return it->get<double>();
}

absl::StatusOr<double> PositiveNumber(const json& object, const std::string& where, const std::string& key) {
  ASSIGN_OR_RETURN(const double number, Number(object, where, key));
  if (number <= 0.0) return Refuse(where, absl::StrCat("'", key, "' = ", number, ", must be > 0"));
  return number;
}

absl::StatusOr<std::string> Text(const json& object, const std::string& where, const std::string& key) {
  const auto it = object.find(key);
  if (it == object.end()) return Refuse(where, absl::StrCat("'", key, "' is missing"));
  if (!it->is_string()) return Refuse(where, absl::StrCat("'", key, "' = ", it->dump(), ", expected a text"));
  return it->get<std::string>();
}

absl::StatusOr<ErrorSymbol> SymbolOfMachine(const std::string& text, const Machine& machine, const std::string& where) {
  const auto symbol = ParseErrorSymbol(text);
  if (!symbol.ok()) return base::Within("errors: " + where, symbol.status());
  if (FindJoint(machine, symbol->axis) < 0) {
    return Refuse(where, absl::StrCat("machine '", machine.id, "' has no axis ", symbol->axis));
  }
  return *symbol;
}

// The axis of the shape's variable: the field "variable", or the term's own axis.
absl::StatusOr<int> VariableOf(const json& object, const std::string& where, const Machine& machine,
                               const ErrorSymbol& symbol) {
  std::string name = symbol.axis;
  if (object.contains("variable")) {
    ASSIGN_OR_RETURN(name, Text(object, where, "variable"));
  }
  const int axis = FindAxis(machine, name);
  if (axis < 0) return Refuse(where, absl::StrCat("variable '", name, "' is no axis of machine '", machine.id, "'"));
  return axis;
}

absl::StatusOr<shapes::Shape> ReadHarmonic(const json& object, const std::string& where, const Machine& machine,
                                           int axis) {
  if (IsRotary(machine, axis)) {
    ASSIGN_OR_RETURN(const double order, PositiveNumber(object, where, "order"));
    return shapes::Harmonic{axis, order};
  }
  ASSIGN_OR_RETURN(const double period_mm, PositiveNumber(object, where, "period_mm"));
  return shapes::Harmonic{axis, 2.0 * std::numbers::pi / period_mm};
}

// "from_mm", "to_mm" with `prefix` in front; neither, for a rotary axis: a full turn.
absl::StatusOr<shapes::Span> ReadSpan(const json& object, const std::string& where, const std::string& prefix,
                                      const std::string& unit, double factor, bool may_turn) {
  const std::string from = absl::StrCat(prefix, "from_", unit), to = absl::StrCat(prefix, "to_", unit);
  for (const char* const other : {"mm", "deg", "s"}) {
    for (const char* const end : {"from_", "to_"}) {
      const std::string field = absl::StrCat(prefix, end, other);
      if (other != unit && object.contains(field))
        return Refuse(where,
                      absl::StrCat("'", field, "', expected '", from, "' and '", to, "': the unit of its variable"));
    }
  }
  if (may_turn && !object.contains(from) && !object.contains(to)) return shapes::Span{.is_turn = true};
  ASSIGN_OR_RETURN(const double low, Number(object, where, from));
  ASSIGN_OR_RETURN(const double high, Number(object, where, to));
  if (!(high > low)) return Refuse(where, absl::StrCat("'", to, "' = ", high, ", must be > '", from, "' = ", low));
  return shapes::Span{low * factor, high * factor};
}

absl::StatusOr<shapes::Span> SpanOfAxis(const json& object, const std::string& where, const std::string& prefix,
                                        const Machine& machine, int axis) {
  const bool is_rotary = IsRotary(machine, axis);
  return ReadSpan(object, where, prefix, is_rotary ? "deg" : "mm", is_rotary ? kRadPerDeg : 1.0, is_rotary);
}

// How many amplitudes a free curve has: those that stand there, or the usual number where it is asked for.
absl::StatusOr<int> CountAmplitudes(const json& object, const std::string& where, int usual) {
  const auto it = object.find("amplitudes");
  if (it == object.end()) return usual;
  if (!it->is_array() || it->empty() || it->size() > shapes::kMaxBasisCount)
    return Refuse(where, absl::StrCat("'amplitudes', expected a list of 1 to ", shapes::kMaxBasisCount, " numbers"));
  return static_cast<int>(it->size());
}

// The axis that "variable" names, or none.
absl::StatusOr<shapes::Times> ReadTimes(const json& object, const std::string& where, const Machine& machine,
                                        const ErrorSymbol& symbol) {
  if (!object.contains("variable")) return shapes::Times{};
  ASSIGN_OR_RETURN(const int axis, VariableOf(object, where, machine, symbol));
  return TimesPositionOf(machine, axis);
}

absl::StatusOr<shapes::Shape> ReadTimeCurve(const json& object, const std::string& where, const Machine& machine,
                                            const ErrorSymbol& symbol) {
  shapes::TimeCurve curve;
  ASSIGN_OR_RETURN(curve.times, ReadTimes(object, where, machine, symbol));
  ASSIGN_OR_RETURN(curve.span, ReadSpan(object, where, "", "s", 1.0, false));
  ASSIGN_OR_RETURN(curve.functions, CountAmplitudes(object, where, curve.functions));
  return curve;
}

absl::StatusOr<shapes::Shape> ReadDrift(const json& object, const std::string& where) {
  shapes::Drift drift;
  if (object.contains("from_s") || object.contains("to_s")) {
    ASSIGN_OR_RETURN(drift.from_s, Number(object, where, "from_s"));
    ASSIGN_OR_RETURN(drift.to_s, Number(object, where, "to_s"));
    if (drift.to_s < drift.from_s)
      return Refuse(where, absl::StrCat("'to_s' = ", drift.to_s, ", must be >= 'from_s' = ", drift.from_s));
  }
  return drift;
}

absl::StatusOr<shapes::Shape> ReadThermalLag(const json& object, const std::string& where, const Machine& machine,
                                             const ErrorSymbol& symbol) {
  shapes::ThermalLag lag;
  if (object.contains("channel")) {
    ASSIGN_OR_RETURN(lag.channel, Text(object, where, "channel"));
  }
  ASSIGN_OR_RETURN(lag.tau_s, Number(object, where, "tau_s"));
  if (lag.tau_s < 0.0) return Refuse(where, absl::StrCat("'tau_s' = ", lag.tau_s, ", must be >= 0"));
  ASSIGN_OR_RETURN(lag.times, ReadTimes(object, where, machine, symbol));
  if (object.contains("from_celsius") || object.contains("to_celsius")) {
    ASSIGN_OR_RETURN(lag.from_celsius, Number(object, where, "from_celsius"));
    ASSIGN_OR_RETURN(lag.to_celsius, Number(object, where, "to_celsius"));
    if (lag.to_celsius < lag.from_celsius)
      return Refuse(
          where, absl::StrCat("'to_celsius' = ", lag.to_celsius, ", must be >= 'from_celsius' = ", lag.from_celsius));
  }
  return lag;
}

absl::StatusOr<shapes::Shape> ReadCrossed(const json& object, const std::string& where, const Machine& machine,
                                          int axis) {
  shapes::Crossed crossed;
  crossed.axis = axis;
  ASSIGN_OR_RETURN(const std::string over, Text(object, where, "over"));
  crossed.second_axis = FindAxis(machine, over);
  if (crossed.second_axis < 0 || crossed.second_axis == axis)
    return Refuse(where, absl::StrCat("over '", over, "' is no other axis of machine '", machine.id, "'"));
  ASSIGN_OR_RETURN(crossed.span, SpanOfAxis(object, where, "", machine, axis));
  ASSIGN_OR_RETURN(crossed.second, SpanOfAxis(object, where, "over_", machine, crossed.second_axis));
  ASSIGN_OR_RETURN(const int count, CountAmplitudes(object, where, crossed.Count()));
  // No square of a whole number is another's less one: the count tells which of both it is.
  for (const bool has_singles : {true, false}) {
    crossed.has_singles = has_singles;
    for (crossed.each = 1; crossed.Count() < count;) ++crossed.each;
    if (crossed.Count() == count) return crossed;
  }
  return Refuse(where, absl::StrCat("'amplitudes' has ", count,
                                    " numbers, expected 3, 8, 15, 24, 35 or 48 (1 to 6 functions of each axis and the "
                                    "constant), or 1, 4, 9, 16, 25 or 36 (without the constant)"));
}

absl::StatusOr<shapes::Shape> ReadShape(const json& object, const std::string& where, const Machine& machine,
                                        const ErrorSymbol& symbol) {
  ASSIGN_OR_RETURN(const std::string name, Text(object, where, "shape"));
  if (name == shapes::Constant::kName) return shapes::Constant{};
  if (name == shapes::Drift::kName) return ReadDrift(object, where);
  if (name == shapes::Thermal::kName) return shapes::Thermal{};
  if (name == shapes::DriftExp::kName) {
    ASSIGN_OR_RETURN(const double tau_s, PositiveNumber(object, where, "tau_s"));
    ASSIGN_OR_RETURN(const shapes::Times times, ReadTimes(object, where, machine, symbol));
    return shapes::DriftExp{tau_s, times};
  }
  if (name == shapes::TimeCurve::kName) return ReadTimeCurve(object, where, machine, symbol);
  if (name == shapes::ThermalLag::kName) return ReadThermalLag(object, where, machine, symbol);
  ASSIGN_OR_RETURN(const int axis, VariableOf(object, where, machine, symbol));
  const bool is_rotary = IsRotary(machine, axis);
  if (name == shapes::Linear::kName) {
    return shapes::Linear{axis, is_rotary ? shapes::Linear::kReferenceRad : shapes::Linear::kReferenceMm};
  }
  if (name == shapes::Quadratic::kName) {
    return shapes::Quadratic{axis, is_rotary ? shapes::Quadratic::kReferenceRad : shapes::Quadratic::kReferenceMm};
  }
  if (name == shapes::Crossed::kName) return ReadCrossed(object, where, machine, axis);
  if (name == shapes::Curve::kName || name == shapes::BacklashCurve::kName) {
    shapes::Curve curve;
    curve.axis = axis;
    ASSIGN_OR_RETURN(curve.span, SpanOfAxis(object, where, "", machine, axis));
    ASSIGN_OR_RETURN(curve.functions, CountAmplitudes(object, where, curve.functions));
    if (name == shapes::Curve::kName) return curve;
    return shapes::BacklashCurve{curve};
  }
  if (name == shapes::Harmonic::kName) return ReadHarmonic(object, where, machine, axis);
  if (name == shapes::Backlash::kName) return shapes::Backlash{axis};
  if (name == shapes::Lag::kName) return shapes::Lag{axis};
  if (name == shapes::Acceleration::kName) return shapes::Acceleration{axis};
  if (name == shapes::Reversal::kName || name == shapes::Play::kName || name == shapes::LastMove::kName) {
    ASSIGN_OR_RETURN(double length, PositiveNumber(object, where, is_rotary ? "length_deg" : "length_mm"));
    if (is_rotary) length *= kRadPerDeg;
    if (name == shapes::Play::kName) return shapes::Play{axis, length};
    if (name == shapes::LastMove::kName) return shapes::LastMove{axis, length};
    return shapes::Reversal{axis, length};
  }
  return Refuse(where, absl::StrCat("unknown shape '", name, "'"));
}

absl::StatusOr<shapes::Shape> ReadApproachShape(const json& object, const std::string& where) {
  ASSIGN_OR_RETURN(const std::string name, Text(object, where, "shape"));
  if (name == shapes::PreTravel::kName) return shapes::PreTravel{};
  if (name != shapes::Lobe::kName)
    return Refuse(where, absl::StrCat("shape '", name, "', expected pre-travel or lobe of ", kAlongApproachSymbol));
  ASSIGN_OR_RETURN(const double order, PositiveNumber(object, where, "order"));
  constexpr double kHighest = 60.0;
  if (order != std::floor(order) || order > kHighest)
    return Refuse(where, absl::StrCat("'order' = ", order, ", expected a whole number from 1 to 60"));
  return shapes::Lobe{static_cast<int>(order)};
}

// What stands at one component of a joint, or along the approach of a touch.
absl::StatusOr<ErrorTerm> ReadPlaceAndShape(const json& object, const std::string& where, const Machine& machine) {
  ASSIGN_OR_RETURN(const std::string symbol_text, Text(object, where, "symbol"));
  if (symbol_text == kAlongApproachSymbol) {
    ASSIGN_OR_RETURN(const shapes::Shape shape, ReadApproachShape(object, where));
    return AlongApproachTerm(machine, shape);
  }
  ASSIGN_OR_RETURN(const ErrorSymbol symbol, SymbolOfMachine(symbol_text, machine, where));
  ErrorTerm term = ConstantTerm(machine, symbol);
  ASSIGN_OR_RETURN(term.shape, ReadShape(object, where, machine, symbol));
  if (symbol.is_constant != std::holds_alternative<shapes::Constant>(term.shape)) {
    return Refuse(where, absl::StrCat("symbol ", symbol_text, " does not go with shape '", shapes::Name(term.shape),
                                      "': a 0 in the symbol means constant"));
  }
  return term;
}

absl::Status RefuseUnknownFields(const json& object, const std::string& where) {
  static const std::set<std::string> kKnown = {
      "symbol",      "shape",        "variable",   "order",           "period_mm",  "length_mm",
      "length_deg",  "tau_s",        "amplitude",  "amplitude_sigma", "phase_deg",  "unit",
      "equivalent",  "nodes_deg",    "nodes_mm",   "zero_mean",       "over",       "values",
      "channel",     "from_mm",      "to_mm",      "from_deg",        "to_deg",     "from_s",
      "to_s",        "from_celsius", "to_celsius", "over_from_mm",    "over_to_mm", "over_from_deg",
      "over_to_deg", "amplitudes",   "prior_sigma"};
  for (const auto& [key, value] : object.items()) {
    if (!kKnown.contains(key)) return Refuse(where, absl::StrCat("unknown field '", key, "'"));
  }
  return absl::OkStatus();
}

absl::Status CheckUnit(const json& object, const std::string& where, const ErrorTerm& term, const Machine& machine) {
  if (!object.contains("unit")) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::string unit, Text(object, where, "unit"));
  if (unit == AmplitudeUnit(term, machine)) return absl::OkStatus();
  return Refuse(where, absl::StrCat("unit '", unit, "', expected '", AmplitudeUnit(term, machine), "'"));
}

// Of a free curve: all of them and their prior, or "amplitude": 0 where it is asked for.
absl::Status ReadAmplitudes(const json& object, const std::string& where, ErrorTerm* term) {
  const double factor = AmplitudeFactor(*term);
  if (object.contains("prior_sigma")) {
    ASSIGN_OR_RETURN(const double prior_sigma, PositiveNumber(object, where, "prior_sigma"));
    term->prior_sigma = prior_sigma * factor;
  }
  const auto list = object.find("amplitudes");
  if (list == object.end()) {
    if (object.contains("amplitude") && object["amplitude"] == 0.0) return absl::OkStatus();
    return Refuse(where, "a free curve has 'amplitudes', or 'amplitude' 0 where it is asked for");
  }
  for (size_t i = 0; i < list->size(); ++i) {
    const json& one = (*list)[i];
    if (!one.is_number() || !std::isfinite(one.get<double>()))
      return Refuse(where, absl::StrCat("'amplitudes'[", i, "] = ", one.dump(), ", expected a finite number"));
    term->amplitude[i] = one.get<double>() * factor;
  }
  return absl::OkStatus();
}

absl::StatusOr<ErrorTerm> ReadTerm(const json& object, const std::string& where, const Machine& machine) {
  if (!object.is_object()) return Refuse(where, "expected an object");
  RETURN_IF_ERROR(RefuseUnknownFields(object, where));
  ASSIGN_OR_RETURN(ErrorTerm term, ReadPlaceAndShape(object, where, machine));
  if (shapes::IsFree(term.shape)) {
    RETURN_IF_ERROR(ReadAmplitudes(object, where, &term));
    RETURN_IF_ERROR(CheckUnit(object, where, term, machine));
    return term;
  }
  for (const char* const key : {"amplitudes", "prior_sigma"}) {
    if (object.contains(key))
      return Refuse(where, absl::StrCat("'", key, "' does not go with shape '", shapes::Name(term.shape), "'"));
  }
  ASSIGN_OR_RETURN(double amplitude, Number(object, where, "amplitude"));
  amplitude *= AmplitudeFactor(term);
  term.amplitude = {amplitude, 0.0};
  if (shapes::HasPhase(term.shape)) {
    ASSIGN_OR_RETURN(const double phase_deg, Number(object, where, "phase_deg"));
    term.amplitude = {amplitude * std::cos(phase_deg * kRadPerDeg), amplitude * std::sin(phase_deg * kRadPerDeg)};
  }
  RETURN_IF_ERROR(CheckUnit(object, where, term, machine));
  return term;
}

// An entry of "terms": one term, or all nodes of a map.
absl::StatusOr<std::vector<ErrorTerm>> ReadTerms(const json& object, const std::string& where, const Machine& machine) {
  if (!object.is_object() || object.value("shape", json()) != shapes::Tabulated::kName) {
    ASSIGN_OR_RETURN(ErrorTerm term, ReadTerm(object, where, machine));
    return std::vector<ErrorTerm>{std::move(term)};
  }
  RETURN_IF_ERROR(RefuseUnknownFields(object, where));
  ASSIGN_OR_RETURN(const std::string symbol_text, Text(object, where, "symbol"));
  ASSIGN_OR_RETURN(const ErrorSymbol symbol, SymbolOfMachine(symbol_text, machine, where));
  if (symbol.is_constant)
    return Refuse(where,
                  absl::StrCat("symbol ", symbol_text, " does not go with shape 'tabulated': a 0 means constant"));
  ASSIGN_OR_RETURN(std::vector<ErrorTerm> map, ReadErrorMap(object, where, machine, symbol));
  RETURN_IF_ERROR(CheckUnit(object, where, map[0], machine));
  return map;
}

}  // namespace

double AmplitudeFactor(const ErrorTerm& term) { return IsAngle(term.component) ? base::kRadPerUrad : base::kMmPerUm; }

std::string AmplitudeUnit(const ErrorTerm& term, const Machine& machine) {
  const std::string unit = IsAngle(term.component) ? "urad" : "um";
  const std::optional<int> axis = shapes::VariableAxis(term.shape);
  const bool is_rotary = axis && IsRotary(machine, *axis);
  if (std::holds_alternative<shapes::Linear>(term.shape)) return unit + (is_rotary ? "/rad" : "/m");
  if (std::holds_alternative<shapes::Drift>(term.shape)) return unit + "/h";
  if (std::holds_alternative<shapes::Thermal>(term.shape)) return unit + "/K";
  if (const auto* times = shapes::TimesOf(term.shape)) {
    const std::string per_position = times->axis < 0 ? "" : is_rotary ? "rad" : "m";
    if (!std::holds_alternative<shapes::ThermalLag>(term.shape))
      return unit + (per_position.empty() ? "" : "/" + per_position);
    return unit + (per_position.empty() ? "/K" : "/(K " + per_position + ")");
  }
  if (std::holds_alternative<shapes::Lag>(term.shape)) return unit + (is_rotary ? "/(rad/s)" : "/(mm/s)");
  if (std::holds_alternative<shapes::Acceleration>(term.shape)) return unit + (is_rotary ? "/(rad/s^2)" : "/(mm/s^2)");
  return unit;
}

WrittenTerm Written(const ErrorTerm& term, const Machine& machine) {
  WrittenTerm written;
  written.symbol = SymbolOf(machine, term);
  written.shape = shapes::Name(term.shape);
  const std::optional<int> axis = shapes::VariableAxis(term.shape);
  if (axis) written.variable = machine.axes[*axis].name;
  if (const auto* map = std::get_if<shapes::Tabulated>(&term.shape)) {
    const auto position = [&](int of, double at) { return IsRotary(machine, of) ? at * kDegPerRad : at; };
    written.at = position(map->axis, map->node.at);
    if (map->second_axis >= 0) {
      written.over = machine.axes[map->second_axis].name;
      written.over_at = position(map->second_axis, map->second.at);
    }
  }
  const auto reached = [&](const shapes::Span& span, int of, std::optional<double> WrittenTerm::*from_deg,
                           std::optional<double> WrittenTerm::*to_deg, std::optional<double> WrittenTerm::*from_mm,
                           std::optional<double> WrittenTerm::*to_mm) {
    if (span.is_turn) return;
    const bool is_rotary = IsRotary(machine, of);
    const double unit = is_rotary ? kDegPerRad : 1.0;
    written.*(is_rotary ? from_deg : from_mm) = span.low * unit;
    written.*(is_rotary ? to_deg : to_mm) = span.high * unit;
  };
  const auto reached_by_variable = [&](const shapes::Span& span) {
    reached(span, *axis, &WrittenTerm::from_deg, &WrittenTerm::to_deg, &WrittenTerm::from_mm, &WrittenTerm::to_mm);
  };
  if (const auto* curve = shapes::CurveOf(term.shape)) reached_by_variable(curve->span);
  if (const auto* crossed = std::get_if<shapes::Crossed>(&term.shape)) {
    written.over = machine.axes[crossed->second_axis].name;
    reached_by_variable(crossed->span);
    reached(crossed->second, crossed->second_axis, &WrittenTerm::over_from_deg, &WrittenTerm::over_to_deg,
            &WrittenTerm::over_from_mm, &WrittenTerm::over_to_mm);
  }
  if (const auto* curve = std::get_if<shapes::TimeCurve>(&term.shape)) {
    written.from_s = curve->span.low;
    written.to_s = curve->span.high;
  }
  if (const auto* drift = std::get_if<shapes::Drift>(&term.shape)) {
    if (std::isfinite(drift->from_s)) written.from_s = drift->from_s;
    if (std::isfinite(drift->to_s)) written.to_s = drift->to_s;
  }
  if (const auto* lag = std::get_if<shapes::ThermalLag>(&term.shape)) {
    written.channel = lag->channel;
    written.tau_s = lag->tau_s;
    if (std::isfinite(lag->from_celsius)) written.from_celsius = lag->from_celsius;
    if (std::isfinite(lag->to_celsius)) written.to_celsius = lag->to_celsius;
  }
  if (const auto* harmonic = std::get_if<shapes::Harmonic>(&term.shape)) {
    if (IsRotary(machine, *axis)) {
      written.order = harmonic->frequency;
    } else {
      written.period_mm = 2.0 * std::numbers::pi / harmonic->frequency;
    }
  } else if (const auto* lobe = std::get_if<shapes::Lobe>(&term.shape)) {
    written.variable = "approach";
    written.lobes = lobe->order;
  } else if (std::holds_alternative<shapes::PreTravel>(term.shape)) {
    written.variable = "approach";
  } else if (shapes::HasLength(term.shape)) {
    const bool is_rotary = IsRotary(machine, *axis);
    const double length = *shapes::NonlinearParameter(term.shape);
    (is_rotary ? written.length_deg : written.length_mm) = is_rotary ? length * kDegPerRad : length;
  } else if (const auto* drift = std::get_if<shapes::DriftExp>(&term.shape)) {
    written.tau_s = drift->tau_s;
  }
  return written;
}

absl::StatusOr<ErrorModel> ReadErrors(const std::string& text, const Machine& machine) {
  const auto parsed = base::ParseStrictJson(text);
  if (!parsed.ok()) return base::Within("errors", parsed.status());
  const json& root = *parsed;
  if (!root.is_object())
    return absl::InvalidArgumentError("errors: expected an object {\"EA0B\": -101.2, ...} in um and urad");
  ErrorModel model;
  std::set<std::pair<std::string, double>> names;  // of one name two decays may differ in their lengths
  const auto add = [&](const ErrorTerm& term, const std::string& where) {
    const double* length = shapes::NonlinearParameter(term.shape);
    if (!names.emplace(NameOf(machine, term), length == nullptr ? 0.0 : *length).second)
      return Refuse(where, absl::StrCat(NameOf(machine, term), " is there twice"));
    model.terms.push_back(term);
    return absl::OkStatus();
  };
  for (const auto& [key, value] : root.items()) {
    if (key == "terms" || key == kCovarianceKey) continue;
    ASSIGN_OR_RETURN(const ErrorSymbol symbol, SymbolOfMachine(key, machine, key));
    if (!symbol.is_constant) {
      return Refuse(key, absl::StrCat("is not constant, expected E", std::string(1, Letter(symbol.component)), "0",
                                      symbol.axis, " or an entry of \"terms\" with a shape"));
    }
    ASSIGN_OR_RETURN(const double amplitude, Number(root, key, key));
    ErrorTerm term = ConstantTerm(machine, symbol);
    term.amplitude[0] = amplitude * AmplitudeFactor(term);
    RETURN_IF_ERROR(add(term, key));
  }
  const auto terms = root.find("terms");
  if (terms != root.end() && !terms->is_array()) return Refuse("terms", "expected an array");
  for (size_t i = 0; terms != root.end() && i < terms->size(); ++i) {
    const std::string where = absl::StrCat("terms[", i, "]");
    ASSIGN_OR_RETURN(const std::vector<ErrorTerm> read, ReadTerms((*terms)[i], where, machine));
    for (const ErrorTerm& term : read) RETURN_IF_ERROR(add(term, where));
  }
  if (root.contains(kCovarianceKey))
    RETURN_IF_ERROR(ReadWrittenCovariance(root[kCovarianceKey], machine, model).status());
  return model;
}

absl::StatusOr<ErrorModel> ReadAskedError(const std::string& text, const Machine& machine) {
  json errors;
  if (text.starts_with('{')) {
    ASSIGN_OR_RETURN(json term, base::ParseStrictJson(text));
    if (term.is_object() && !term.contains("amplitudes")) term["amplitude"] = 0.0;
    errors["terms"] = json::array({std::move(term)});
  } else {
    if (!base::IsUtf8(text)) return Refuse(base::ToUtf8(text), "expected the symbol of an error in UTF-8");
    errors[text] = 0.0;
  }
  return ReadErrors(errors.dump(), machine);
}

absl::StatusOr<std::vector<std::string>> ListErrors(const std::string& text) {
  ASSIGN_OR_RETURN(const json root, base::ParseStrictJson(text));
  if (!root.is_object()) return absl::InvalidArgumentError("expected an object, as errors.json");
  std::vector<std::string> errors;
  for (const auto& [key, value] : root.items()) {
    if (key == kCovarianceKey) continue;
    if (key != "terms") {
      errors.push_back(key);
      continue;
    }
    if (!value.is_array()) return absl::InvalidArgumentError("terms: expected an array");
    for (json term : value) {
      if (!term.is_object()) return absl::InvalidArgumentError("terms: expected objects");
      term.erase("amplitude");
      term.erase("values");
      const auto amplitudes = term.find("amplitudes");  // how many, not which
      if (amplitudes != term.end() && amplitudes->is_array())
        *amplitudes = json(std::vector<double>(amplitudes->size(), 0.0));
      errors.push_back(term.dump());
    }
  }
  if (errors.empty()) return absl::InvalidArgumentError("no error in it");
  return errors;
}

std::string WriteErrors(const ErrorModel& model, const Machine& machine, const WrittenCovariance& covariance) {
  std::string text = WriteErrors(model, machine);
  const WrittenCovariance known = OfWritten(covariance, machine, model);
  if (known.of.empty() || known.of.size() > kMostCovarianceNumbers) return text;
  text.resize(text.rfind("\n}"));
  return absl::StrCat(text, ",\n \"", kCovarianceKey, "\": ", CovarianceText(known), "\n}\n");
}

std::string WriteErrors(const ErrorModel& found, const Machine& machine) {
  const ErrorModel model = NamedErrors(found);
  json root = json::object();
  json terms = json::array();
  for (size_t i = 0; i < model.terms.size(); ++i) {
    const ErrorTerm& term = model.terms[i];
    const double factor = AmplitudeFactor(term);
    if (std::holds_alternative<shapes::Tabulated>(term.shape)) {
      const auto map = std::span(model.terms).subspan(i, MapSize(std::span(model.terms).subspan(i)));
      terms.push_back(ErrorMapToJson(map, machine));
      terms.back()["unit"] = AmplitudeUnit(term, machine);
      i += map.size() - 1;
      continue;
    }
    if (std::holds_alternative<shapes::Constant>(term.shape)) {
      root[SymbolOf(machine, term)] = term.amplitude[0] / factor;
      continue;
    }
    json object = json::object();
    base::JsonWriter io(&object);
    Members(io, Written(term, machine));
    if (shapes::IsFree(term.shape)) {
      object["amplitudes"] = json::array();
      for (int k = 0; k < shapes::BasisCount(term.shape); ++k)
        object["amplitudes"].push_back(term.amplitude[k] / factor);
      if (term.prior_sigma > 0.0) object["prior_sigma"] = term.prior_sigma / factor;
      object["unit"] = AmplitudeUnit(term, machine);
      terms.push_back(object);
      continue;
    }
    object["amplitude"] = term.amplitude[0] / factor;
    if (shapes::HasPhase(term.shape)) {
      object["amplitude"] = std::hypot(term.amplitude[0], term.amplitude[1]) / factor;
      object["phase_deg"] = std::atan2(term.amplitude[1], term.amplitude[0]) * kDegPerRad;
    }
    object["unit"] = AmplitudeUnit(term, machine);
    terms.push_back(object);
  }
  if (!terms.empty()) root["terms"] = terms;
  return root.dump(1) + "\n";
}

}  // namespace axiscal::machine
