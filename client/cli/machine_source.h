// A machine as the command line names it: a machine.json, or the id of a stored one.
#ifndef AXISCAL_CLIENT_CLI_MACHINE_SOURCE_H_
#define AXISCAL_CLIENT_CLI_MACHINE_SOURCE_H_

#include <string>

#include "client/cli/context.h"
#include "core/machine/machine.h"

namespace axiscal::cli {

// The file of that name where there is one; no database is touched then.
absl::StatusOr<machine::Machine> MachineFrom(Context& context, const std::string& file_or_id);

}  // namespace axiscal::cli

#endif  // AXISCAL_CLIENT_CLI_MACHINE_SOURCE_H_
