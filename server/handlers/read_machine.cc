#include "server/handlers/read_machine.h"

#include "core/base/error_detail.h"
#include "core/machine/machine_json.h"

namespace axiscal::handlers {

absl::StatusOr<machine::Machine> ReadMachine(const std::string& description_json) {
  absl::StatusOr<machine::Machine> machine = machine::MachineFromJson(description_json);
  if (machine.ok()) return machine;
  const std::string message(machine.status().message());
  return base::Error(machine.status().code(), message,
                     {"MACHINE_INVALID", {{"field", "description_json"}, {"rule", message}}});
}

}  // namespace axiscal::handlers
