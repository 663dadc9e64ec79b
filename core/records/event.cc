#include "core/records/event.h"

namespace axiscal::records {

const char* WordOf(EventKind kind) {
  switch (kind) {
    case EventKind::kOutOfTolerance:
      return "out-of-tolerance";
    case EventKind::kLimitForecast:
      return "limit-forecast";
    case EventKind::kStep:
      return "step";
    case EventKind::kSuspect:
      return "suspect";
    case EventKind::kUnstable:
      return "unstable";
    case EventKind::kWear:
      return "wear";
    case EventKind::kScatter:
      return "scatter";
    case EventKind::kCalibrationOld:
      return "calibration-old";
    case EventKind::kSessionMissed:
      return "session-missed";
    case EventKind::kModelLacks:
      return "model-lacks";
    case EventKind::kRoutineFailed:
      return "routine-failed";
    case EventKind::kRoutineProposes:
      return "routine-proposes";
    case EventKind::kCellSilent:
      return "cell-silent";
    case EventKind::kCellProblem:
      return "cell-problem";
    case EventKind::kSessionRejected:
      return "session-rejected";
    case EventKind::kUnlikeGroup:
      return "unlike-group";
  }
  return "unknown";
}

const char* WordOf(EventChangeKind what) {
  switch (what) {
    case EventChangeKind::kRaised:
      return "raised";
    case EventChangeKind::kUpdated:
      return "updated";
    case EventChangeKind::kCleared:
      return "cleared";
    case EventChangeKind::kAcknowledged:
      return "acknowledged";
    case EventChangeKind::kShelved:
      return "shelved";
    case EventChangeKind::kBack:
      return "back";
  }
  return "changed";
}

}  // namespace axiscal::records
