#include "core/records/job_params.h"

namespace axiscal::records {

std::string KindOf(const JobParams& params) {
  if (std::holds_alternative<IdentifyParams>(params)) return kIdentify;
  if (std::holds_alternative<ToolSetterParams>(params)) return kToolSetter;
  return std::holds_alternative<CloseLoopParams>(params) ? kCloseLoop : kCompensate;
}

const MachineId& MachineOf(const JobParams& params) {
  return std::visit([](const auto& kind) -> const MachineId& { return kind.machine; }, params);
}

}  // namespace axiscal::records
