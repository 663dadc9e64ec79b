// Error maps in errors.json: all nodes of a tabulated error in one entry.
//   {"symbol": "EYC", "shape": "tabulated", "variable": "C", "nodes_deg": [0, 60, 120, 180, 240, 300],
//    "zero_mean": true, "over": {"variable": "A", "nodes_deg": [-90, -60, -30, 0]},
//    "values": [[1.5, ...], ...], "unit": "um"}
// `values` has a row per node of `over` (without `over`: one list), a number per node of `variable`; `nodes_mm` for a
// linear axis. Nodes of a rotary axis go once around when the gap that they leave over 360 deg is at most 1.5 times
// their widest. `zero_mean`: each row sums to zero. "amplitude": 0 in place of `values` asks for the map (identify).
#ifndef AXISCAL_CORE_MACHINE_ERROR_MAP_JSON_H_
#define AXISCAL_CORE_MACHINE_ERROR_MAP_JSON_H_

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "core/machine/error_model.h"

namespace axiscal::machine {

// One term per node (the last of a zero-mean row is minus the others). INVALID_ARGUMENT naming `where`, field and rule:
// fewer than two nodes, nodes that do not rise, rows of another size, a zero-mean row that does not sum to zero.
absl::StatusOr<std::vector<ErrorTerm>> ReadErrorMap(const nlohmann::ordered_json& object, const std::string& where,
                                                    const Machine& machine, const ErrorSymbol& symbol);

// How many of `terms`, from the first (a tabulated one) on, are nodes of one map.
size_t MapSize(std::span<const ErrorTerm> terms);
// The entry of such a map, without its unit.
nlohmann::ordered_json ErrorMapToJson(std::span<const ErrorTerm> map, const Machine& machine);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_ERROR_MAP_JSON_H_
