// What the server writes in English, in German: worded from kinds and facts of the API, never by reading the English. Each returns nothing where
// the reader's language is English, or the kind is not known here: the server's own words stand then.
import { DriftFindingKind, type DriftAmount, type DriftFinding, type LimitForecast, type StandingFinding } from "./gen/axiscal/v1/history_service_pb";
import { EventKind, type Event } from "./gen/axiscal/v1/events_service_pb";
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

// Of warnings (docs/formats.md): what the kind means. Sizes stand in the English.
const kWarnings: Record<string, string> = {
  scatter: "die Messwerte streuen stärker um das Modell, als ihre angegebene Sigma erlaubt: ihm fehlt etwas, oder eine Messung ist schlecht",
  "set-aside": "zu viele Messwerte stechen heraus und wurden beiseitegelegt: dem Modell fehlt etwas, das sie zeigen",
  interval: "die Messwerte lassen die Aufspannung so offen, dass kein Intervall angegeben werden kann",
  "no-number": "die Anpassung endete bei einer Größe, die kein Messwert stützt: abseits der gemessenen Stellungen nicht mit diesem Modell kompensieren",
  held: "die festgehaltenen Fehler stammen aus denselben Messungen oder Angaben; die Sigmas nehmen beide Stufen als unabhängig: aus allen Messungen gemeinsam identifizieren",
  resolution: "die Messwerte sind gröber aufgelöst, als ihre angegebene Sigma sagt; was das Runden verbirgt, zählt als Rauschen",
  size: "größer, als es an einer Maschine dieser Größe sein kann: Ist eine Werkzeuglänge (tool_tip_mm), ein Radius von Kugel oder Taster (vergessen oder doppelt gezählt), ein point_mm in machine.json oder die Einheit einer Datei (m oder Zoll statt mm) falsch?",
  quiet: "die Messwerte streuen viel weniger, als ihre angegebene Sigma sagt: Stehen sie in m oder Zoll statt mm (alle Fehler sind dann um denselben Faktor zu klein), oder ist sigma_um zu groß?",
  datum: "Messungen unterscheiden sich um einen festen Wert der Sollstellung: Wurde der Nullpunkt vorher neu gesetzt? Dann gehört \"# datum: free\" mit den Achsen in ihren Kopf",
  "no-degree-of-freedom": "kein Freiheitsgrad: nichts zeigt, um wie viel die Werte falsch sind",
  certificate: "ein Zertifikat war bei der Messung abgelaufen, oder ob es galt, ist nicht bekannt",
  clock: "Messungen überlappen in der Zeit: t_s jeder zählt von einem eigenen Anfang; t_s von Messung zu Messung weiterlaufen lassen",
  moved: "der Tracker selbst hat sich bewegt, nicht die Maschine; das ist abgezogen und steht in keinem Fehler",
};
const partOf = (words: Record<string, string>, kind: string, text: string): Said | undefined => {
  if (!isGerman() || words[kind] === undefined) return undefined;
  const symbols = errorsIn(text).join(", ");
  return { text: symbols === "" ? words[kind] : `${symbols}: ${words[kind]}`, isWhole: false };
};
export const warningSaid = (one: { kind: string; text: string }) => partOf(kWarnings, one.kind, one.text);

const kCauses: Record<string, string> = {
  instrument: "am Messmittel, nicht an der Maschine",
  nominal: "eine Angabe in einer Datei, nicht die Maschine",
  "not-repeatable": "wiederholt sich nicht, keine Eigenschaft der Maschine",
};
const kTests: Record<string, string> = {
  "ballbar-pattern": "Kreisformtest, Bahn",
  "ballbar-circle": "Kreisformtest, Kreis",
  "rtest-grid": "R-Test über ein Gitter",
};
export const causeSaid = (kind: string): Said | undefined => (isGerman() && kCauses[kind] ? { text: kCauses[kind], isWhole: false } : undefined);
export const proposalSaid = (one: { test?: string; session: string | null }): Said | undefined =>
  isGerman() && one.test !== undefined && kTests[one.test] !== undefined ? { text: `${kTests[one.test]} ${one.session ?? ""}`, isWhole: false } : undefined;

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
