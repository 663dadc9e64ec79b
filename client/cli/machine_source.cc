#include "client/cli/machine_source.h"

#include <filesystem>

#include "core/machine/machine_json.h"

namespace axiscal::cli {

absl::StatusOr<machine::Machine> MachineFrom(Context& context, const std::string& file_or_id) {
  std::error_code error;
  if (std::filesystem::is_regular_file(file_or_id, error)) return machine::ReadMachineFile(file_or_id);
  ASSIGN_OR_RETURN(client::Client * client, context.Connect());
  ASSIGN_OR_RETURN(const records::MachineRecord record, client->GetMachine(MachineId(file_or_id)));
  return machine::MachineFromJson(record.description_json);
}

}  // namespace axiscal::cli
