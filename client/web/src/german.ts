// What the server writes in English, in German: worded from kinds and facts of the API, never by reading the English. Each returns nothing where
// the reader's language is English, or the kind is not known here: the server's own words stand then.
import { DriftFindingKind, type DriftAmount, type DriftFinding, type LimitForecast, type StandingFinding } from "./gen/axiscal/v1/history_service_pb";
import { EventKind, type Event } from "./gen/axiscal/v1/events_service_pb";
import type { TableFormat } from "./gen/axiscal/v1/tables_service_pb";
import { certaintyText, dayText, numberText, sigmaText, timeText, unitText, valueText } from "./format";
import { errorsIn } from "./iso";
import { language } from "./text";

// `isWhole`: it says all that the English says. Else the English stands beside it, folded.
export interface Said {
  text: string;
  isWhole: boolean;
}

const isGerman = () => language.value === "de";
const and = (words: string[]) => (words.length < 2 ? words.join("") : `${words.slice(0, -1).join(", ")} und ${words[words.length - 1]}`);
const symbolsOf = (amounts: DriftAmount[]) => and(amounts.map((a) => a.symbol));
const sizesOf = (amounts: DriftAmount[]) => and(amounts.map((a) => `${valueText(a.size, a.sigma)} ${unitText(a.unit)}`));
const withSigma = (a: DriftAmount) => `${valueText(a.size, a.sigma)} ± ${sigmaText(a.sigma)} ${unitText(a.unit)}`;
const sure = (certainty?: number) => (certainty === undefined ? "" : `, Sicherheit ${certaintyText(certainty)} %`);
// "zwischen 21.09.2026 und 05.10.2026", of one day with the time.
function between(after: bigint, by: bigint): string {
  const say = dayText(after) === dayText(by) ? timeText : dayText;
  return `zwischen ${say(after)} und ${say(by)}`;
}

function jumped(amounts: DriftAmount[], after: bigint, by: bigint, certainty?: number): string {
  const together = amounts.length > 1 ? "sind" : "ist";
  return `${between(after, by)} ${together} ${symbolsOf(amounts)} ${amounts.length > 1 ? "zusammen " : ""}gesprungen, um ${sizesOf(amounts)}${sure(certainty)}`;
}
const wears = (a: DriftAmount, certainty?: number) => `${a.symbol} verschleißt um ${withSigma(a)} im Jahr${sure(certainty)}`;
const notStable = (from: bigint, to: bigint) =>
  `die Kalibrierungen von ${dayText(from)} bis ${dayText(to)} passen weder zu denen davor noch zueinander: die Maschine oder die Messung ist nicht stabil, und ihr Verlauf beginnt neu`;
const offBy = (calibration: string, amounts: DriftAmount[], certainty?: number) =>
  `in der ${calibration} ${amounts.length > 1 ? "liegen" : "liegt"} ${symbolsOf(amounts)} neben dem Erwarteten, um ${sizesOf(amounts)}: eine schlechte Kalibrierung oder ein Sprung. Wiederholen${sure(certainty)}`;

function findingOf(f: DriftFinding): Said | undefined {
  const all = (text: string): Said => ({ text, isWhole: true });
  const a = f.amounts[0];
  switch (f.kind) {
    case DriftFindingKind.STEP:
      return f.afterUtcUs === undefined || f.byUtcUs === undefined
        ? undefined
        : all((f.isRevision ? "berichtigt: " : "") + jumped(f.amounts, f.afterUtcUs, f.byUtcUs, f.certainty));
    case DriftFindingKind.RETRACTION:
      return f.afterUtcUs === undefined || f.byUtcUs === undefined
        ? undefined
        : all(`${and(errorsIn(f.text))} ging zurück: was als Sprung ${between(f.afterUtcUs, f.byUtcUs)} gemeldet war, war eher eine schlechte Kalibrierung`);
    case DriftFindingKind.SUSPECT:
      return all(offBy(`Kalibrierung vom ${dayText(f.atUtcUs)}`, f.amounts, f.certainty));
    case DriftFindingKind.SLOPE:
      if (a === undefined) return undefined;
      return all(f.isOver ? `${a.symbol} verschleißt nicht mehr in eine Richtung` : wears(a, f.certainty));
    case DriftFindingKind.SEASON: {
      if (a === undefined) return undefined;
      if (f.isOver) return all(`${a.symbol} geht nicht mehr mit der Jahreszeit`);
      // By how much it goes with the temperature stands in the English alone.
      const text = `${a.symbol} geht mit der Jahreszeit um ${valueText(a.size, a.sigma)} ${unitText(a.unit)} nach beiden Seiten${sure(f.certainty)}`;
      return { text, isWhole: false };
    }
    case DriftFindingKind.NOISE: {
      const symbol = and(errorsIn(f.text));
      return f.isOver
        ? all(`${symbol} streut so, wie es seine Kalibrierungen angeben`)
        : { text: `${symbol} streut von Kalibrierung zu Kalibrierung anders, als sie angeben`, isWhole: false };
    }
    case DriftFindingKind.UNSTABLE:
      return f.afterUtcUs === undefined ? undefined : all(notStable(f.afterUtcUs, f.atUtcUs));
  }
  return undefined;
}
export const findingSaid = (f: DriftFinding) => (isGerman() ? findingOf(f) : undefined);

function eventOf(e: Event): Said | undefined {
  const all = (text: string): Said => ({ text, isWhole: true });
  const part = (text: string): Said => ({ text, isWhole: false });
  const [a] = e.amounts, id = e.calibrationId, from = e.fromUtcUs, to = e.toUtcUs;
  switch (e.kind) {
    case EventKind.OUT_OF_TOLERANCE:
      return a && part(`${e.subject} = ${withSigma(a)}, außerhalb seiner Toleranz (Kalibrierung ${id})`);
    case EventKind.LIMIT_FORECAST:
      return part(
        `${e.subject} verlässt seine Toleranz binnen eines Jahres nach der letzten Kalibrierung, Wahrscheinlichkeit ${certaintyText(e.certainty ?? 0)} %` +
          (to === undefined ? "" : `; bis ${dayText(to)} so wahrscheinlich wie nicht`),
      );
    case EventKind.STEP:
      return from === undefined || to === undefined ? undefined : all(jumped(e.amounts, from, to, e.certainty));
    case EventKind.SUSPECT:
      return id === undefined ? undefined : all(offBy(`Kalibrierung ${id}`, e.amounts, e.certainty));
    case EventKind.UNSTABLE:
      return from === undefined || to === undefined ? undefined : all(notStable(from, to));
    case EventKind.WEAR:
      return a && all(wears(a, e.certainty));
    case EventKind.SCATTER:
      return part(`${e.subject} streut von Kalibrierung zu Kalibrierung stärker, als sie angeben`);
    case EventKind.CALIBRATION_OLD:
      if (to === undefined) return undefined;
      return part(
        id === undefined
          ? `keine Kalibrierung ist in Gebrauch; fällig war eine am ${dayText(to)}`
          : `Kalibrierung ${id}, die in Gebrauch ist, ist älter als erwartet; fällig war eine neue am ${dayText(to)}`,
      );
    case EventKind.SESSION_MISSED:
      return to === undefined ? undefined : part(`die Messung ${e.subject} ist ausgeblieben; fällig war sie am ${timeText(to)}`);
    case EventKind.MODEL_LACKS:
      return part(`das Modell von Kalibrierung ${id} erklärt ihre Messwerte nicht: ihm fehlt etwas, oder eine Messung ist schlecht`);
    case EventKind.ROUTINE_FAILED:
      return part(`der Ablauf ${e.subject} ist gescheitert`);
    case EventKind.ROUTINE_PROPOSES:
      return part(`der Ablauf ${e.subject} schlägt Kalibrierung ${id} vor`);
    case EventKind.SESSION_REJECTED:
      return part(`Kalibrierung ${id}, die in Gebrauch ist, beruht auf einer verworfenen Messung`);
    case EventKind.UNLIKE_GROUP:
      return a && part(`${e.subject} liegt um ${withSigma(a)} neben dem der anderen Maschinen seiner Gruppe`);
    case EventKind.CELL_SILENT:
      return from === undefined ? undefined : part(`die Zelle ${e.subject} schweigt, zuletzt gehört am ${timeText(from)}`);
    case EventKind.CELL_PROBLEM:
      return part(`die Zelle ${e.subject} meldet ein Problem`);
  }
  return undefined;
}
export const eventSaid = (e: Event) => (isGerman() ? eventOf(e) : undefined);

// What to do, and why it was over, by the kind of event (docs/events.md).
const kAdvice: Partial<Record<EventKind, readonly [string, string]>> = {
  [EventKind.OUT_OF_TOLERANCE]: [
    "die Messung wiederholen; dann mit einer Kalibrierung von jetzt kompensieren, oder die Maschine einstellen lassen und sagen, was geschah",
    "innerhalb der Toleranz gemessen, oder keine Toleranz ist mehr angegeben",
  ],
  [EventKind.LIMIT_FORECAST]: ["vorher eine Wartung oder eine neue Kompensation planen", "nicht mehr vorhergesagt"],
  [EventKind.STEP]: [
    "nach einem Zusammenstoß oder einer neuen Aufspannung suchen; quittieren mit dem, was es war, oder sagen, was geschah; neu kalibrieren",
    "der Verlauf zeigt ihn nicht mehr, oder jemand hat gesagt, was es war",
  ],
  [EventKind.SUSPECT]: [
    "die Kalibrierung wiederholen, bevor sie benutzt wird: sie ist schlecht, oder die erste nach einem Sprung",
    "eine weitere Kalibrierung ist gefolgt",
  ],
  [EventKind.UNSTABLE]: ["Aufspannung, Taster und Messplan prüfen", "eine weitere Kalibrierung ist gefolgt"],
  [EventKind.WEAR]: ["eine Wartung planen; eine angegebene Toleranz sagt, wann sie erreicht wird", "nicht mehr so"],
  [EventKind.SCATTER]: ["nach der Befestigung des Normals, der Temperatur der Halle und der angegebenen Sigma sehen", "nicht mehr so"],
  [EventKind.CALIBRATION_OLD]: ["messen, identifizieren und die neue Kalibrierung freigeben", "eine jüngere ist in Gebrauch, oder keine wird mehr erwartet"],
  [EventKind.SESSION_MISSED]: ["ihr Messprogramm laufen lassen, oder nachsehen, warum sie nicht kam", "sie ist gekommen, oder wird nicht mehr erwartet"],
  [EventKind.MODEL_LACKS]: [
    "den Kreis über ihren Messungen schließen; wo das geschah, sagt ihr Bericht, was als Nächstes zu messen ist",
    "die neueste Kalibrierung erklärt ihre Messwerte",
  ],
  [EventKind.ROUTINE_FAILED]: ["beheben, was der Ablauf sagt, und ihn noch einmal laufen lassen", "der Ablauf lief wieder, wurde angehalten oder entfernt"],
  [EventKind.ROUTINE_PROPOSES]: ["ansehen, dann freigeben oder zurückziehen", "sie ist freigegeben oder zurückgezogen, oder der Ablauf ist ein anderer"],
  [EventKind.SESSION_REJECTED]: [
    "ohne sie neu identifizieren und das freigeben, oder zu einer älteren Kalibrierung zurückkehren",
    "eine andere Kalibrierung ist in Gebrauch, oder die Messung zählt wieder",
  ],
  [EventKind.UNLIKE_GROUP]: ["suchen, was diese Maschine unterscheidet: Zusammenstoß, Fundament, Aufspannung, anderer Messplan", "nicht mehr so"],
  [EventKind.CELL_SILENT]: ["nach dem PC an der Maschine sehen: Strom, Netz, Dienst; wo es ihn nicht mehr gibt: vergessen", "sie wurde wieder gehört, oder ist vergessen"],
  [EventKind.CELL_PROBLEM]: ["ihre Statusdatei sagt alles; was sie abgelehnt hat, steht bei den Zellen", "sie meldet, dass alles gut ist, oder ist vergessen"],
};
export const adviceSaid = (e: Event) => (isGerman() ? kAdvice[e.kind]?.[0] : undefined);
export const clearedSaid = (e: Event) => (isGerman() ? kAdvice[e.kind]?.[1] : undefined);

// What the fleet knows of a finding: its kind and day, and which errors it names. The event of it, where one stands, has its sizes.
const kStanding: Partial<Record<DriftFindingKind, string>> = {
  [DriftFindingKind.STEP]: "gesprungen",
  [DriftFindingKind.SUSPECT]: "neben dem Erwarteten, die Kalibrierung wiederholen",
  [DriftFindingKind.UNSTABLE]: "die Maschine oder die Messung ist nicht stabil",
};
export function standingSaid(f: StandingFinding): Said | undefined {
  const what = kStanding[f.kind];
  if (!isGerman() || what === undefined) return undefined;
  const symbols = and(errorsIn(f.text));
  return { text: `Kalibrierung vom ${dayText(f.atUtcUs)}: ${symbols}${symbols && " "}${what}`, isWhole: false };
}

const partOf = (words: Record<string, string>, kind: string, text: string): Said | undefined => {
  if (!isGerman() || words[kind] === undefined) return undefined;
  const symbols = errorsIn(text).join(", ");
  return { text: symbols === "" ? words[kind] : `${symbols}: ${words[kind]}`, isWhole: false };
};
// Warnings and causes have their German in the report (core/reports/warning_german.cc, core/loop); nothing where an earlier version made it.
export const germanOf = (german?: string): Said | undefined => (isGerman() && german ? { text: german, isWhole: true } : undefined);

// What to do about what is held back; the numbers, files and sessions of it stand in the server's words.
const kTodo: Record<string, string> = {
  uncertain: "genauer messen:",
  undecided: "messen, was die Deutungen trennt:",
  "no-gain": "genauer messen:",
  hidden: "messen, wo die Wirkung groß ist:",
};
export const todoSaid = (kind: string): string | undefined => (isGerman() ? kTodo[kind] : undefined);

const kTests: Record<string, string> = {
  "ballbar-pattern": "Kreisformtest mit einer Rundachse, der Stab behält seine Länge",
  "ballbar-turn": "Kreisformtest mit einer Rundachse, der Stab bleibt in einer Richtung",
  "ballbar-swung-turn": "Kreisformtest mit einer Rundachse bei ausgeschwenkter anderer",
  "ballbar-circle": "Kreisformtest mit zwei Linearachsen, gegen den und im Uhrzeigersinn",
  "rtest-grid": "R-Test über ein Gitter der Rundachsen, hin und zurück",
  "rtest-approach": "R-Test an wenigen Stellungen, jede von beiden Seiten angefahren",
  "other-sense": "eine Messung rückwärts:",
  later: "eine Messung, zwei Stunden später wiederholt:",
  warmer: "eine Messung oder ein R-Test, wenn die Halle vier Grad wärmer ist:",
  farther: "R-Test oder Kreisformtest über 30 Grad mehr einer Rundachse:",
  finer: "eine Messung mit drei Messwerten statt einem:",
};
export const proposalSaid = (one: { test?: string; session: string | null }): Said | undefined =>
  isGerman() && one.test !== undefined && kTests[one.test] !== undefined ? { text: `${kTests[one.test]} ${one.session ?? ""}`, isWhole: false } : undefined;

// What the rewriter notes, by its kind (docs/formats.md); names and numbers stand in the English.
const kNotes: Record<string, string> = {
  "not-carried": "Ein Fehler ist nicht korrigiert: ein Programm kann ihm nicht folgen, oder eine Angabe fehlt.",
  "not-told-apart": "Diese Kalibrierung kann Fehler nicht trennen: die Korrektur gilt in Stellungen wie den gemessenen, anderswo ist das nicht bekannt.",
  "not-measured-there": "Das Programm fährt weiter, als die Messungen dieser Kalibrierung reichen; wie richtig die Korrektur dort ist, ist nicht bekannt.",
  "apart-not-known": "Was diese Kalibrierung nicht trennen kann, ist nicht bekannt.",
  profile: "Das stand in der Maschinenbeschreibung und galt für dieses Programm.",
  "compensated-before": "Dieses Programm wurde schon einmal kompensiert.",
  unchanged: "Kein Wort änderte sich: das Programm bleibt Byte für Byte, wie es war, ohne Vermerk.",
  copies: "Ein Unterprogramm braucht nicht an allen Stellen dieselbe Korrektur: es steht mehrmals da. Kein Programm der Steuerung darf so heißen wie eine Kopie.",
  "tool-change": "Werkzeugwechsel: alle Bewegungen sind für den einen angegebenen Werkzeugpunkt korrigiert.",
  "tool-change-keeps": "Werkzeugwechsel lassen die genannten Achsen stehen, wo sie sind; so war es angegeben.",
  "tool-point-control": "Werkzeugspitzensteuerung (TCP): ihre Kinematik gilt als die der Maschinenbeschreibung, die Wörter als im Koordinatensystem des Werkstücks bei Tisch auf null.",
  "tool-vectors": "Werkzeugvektoren: jede Drehachse fährt auf die nähere der Stellen, die diese Richtung ergeben, im gleichen Verhältnis wie die Bewegung.",
  "turning-alike": "Ob das Werkzeug nach Vektor (ORIVECT) oder nach Achsen (ORIAXES) dreht, macht hier weniger als 50 µrad aus und wird nicht gefragt.",
  "tilted-plane": "Geschwenkte Ebene: die Kinematik der Steuerung gilt als die der Maschinenbeschreibung, der Nullpunkt als der bei Tisch auf null.",
  "half-turn": "Eine Drehachse fährt um eine halbe Umdrehung: eine Steuerung, die den kürzeren Weg nimmt, kann jetzt den anderen nehmen.",
  "whole-units": "Ein Wort hat keinen Punkt: solche Wörter zählen hier ganze Einheiten, auf anderen Steuerungen kleinste Schritte.",
  "text-before-start": "Text vor dem ersten % bleibt, wie er ist: keine Steuerung liest ihn.",
  "text-after-end": "Text hinter dem Programmende bleibt, wie er ist.",
};
const kWholeNotes = ["compensated-before", "unchanged", "text-before-start", "text-after-end"];
export function noteSaid(note: { kind: string; line?: number | null } | undefined, text: string): Said | undefined {
  const said = note && partOf(kNotes, note.kind, text);
  return said && { text: note.line ? `Zeile ${note.line}: ${said.text}` : said.text, isWhole: kWholeNotes.includes(note.kind) };
}

// When an error leaves its limits; why there is no forecast is English.
export function limitSaid(f: LimitForecast): Said | undefined {
  if (!isGerman() || f.limit === undefined || f.probabilityNow === undefined || f.probabilityWithinYear === undefined) return undefined;
  const limits = `${numberText(f.limit.low, 6)} … ${numberText(f.limit.high, 6)} ${unitText(f.unit ?? "")}`;
  const by = f.medianUtcUs === undefined ? "" : `; bis ${dayText(f.medianUtcUs)} so wahrscheinlich wie nicht`;
  const span =
    f.earliestUtcUs === undefined || f.latestUtcUs === undefined ? "" : ` (90 %: ${dayText(f.earliestUtcUs)} bis ${dayText(f.latestUtcUs)})`;
  return {
    text: `${f.limit.symbol} liegt jetzt mit ${certaintyText(f.probabilityNow)} % Wahrscheinlichkeit außerhalb von ${limits}, binnen eines Jahres mit ${certaintyText(f.probabilityWithinYear)} %${by}${span}`,
    isWhole: true,
  };
}

// Tables for controllers, by the name of their format: title, what its values are, what it cannot carry. How many points and how fine stands in
// the server's words.
const kErrorsAre = "Abweichungen, Ist minus Soll", kAdded = "Korrekturen, die zum Befehl addiert werden";
const kAcross = "Abweichungen quer zur Achse oder über einer anderen", kTool = "die Richtung des Werkzeugs";
const kPins: readonly [string, string] = ["Positionen der Achsen, mm, in den Koordinaten von X, Y, Z", "Neigungen der Drehachsen und Rechtwinkligkeit; was sich mit einer Position ändert; was alle Achsen gleich bewegt (Nullpunkt)"];
const kFormats: Record<string, readonly [string, string, string]> = {
  general: ["Allgemeine Tabelle: CSV, Namen nach ISO 230-1 als Spalten, Achspositionen als Argumente", `${kErrorsAre}; µm, µrad`, ""],
  "linuxcnc-comp": ["LinuxCNC: COMP_FILE eines Gelenks, COMP_FILE_TYPE = 1", `${kAdded}, vorwärts und rückwärts; mm, °`, `was eine Achse quer zu ihrer Richtung tut; was von einer anderen Achse abhängt; ${kTool}`],
  "linuxcnc-xyzac": ["LinuxCNC: Pins von xyzac-trt-kins, wo A und C sind", ...kPins],
  "linuxcnc-xyzbc": ["LinuxCNC: Pins von xyzbc-trt-kins, wo B und C sind", ...kPins],
  "siemens-eec": ["Siemens SINUMERIK: Geberfehlerkompensation, $AA_ENC_COMP", `${kErrorsAre}: ein positiver Wert bewegt die Achse ins Negative; mm, °`, `Umkehrspanne (MD32450 $MA_BACKLASH, oder siemens-cec); ${kAcross}; ${kTool}`],
  "siemens-cec": ["Siemens SINUMERIK: Durchhangkompensation, $AN_CEC, jede Achse über jeder, je Richtung eine", `${kErrorsAre}: ein positiver Wert bewegt die Achse ins Negative; mm, °`, "was zwei Achsen zusammen bewirken (Winkel mit einem Hebel entlang einer anderen Achse); mehr als 62 Tabellen"],
  "fanuc-pitch": ["Fanuc: gespeicherte Spindelsteigungskompensation, mit 3620 bis 3627", `${kAdded}: Zunahmen von Punkt zu Punkt in Erfassungseinheiten`, `${kAcross}; ${kTool}`],
  "fanuc-3d": ["Fanuc: dreidimensionale Fehlerkompensation, trilinear", `${kAdded}: in Erfassungseinheiten`, `Umkehrspanne (fanuc-pitch); Abweichungen über Drehachsen: das Gitter gilt für die Winkel der Bezugsstellung; ${kTool}`],
  "heidenhain-com": ["Heidenhain: Achsfehlerkompensation, Tabelle .COM", `${kErrorsAre}; mm, °`, `Umkehrspanne (Maschinenparameter); ${kAcross}; ${kTool}`],
  "heidenhain-kinematics": ["Heidenhain: Kinematiktabelle, wo die Drehachsen sind", "Verschiebungen von Achse zu Achse, mm, beginnend am Werkzeugpunkt in Grundstellung", kPins[1]],
  "isg-volumetric": ["ISG: volumetrische Kompensation, CSV, Abweichungen jeder Achse über ihrer eigenen Position", `${kErrorsAre}; mm, rad`, "Umkehrspanne; Abweichungen einer Achse über der Position einer anderen; Abweichungen von Spindel, Werkzeug und Werkstück"],
};
export const formatTitle = (format: TableFormat): string => (isGerman() && kFormats[format.name]?.[0]) || format.title;
export function formatSaid(format: TableFormat): Said | undefined {
  const words = kFormats[format.name];
  if (!isGerman() || words === undefined) return undefined;
  const [, values, cannot] = words;
  return { text: `${values}.${cannot === "" ? "" : ` Nimmt nicht auf: ${cannot}.`}`, isWhole: false };
}
