// What of the engine's reports (docs/formats.md) the pages show. Fields that a report leaves out are optional.
import { numberText } from "./format";

export interface Fit {
  rms_um?: number;
  max_um?: number;
  chi2_per_dof?: number;
  readings?: number;
}
export interface Warning {
  kind: string;
  text: string;
  text_de?: string; // of a report of an earlier version: none
}
export interface SessionFit {
  session: string;
  readings: number;
  rms_um: number;
  max_um: number;
}
export interface IdentificationReport {
  coverage_factor?: number;
  fit?: Fit;
  warnings?: Warning[];
  sessions?: SessionFit[];
}
export interface BoxError {
  rms_um: number;
  low_um: number;
  high_um: number;
}
export interface Cause {
  kind: string;
  subject: string;
  evidence: number;
  correction: string;
  subject_de?: string; // of a report of an earlier version: none
  correction_de?: string;
}
export interface LoopReport {
  verdict: "adequate" | "extended" | "unexplained";
  coverage_factor?: number;
  warnings?: Warning[];
  sessions?: SessionFit[];
  effects: {
    name: string;
    amplitude: number;
    amplitude_sigma: number;
    unit: string;
    rms_um: number;
    equivalent?: { name: string; tau_s?: number; length_mm?: number }[];
    same_always?: (string | { name: string })[];
  }[];
  causes?: Cause[];
  held_back?: { kind: string; subject: string; evidence: number; harm: number; measure: string }[];
  fit: { before: Fit; after: Fit };
  check?: { before?: Fit; after?: Fit; fitted?: boolean };
  volumetric?: {
    box: { axis: string; from: number; to: number; unit: string }[];
    poses: number;
    uncorrected: BoxError;
    before: BoxError;
    after: BoxError;
    gain_is_held: boolean;
    unknown?: string[];
  };
  steps: { change: string; name: string; rms_um: number }[];
  unexplained: {
    kind: string;
    variable?: string;
    from?: number;
    to?: number;
    unit?: string;
    session?: string;
    rms_um?: number;
  }[];
  next_measurement?: {
    effect: string;
    session: string | null;
    test?: string;
    text?: string;
    separates?: string[];
    correlation_before?: number;
    correlation_after?: number;
    beyond?: string;
  }[];
  noise?: { session: string; stated_sigma_um: number; sigma_um: number }[];
  not_visible?: string[];
  axes_at_rest?: string[];
}
export interface Peak {
  max_um: number;
  rms_um: number;
}
// Moves that follow each other, with the extremes of what is in them.
export interface PathStretch {
  first: number;
  last: number;
  way_mm: number;
  correction: Record<string, { low_um: number; high_um: number }>;
  before_max_um: number;
  after_max_um: number;
}
export interface CompensationReport {
  calibration: string;
  calibration_warnings?: Warning[];
  calibration_causes?: Cause[];
  null_correction: boolean;
  blocks: { read: number; corrected: number; split: number; passed: number; refused: number; going_back?: number };
  ways_back?: { line: number; block: string; way_um: number }[];
  passed?: { line: number; block: string; reason: string }[];
  correction: Record<string, Peak>;
  tool_point_error?: { before: Peak; after: Peak };
  not_corrected: { first: number; last: number; reason: string }[];
  ranges_not_corrected: number;
  refused?: { line: number; block: string; reason: string }[];
  path?: PathStretch[];
  missing?: string[];
  shifts?: { tool: string; work_offset: string; moves: number; max_um: number; rms_um: number; line: number }[];
  notes: string[];
  note_kinds?: { kind: string; line?: number | null }[]; // of each of them
}

// Whether a person must read more of it than that it was made.
export const isDoubtful = (report: CompensationReport): boolean =>
  report.null_correction ||
  [report.calibration_warnings, report.calibration_causes, report.not_corrected, report.ways_back].some((list) => (list ?? []).length > 0);

export function nameOf(one: string | { name: string }): string {
  return typeof one === "string" ? one : one.name;
}

// What an effect may be instead: of its own name with another time constant or length, which the name does not say.
export const besideText = (name: string, other: { name: string; tau_s?: number; length_mm?: number }) =>
  other.name !== name
    ? other.name
    : other.tau_s !== undefined
      ? `${other.name} (τ = ${numberText(other.tau_s)} s)`
      : other.length_mm !== undefined
        ? `${other.name} (${numberText(other.length_mm)} mm)`
        : other.name;
