#include "core/records/routine.h"

namespace axiscal::records {

std::string NameOf(RunState state) {
  switch (state) {
    case RunState::kWaiting:
      return "waiting";
    case RunState::kRunning:
      return "running";
    case RunState::kAgrees:
      return "agrees";
    case RunState::kProposed:
      return "proposed";
    case RunState::kApproved:
      return "approved";
    case RunState::kFailed:
      return "failed";
    case RunState::kStopped:
      return "stopped";
  }
  return "state " + std::to_string(static_cast<int>(state));
}

}  // namespace axiscal::records
