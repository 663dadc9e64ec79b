// A machine description as it comes over the wire.
#ifndef AXISCAL_SERVER_HANDLERS_READ_MACHINE_H_
#define AXISCAL_SERVER_HANDLERS_READ_MACHINE_H_

#include <string>

#include "core/base/status.h"
#include "core/machine/machine.h"

namespace axiscal::handlers {

// machine::MachineFromJson with reason MACHINE_INVALID and the field `description_json`.
absl::StatusOr<machine::Machine> ReadMachine(const std::string& description_json);

}  // namespace axiscal::handlers

#endif  // AXISCAL_SERVER_HANDLERS_READ_MACHINE_H_
