// machine.json (docs/formats.md): a machine's description as its users write it. Lengths mm, travel of rotary axes deg.
// Members: id, structure (optional), axes, tool_branch, work_branch, tool_direction, declared (optional); `note` and
// `source` are texts that are ignored and not kept. Of an axis: kind, direction, point_mm (rotary), and optional
// travel_mm (linear) or travel_deg (rotary) [min, max].
#ifndef AXISCAL_CORE_MACHINE_MACHINE_JSON_H_
#define AXISCAL_CORE_MACHINE_MACHINE_JSON_H_

#include <string>

#include "core/base/status.h"
#include "core/machine/machine.h"

namespace axiscal::machine {

// A valid machine (see Validate). Its axes stand in the order of the branches, tool branch first, from the bed
// outwards: the order of JSON members means nothing. Directions are normalised, so that one written with six decimals
// is a unit vector to the last digit. INVALID_ARGUMENT with field, value and rule: "axes.B.direction: [0,2,0], must
// have length 1".
absl::StatusOr<Machine> MachineFromJson(const std::string& text);

// The same from a file, its path in front of the message; NOT_FOUND when there is none.
absl::StatusOr<Machine> ReadMachineFile(const std::string& path);

// One line per axis; reads back as an equal machine.
std::string MachineToJson(const Machine& machine);

}  // namespace axiscal::machine

#endif  // AXISCAL_CORE_MACHINE_MACHINE_JSON_H_
