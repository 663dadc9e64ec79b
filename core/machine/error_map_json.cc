#include "core/machine/error_map_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/base/units.h"
#include "core/machine/error_json.h"

namespace axiscal::machine {
namespace {

using json = nlohmann::ordered_json;
using shapes::Node;
using shapes::Tabulated;

constexpr size_t kMostNodes = 1000;  // of a map

absl::Status RefuseMap(const std::string& where, const std::string& what) {
  return absl::InvalidArgumentError(absl::StrCat("errors: ", where, ": ", what));
}

double UnitOf(const Machine& machine, int axis) {
  return machine.axes[axis].kind == AxisKind::kRotary ? base::kRadPerDeg : 1.0;
}

const char* NodesKey(const Machine& machine, int axis) {
  return machine.axes[axis].kind == AxisKind::kRotary ? "nodes_deg" : "nodes_mm";
}

// The nodes along one axis, each with its neighbours.
absl::StatusOr<std::vector<Node>> ReadNodes(const json& object, const std::string& where, const Machine& machine,
                                            int axis) {
  const char* const key = NodesKey(machine, axis);
  const auto it = object.find(key);
  if (it == object.end() || !it->is_array() || it->size() < 2)
    return RefuseMap(where, absl::StrCat("'", key, "', expected at least two numbers that rise"));
  std::vector<Node> nodes;
  double widest = 0.0;
  for (const json& number : *it) {
    if (!number.is_number() || !std::isfinite(number.get<double>()))
      return RefuseMap(where, absl::StrCat("'", key, "' holds ", number.dump(), ", expected a finite number"));
    Node node;
    node.at = number.get<double>() * UnitOf(machine, axis);
    if (!nodes.empty()) {
      const double gap = node.at - nodes.back().at;
      if (!(gap > 0.0)) return RefuseMap(where, absl::StrCat("'", key, "': ", number.dump(), " does not rise"));
      node.before = nodes.back().after = gap;
      widest = std::max(widest, gap);
    }
    nodes.push_back(node);
  }
  const double rest = 2.0 * std::numbers::pi - (nodes.back().at - nodes.front().at);
  constexpr double kGoesAround = 1.5;
  if (machine.axes[axis].kind == AxisKind::kRotary && rest > 1e-9 && rest <= kGoesAround * widest) {
    nodes.front().before = nodes.back().after = rest;
    for (Node& node : nodes) node.turn = 2.0 * std::numbers::pi;
  }
  return nodes;
}

absl::StatusOr<int> AxisOf(const json& object, const std::string& where, const Machine& machine,
                           const std::string& otherwise) {
  std::string name = otherwise;
  if (object.contains("variable")) {
    if (!object["variable"].is_string()) return RefuseMap(where, "'variable', expected an axis");
    name = object["variable"].get<std::string>();
  }
  const int axis = FindAxis(machine, name);
  if (axis < 0) return RefuseMap(where, absl::StrCat("variable '", name, "' is no axis of machine '", machine.id, "'"));
  return axis;
}

absl::StatusOr<std::vector<double>> ReadRow(const json& row, const std::string& where, size_t count, bool zero_mean) {
  const std::string expected = absl::StrCat("'values', expected ", count, " numbers in each row");
  if (!row.is_array() || row.size() != count) return RefuseMap(where, expected);
  std::vector<double> values;
  double sum = 0.0, largest = 0.0;
  for (const json& value : row) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) return RefuseMap(where, expected);
    values.push_back(value.get<double>());
    sum += values.back();
    largest = std::max(largest, std::abs(values.back()));
  }
  constexpr double kRounded = 1e-3;  // of the largest: files are rounded
  if (zero_mean && std::abs(sum) > kRounded * largest)
    return RefuseMap(where, absl::StrCat("'values' of a row sum to ", sum, ", zero_mean expects 0"));
  return values;
}

}  // namespace

absl::StatusOr<std::vector<ErrorTerm>> ReadErrorMap(const json& object, const std::string& where,
                                                    const Machine& machine, const ErrorSymbol& symbol) {
  ASSIGN_OR_RETURN(const int axis, AxisOf(object, where, machine, symbol.axis));
  ASSIGN_OR_RETURN(const std::vector<Node> nodes, ReadNodes(object, where, machine, axis));
  std::vector<Node> over = {Node{}};
  int over_axis = -1;
  if (object.contains("over")) {
    if (!object["over"].is_object()) return RefuseMap(where, "'over', expected an object with variable and nodes");
    ASSIGN_OR_RETURN(over_axis, AxisOf(object["over"], where + ".over", machine, ""));
    if (over_axis == axis) return RefuseMap(where, "'over' is the map's own variable");
    ASSIGN_OR_RETURN(over, ReadNodes(object["over"], where + ".over", machine, over_axis));
  }
  if (nodes.size() * over.size() > kMostNodes)
    return RefuseMap(where, absl::StrCat(nodes.size() * over.size(), " nodes, at most ", kMostNodes));
  if (object.contains("zero_mean") && !object["zero_mean"].is_boolean())
    return RefuseMap(where, "'zero_mean', expected true or false");
  const bool zero_mean = object.value("zero_mean", false);
  const bool has_values = object.contains("values");
  if (has_values == object.contains("amplitude") || (!has_values && object["amplitude"] != 0.0))
    return RefuseMap(where, "a map has 'values', or 'amplitude' 0 where it is asked for");
  const json rows = !has_values ? json() : over_axis < 0 ? json::array({object["values"]}) : object["values"];
  if (has_values && (!rows.is_array() || rows.size() != over.size()))
    return RefuseMap(where, absl::StrCat("'values', expected a row for each of ", over.size(), " nodes of 'over'"));
  std::vector<ErrorTerm> terms;
  for (size_t j = 0; j < over.size(); ++j) {
    std::vector<double> values(nodes.size(), 0.0);
    if (has_values) {
      ASSIGN_OR_RETURN(values, ReadRow(rows[j], where, nodes.size(), zero_mean));
    }
    for (size_t i = 0; i + (zero_mean ? 1 : 0) < nodes.size(); ++i) {
      ErrorTerm term = ConstantTerm(machine, symbol);
      term.shape = Tabulated{axis, nodes[i], zero_mean, zero_mean ? nodes.back() : Node{}, over_axis, over[j]};
      term.amplitude[0] = values[i] * AmplitudeFactor(term);
      terms.push_back(term);
    }
  }
  return terms;
}

size_t MapSize(std::span<const ErrorTerm> terms) {
  const auto& first = std::get<Tabulated>(terms[0].shape);
  size_t count = 1;
  while (count < terms.size()) {
    const auto* next = std::get_if<Tabulated>(&terms[count].shape);
    if (next == nullptr || terms[count].joint != terms[0].joint || terms[count].component != terms[0].component ||
        next->axis != first.axis || next->second_axis != first.second_axis || next->is_tied != first.is_tied ||
        (next->node == first.node && next->second == first.second))
      break;
    ++count;
  }
  return count;
}

json ErrorMapToJson(std::span<const ErrorTerm> map, const Machine& machine) {
  const auto& first = std::get<Tabulated>(map[0].shape);
  std::vector<double> nodes, over;
  const auto add = [](double at, std::vector<double>* to) {
    if (std::find(to->begin(), to->end(), at) == to->end()) to->push_back(at);
  };
  for (const ErrorTerm& term : map) {
    add(std::get<Tabulated>(term.shape).node.at, &nodes);
    add(std::get<Tabulated>(term.shape).second.at, &over);
  }
  if (first.is_tied) add(first.tied_to.at, &nodes);
  std::vector<std::vector<double>> values(over.size(), std::vector<double>(nodes.size(), 0.0));
  for (const ErrorTerm& term : map) {
    const auto& node = std::get<Tabulated>(term.shape);
    std::vector<double>& row = values[std::find(over.begin(), over.end(), node.second.at) - over.begin()];
    const double value = term.amplitude[0] / AmplitudeFactor(term);
    row[std::find(nodes.begin(), nodes.end(), node.node.at) - nodes.begin()] += value;
    if (node.is_tied) row.back() -= value;
  }
  const auto in_file = [&](std::vector<double> at, int axis) {
    for (double& position : at) position /= UnitOf(machine, axis);
    return at;
  };
  json object;
  object["symbol"] = SymbolOf(machine, map[0]);
  object["shape"] = Tabulated::kName;
  object["variable"] = machine.axes[first.axis].name;
  object[NodesKey(machine, first.axis)] = in_file(nodes, first.axis);
  if (first.is_tied) object["zero_mean"] = true;
  if (first.second_axis < 0) {
    object["values"] = values[0];
    return object;
  }
  object["over"] = {{"variable", machine.axes[first.second_axis].name},
                    {NodesKey(machine, first.second_axis), in_file(over, first.second_axis)}};
  object["values"] = values;
  return object;
}

}  // namespace axiscal::machine
