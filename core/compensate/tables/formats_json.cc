#include <nlohmann/json.hpp>

#include "core/compensate/tables/format.h"

namespace axiscal::tables {

std::string FormatsJson() {
  using json = nlohmann::ordered_json;
  json list = json::array();
  for (const Format& format : Formats()) {
    const Limits& limits = format.limits;
    json entry = {{"name", format.name}, {"title", format.title}, {"values", format.values}};
    entry["limits"] = {
        {"text", LimitsText(format)},
        {"max_points", limits.max_points > 0 ? json(limits.max_points) : json()},
        {"equal_steps", limits.equal_steps},
        {"by_sense", limits.by_sense},
        {"one_axis_per_file", limits.one_axis},
        {"rotary_axes", limits.holds_rotary},
        {"value_step_mm", limits.value_step_mm},
        {format.layout == Layout::kComponents ? "value_step_rad" : "value_step_deg", limits.value_step_deg}};
    entry["assumed"] = format.assumed;
    entry["cannot_carry"] = format.cannot_carry;
    list.push_back(std::move(entry));
  }
  return list.dump(1) + "\n";
}

}  // namespace axiscal::tables
