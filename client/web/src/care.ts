// What a machine needs, from its calibrations, from what History.FindDrift tells of them, and from its events.
import { CalibrationState, type Calibration } from "./gen/axiscal/v1/calibration_pb";
import type { Event } from "./gen/axiscal/v1/events_service_pb";
import { DriftFindingKind, type DriftFinding } from "./gen/axiscal/v1/history_service_pb";

// In the order of need.
export type Care = "now" | "decide" | "unknown" | "good";
export const kCares: Care[] = ["now", "decide", "unknown", "good"];

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

// Jumps and doubts that the calibration in use cannot know of: they were found with later readings.
export function open(findings: DriftFinding[], inUse?: Calibration): DriftFinding[] {
  const kinds = [DriftFindingKind.STEP, DriftFindingKind.SUSPECT, DriftFindingKind.UNSTABLE];
  const later = findings.filter(
    (f) => kinds.includes(f.kind) && !f.isOver && (inUse === undefined || f.atUtcUs > measured(inUse)),
  );
  // A doubt that became a jump is told by the jump.
  const jumps = later.filter((f) => f.kind === DriftFindingKind.STEP);
  return jumps.length > 0 ? jumps : later;
}

// `news`: the machine's events that nobody has seen.
export function careOf(what: Known, findings: DriftFinding[] | undefined, news: Event[]): Care {
  if (news.length > 0 || (findings && open(findings, what.inUse).length > 0)) return "now";
  if (what.waiting.length > 0) return "decide";
  return what.inUse === undefined ? "unknown" : "good";
}
