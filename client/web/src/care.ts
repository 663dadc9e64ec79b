// Which calibrations count for a machine's page, and what the one in use cannot know of. For a whole fleet the server says it (History.ListCare).
import { CalibrationState, type Calibration } from "./gen/axiscal/v1/calibration_pb";
import { DriftFindingKind, type DriftFinding } from "./gen/axiscal/v1/history_service_pb";

export interface Known {
  inUse?: Calibration;
  waiting: Calibration[]; // candidates that were measured later than what is in use
}

const measured = (calibration: Calibration) => calibration.provenance?.measuredUtcUs ?? 0n;

export function known(calibrations: Calibration[]): Known {
  const inUse = calibrations.find((c) => c.state === CalibrationState.APPROVED);
  const waiting = calibrations.filter(
    (c) => c.state === CalibrationState.CANDIDATE && (inUse === undefined || measured(c) > measured(inUse)),
  );
  return { inUse, waiting };
}

// Jumps and doubts that the calibration in use cannot know of: it was measured before what they were found with.
export function open(findings: DriftFinding[], inUse?: Calibration): DriftFinding[] {
  const kinds = [DriftFindingKind.STEP, DriftFindingKind.SUSPECT, DriftFindingKind.UNSTABLE];
  const later = findings.filter(
    (f) => kinds.includes(f.kind) && !f.isOver && (inUse === undefined || (f.byUtcUs ?? f.atUtcUs) > measured(inUse)),
  );
  // A doubt that became a jump is told by the jump.
  const jumps = later.filter((f) => f.kind === DriftFindingKind.STEP);
  return jumps.length > 0 ? jumps : later;
}
