// Machine descriptions of any bytes: a valid machine, or an error; what was read is written and read again as the same.
#include "core/machine/machine_json.h"
#include "tests/fuzz/driver.h"

namespace axiscal::fuzz {

void Look(const std::string& bytes) {
  const auto read = machine::MachineFromJson(bytes);
  MUST(read.ok() || absl::IsInvalidArgument(read.status()));
  if (!read.ok()) return;
  MUST(machine::Validate(*read).ok());
  const std::string text = machine::MachineToJson(*read);
  const auto again = machine::MachineFromJson(text);
  MUST(again.ok());
  // Directions are normalised once more: the last digit may differ, the rest may not.
  MUST(again->axis_count() == read->axis_count() && again->id == read->id);
  MUST(again->tool_branch == read->tool_branch && again->work_branch == read->work_branch);
  MUST(again->declared.size() == read->declared.size());
  for (int i = 0; i < read->axis_count(); ++i) {
    MUST(again->axes[i].name == read->axes[i].name && again->axes[i].kind == read->axes[i].kind);
    MUST(again->axes[i].direction.isApprox(read->axes[i].direction, 1e-15 * 8));
    MUST(again->axes[i].point_mm == read->axes[i].point_mm);
  }
}

}  // namespace axiscal::fuzz
