// Numbers and dates as the reader's language writes them. Values come in um and urad from the API and are not converted.
import { EstimateUnit } from "./gen/axiscal/v1/calibration_pb";
import type { VolumetricFigures } from "./gen/axiscal/v1/volumetric_pb";
import { language } from "./text";

// To make a format costs a hundred times what it costs to use one, so each is made once. A page of a hundred machines writes hundreds of
// numbers and dates at each key.
const kNumberFormats = new Map<string, Intl.NumberFormat>();
const kDateFormats = new Map<string, Intl.DateTimeFormat>();
function kept<Format, Options>(
  formats: Map<string, Format>,
  make: new (locale: string, options: Options) => Format,
  options: Options,
): Format {
  const locale = language.value === "de" ? "de-DE" : "en-GB";
  const key = locale + JSON.stringify(options);
  let format = formats.get(key);
  if (format === undefined) formats.set(key, (format = new make(locale, options)));
  return format;
}
const numbers = (options: Intl.NumberFormatOptions = {}) => kept(kNumberFormats, Intl.NumberFormat, options);
const dates = (options: Intl.DateTimeFormatOptions) => kept(kDateFormats, Intl.DateTimeFormat, options);

// A value to the digits that its uncertainty allows: two digits of sigma; without one, four digits.
export function valueText(value: number, sigma?: number): string {
  if (sigma !== undefined && sigma > 0 && Number.isFinite(sigma)) {
    const digits = Math.min(6, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
    return numbers({ minimumFractionDigits: digits, maximumFractionDigits: digits }).format(
      sigma > 100 ? Math.round(value) : value,
    );
  }
  return numbers({ maximumSignificantDigits: 4 }).format(value);
}
export function sigmaText(sigma: number): string {
  return numbers({ minimumSignificantDigits: 2, maximumSignificantDigits: 2 }).format(sigma);
}
export function numberText(value: number, digits = 3): string {
  return numbers({ maximumSignificantDigits: digits }).format(value);
}
// Of a share, signed: "−42 %".
export function percentText(share: number): string {
  return numbers({ style: "percent", maximumFractionDigits: 1, signDisplay: "exceptZero" }).format(-share);
}
// Of a certainty, in percent. Never "100": nothing measured is.
export function certaintyText(share: number): string {
  return share > 0.9994 ? `> ${numberText(99.9)}` : numberText(100 * share);
}
// "0,03"; a small one only says that it is small.
export function probabilityText(value: number): string {
  return value < 0.001 ? `< ${numberText(0.001)}` : numberText(value, 2);
}
export function countText(value: number | bigint): string {
  return numbers().format(value);
}
export function unitText(unit: EstimateUnit | string): string {
  const name = typeof unit === "string" ? unit : unit === EstimateUnit.UM ? "um" : unit === EstimateUnit.URAD ? "urad" : "";
  return name.replace(/^um$/, "µm").replace(/^urad$/, "µrad").replace(/^deg$/, "°");
}

// Units and signs of the server's own sentences, which are ASCII, as people write them: "-50 .. 50 um" is "-50 … 50 µm". Prose alone: names,
// files and code stay as they are.
export function proseText(text: string): string {
  return text
    .replace(/(?<![\w-])(um|urad)(?![\w-])/g, (name) => unitText(name))
    .replaceAll(" +- ", " ± ")
    .replaceAll(" .. ", " … ");
}

// Of microseconds since 1970; they fit a double until the year 2255.
export function dateOf(us: bigint): Date {
  return new Date(Number(us / 1000n));
}
export function dayText(us: bigint): string {
  return dates({ dateStyle: "medium" }).format(dateOf(us));
}
export function timeText(us: bigint): string {
  return dates({ dateStyle: "medium", timeStyle: "short" }).format(dateOf(us));
}
export function nowText(): string {
  return dates({ dateStyle: "medium", timeStyle: "short" }).format(new Date());
}
export function secondsText(us: bigint): string {
  const s = Number(us) / 1e6;
  if (s < 120) return `${numberText(s, 2)} s`;
  return s < 7200 ? `${numberText(s / 60, 2)} min` : `${numberText(s / 3600, 2)} h`;
}
export function bytesText(bytes: bigint): string {
  const n = Number(bytes);
  return n < 10_000 ? `${countText(n)} B` : n < 1e6 ? `${numberText(n / 1e3)} kB` : `${numberText(n / 1e6)} MB`;
}

// Numbers of files, which programs read: with a point, in full.
export function csv(head: string[], rows: (string | number | undefined)[][]): string {
  const cell = (value: string | number | undefined) => {
    const text = value === undefined ? "" : String(value);
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [head, ...rows].map((row) => row.map(cell).join(",") + "\r\n").join("");
}
export function save(name: string, type: string, content: BlobPart): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement("a");
  link.href = url;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

// "1.77 [1.6, 1.9]": a tool point's error over its box with 95 %, µm. A nanometre and less is nothing that anybody knows.
const kLeastUm = 0.001;
const micrometresText = (um: number) => (um < kLeastUm ? `< ${numberText(kLeastUm)}` : numberText(um));
export const figureText = (figures?: VolumetricFigures) =>
  figures?.rms === undefined
    ? "–"
    : `${micrometresText(figures.rms.expectedUm)} [${micrometresText(figures.rms.lowUm)}${language.value === "de" ? ";" : ","} ${micrometresText(figures.rms.highUm)}]`;
