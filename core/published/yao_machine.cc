#include "core/published/yao_machine.h"

namespace axiscal::published {

absl::Status CheckYaoMachine(const machine::Machine& machine) {
  std::string chain;
  for (const int axis : machine.tool_branch) chain += machine.axes[axis].name;
  chain += "|";
  for (const int axis : machine.work_branch) chain += machine.axes[axis].name;
  const bool turns_alike = chain == "ZYXB|C" && machine.axes[machine::FindAxis(machine, "B")].direction.y() == 1.0 &&
                           machine.axes[machine::FindAxis(machine, "C")].direction.z() == 1.0 &&
                           machine.tool_direction.z() == -1.0;
  if (turns_alike) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("machine ", machine.id, " is ", chain,
                   ", Yao's formulas are about a machine ZYXB|C whose B turns about +y, C about +z, tool along -z"));
}

}  // namespace axiscal::published
