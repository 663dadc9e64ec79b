// One calibration: what was found, how sure, what cannot be told apart; tables of it; and the decision to use it.
import { useState } from "preact/hooks";
import { epoch, history, jsonOf, problemOf, useLoad, type Problem, Refusal } from "../api";
import { Intervals } from "../charts";
import { countText, dayText, figureText, numberText, probabilityText, save, sigmaText, timeText, unitText, valueText } from "../format";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { CalibrationState, EstimateUnit, type Calibration } from "../gen/axiscal/v1/calibration_pb";
import { DifferenceVerdict, type CalibrationPicture, type CompareCalibrationsResponse, type ToolPointChange } from "../gen/axiscal/v1/calibrations_service_pb";
import { DriftFindingKind, type DriftFinding } from "../gen/axiscal/v1/history_service_pb";
import type { VolumetricError } from "../gen/axiscal/v1/volumetric_pb";
import { EventKind, type Event } from "../gen/axiscal/v1/events_service_pb";
import { jumpWords, suspectWords } from "../certainty";
import { isNew, listEvents } from "../events";
import { eventSaid, findingSaid, formatSaid, formatTitle, germanOf } from "../german";
import { kindText } from "./events";
import { Empty, ErrorName, ErrorWords, Fact, Figure, FormDialog, ProblemBox, Quoted, ServerPicture, Show, StateMark, stateText, Table, Title, Worded, fieldOf, usePlaced } from "../parts";
import type { IdentificationReport, LoopReport, Warning } from "../reports";
import type { TableFormat } from "../gen/axiscal/v1/tables_service_pb";
import { calibrations, tables } from "../services";
import { may } from "../session";
import { language, t, tMaybe } from "../text";

const kNormal95 = 1.959964;
// As the server takes it.
const kMaxReasonBytes = 200;

interface CalibrationData {
  it: Calibration;
  inUse?: Calibration; // of the same machine
  heard: Heard;
}

// What whoever decides about it must know: events that stand and name it, jumps that it was measured after, and that the history doubts it.
interface Heard {
  events: Event[];
  doubts: DriftFinding[];
}
async function heardOf(it: Calibration): Promise<Heard> {
  const measured = it.provenance?.measuredUtcUs ?? 0n;
  const [standing, drift] = await Promise.all([
    listEvents(it.machineId, true),
    history.findDrift({ machineId: it.machineId, countsCandidates: true }),
  ]);
  const named = standing.rows.filter((one) => one.calibrationId === it.calibrationId);
  const isTold = named.some((one) => one.kind === EventKind.SUSPECT);
  const jumps = standing.rows.filter((one) => one.kind === EventKind.STEP && one.toUtcUs !== undefined && measured >= one.toUtcUs && !named.includes(one));
  return {
    events: [...named, ...jumps],
    doubts: drift.findings.filter((one) => one.kind === DriftFindingKind.SUSPECT && !one.isOver && !isTold && one.atUtcUs === measured),
  };
}

async function load(id: bigint): Promise<CalibrationData> {
  const it = (await calibrations.getCalibration({ calibrationId: id })).calibration!;
  const heard = heardOf(it);
  try {
    const inUse = await calibrations.getCalibration({ approvedOfMachineId: it.machineId });
    return { it, inUse: inUse.calibration, heard: await heard };
  } catch (error) {
    if (problemOf(error).reason === "CALIBRATION_NOT_FOUND") return { it, heard: await heard };
    throw error;
  }
}

function Found(props: { it: Calibration; coverage: number; readings?: number }) {
  const { it, coverage } = props;
  const numbered = it.estimates.filter((e) => e.value !== undefined);
  return (
    <section>
      <h2>{t("found")}</h2>
      <Table label={t("found")} head={[t("error"), t("value"), "± 1 σ", t("interval"), t("unit")]} numbers={[1, 2, 3]}>
        {it.estimates.map((e) => (
          <tr>
            <th scope="row" class="text">
              <ErrorName name={e.symbol} />
            </th>
            {e.value === undefined ? (
              <td colSpan={3} class="muted">
                {t("notTellable")}
              </td>
            ) : (
              <>
                <td class="number">{valueText(e.value, e.sigma)}</td>
                <td class="number">{e.sigma === undefined ? "–" : sigmaText(e.sigma)}</td>
                <td class="number">
                  {e.sigma === undefined
                    ? "–"
                    : `${valueText(e.value - coverage * e.sigma, e.sigma)} … ${valueText(e.value + coverage * e.sigma, e.sigma)}`}
                </td>
              </>
            )}
            <td>{unitText(e.unit)}</td>
          </tr>
        ))}
      </Table>
      {[EstimateUnit.UM, EstimateUnit.URAD].map((unit) => {
        const rows = numbered.filter((e) => e.unit === unit);
        if (rows.length === 0) return null;
        const name = unitText(unit);
        const caption = `${t("errorsPicture", { n: props.readings === undefined ? "–" : countText(props.readings) })}, ${name}`;
        return (
          <Figure
            name={`calibration-${it.calibrationId}-${unit === EstimateUnit.UM ? "um" : "urad"}`}
            caption={caption}
            head={[t("error"), `${t("value")} (${name})`, "95 % −", "95 % +"]}
            rows={rows.map((e) => [e.symbol, e.value, e.value! - coverage * (e.sigma ?? 0), e.value! + coverage * (e.sigma ?? 0)])}
            shown={rows.map((e) => [
              e.symbol,
              valueText(e.value!, e.sigma),
              valueText(e.value! - coverage * (e.sigma ?? 0), e.sigma),
              valueText(e.value! + coverage * (e.sigma ?? 0), e.sigma),
            ])}
          >
            <Intervals
              title={caption}
              rows={rows.map((e) => ({
                name: e.symbol,
                value: e.value!,
                low: e.value! - coverage * (e.sigma ?? 0),
                high: e.value! + coverage * (e.sigma ?? 0),
                label: `${e.symbol}: ${valueText(e.value!, e.sigma)} ± ${e.sigma === undefined ? "–" : sigmaText(e.sigma)} ${name}`,
              }))}
            />
          </Figure>
        );
      })}
    </section>
  );
}

function NotSeparable(props: { it: Calibration; loop?: LoopReport }) {
  const { it } = props;
  // Of the loop's effects the class stands in its report.
  const classes = (props.loop?.effects ?? []).filter((e) => (e.equivalent ?? []).length > 0);
  const isNothing = it.notSeparable.length === 0 && classes.length === 0;
  return (
    <section>
      <h2>{t("cannotTell")}</h2>
      {it.reportProblem && (
        <p class="box bad">
          <Quoted said={t("reportProblem")} text={it.reportProblem} />
        </p>
      )}
      {isNothing ? !it.reportProblem && <p>{t("cannotTellNone")}</p> : <p>{t("cannotTellHelp")}</p>}
      {!isNothing && (
        <ul class="classes">
          {it.notSeparable.map((text) => (
            <li>
              <code>{text}</code>
            </li>
          ))}
          {classes.map((e) => (
            <li>
              <code>{[e.name, ...(e.equivalent ?? []).map((one) => one.name)].join("  |  ")}</code>
            </li>
          ))}
        </ul>
      )}
      {it.combinations.length > 0 && (
        <>
          <h3>{t("combinations")}</h3>
          <Table label={t("combinations")} head={[t("what"), t("value"), "± 1 σ", t("unit")]} numbers={[1, 2]}>
            {it.combinations.map((c) => (
              <tr>
                <th scope="row">{c.name}</th>
                <td class="number">{c.value === undefined ? "–" : valueText(c.value, c.sigma)}</td>
                <td class="number">{c.sigma === undefined ? "–" : sigmaText(c.sigma)}</td>
                <td>{unitText(c.unit)}</td>
              </tr>
            ))}
          </Table>
        </>
      )}
    </section>
  );
}

const kVerdictMark: Record<number, string> = {
  [DifferenceVerdict.AGREES]: "good",
  [DifferenceVerdict.DIFFERS]: "bad",
  [DifferenceVerdict.MAY_DIFFER]: "wait",
};

// What moves stands first.
const kVerdictOrder = [
  DifferenceVerdict.DIFFERS,
  DifferenceVerdict.MAY_DIFFER,
  DifferenceVerdict.ONLY_ONE,
  DifferenceVerdict.NO_UNCERTAINTY,
  DifferenceVerdict.AGREES,
  DifferenceVerdict.NOT_DETERMINED,
];

// "X −100, C 30": mm of linear axes, degrees of rotary ones.
const poseText = (made: CompareCalibrationsResponse, change: ToolPointChange) =>
  made.box.map((span, i) => `${span.axis} ${numberText(change.largestAtMmOrDeg[i], 4)}`).join(", ");

// How far the tool point would move over the box.
function Moves(props: { made: CompareCalibrationsResponse }) {
  const { made } = props;
  const first = made.asProgrammed;
  if (first === undefined || made.setAnew === undefined) return <p class="box">{t("movesNotKnown")}</p>;
  const rows = [
    ["asProgrammed", first],
    ["setAnew", made.setAnew],
  ] as const;
  const chance = (um?: number) => (um === undefined ? "–" : numberText(um));
  return (
    <>
      <p class="lead">
        {t("movesBy", { max: numberText(first.maxUm), rms: numberText(first.rmsUm) })}{" "}
        {first.chanceMaxUm !== undefined && t(first.maxUm > first.chanceMaxUm ? "movesBeyond" : "movesWithin", { n: numberText(first.chanceMaxUm) })}
      </p>
      <p>
        {t("overBox")}{" "}
        {made.box
          .filter((span) => span.toMmOrDeg > span.fromMmOrDeg)
          .map((span) => `${span.axis} ${numberText(span.fromMmOrDeg, 4)} … ${numberText(span.toMmOrDeg, 4)}`)
          .join(", ")}{" "}
        ({t("mmOrDeg")}), {t("poses", { n: countText(made.poses) })}
      </p>
      <Table
        label={t("movesTitle")}
        head={[t("state"), t("rmsUm"), t("byChance"), t("maxUm"), t("byChance"), t("largestAt")]}
        numbers={[1, 2, 3, 4]}
      >
        {rows.map(([name, change]) => (
          <tr>
            <th scope="row" class="text">
              {t(name)}
            </th>
            <td class="number">{numberText(change.rmsUm)}</td>
            <td class="number">{chance(change.chanceRmsUm)}</td>
            <td class="number">{numberText(change.maxUm)}</td>
            <td class="number">{chance(change.chanceMaxUm)}</td>
            <td class="text">
              {poseText(made, change)}
              {change.by.length > 0 && `; ${t("mostBy")} ${change.by.join(", ")}`}
            </td>
          </tr>
        ))}
      </Table>
      {made.unknown.length > 0 && (
        <p class="box">
          {t("movesUnknown")} {made.unknown.join("; ")}
        </p>
      )}
    </>
  );
}

// Whether things get better: the tool point's error over the box with the one in use and with this one, as this one sees the machine.
function Gain(props: { error?: VolumetricError; of: Calibration }) {
  const { error, of } = props;
  if (!error?.before?.rms || !error.after?.rms) return null;
  const isPoor = jsonOf<IdentificationReport>(of.reportJson)?.warnings?.some((one) => one.kind === "scatter");
  return (
    <p class="lead">
      {t("gain", { old: error.beforeCalibrationId ?? "", before: figureText(error.before), n: error.calibrationId, after: figureText(error.after) })}
      {isPoor && <strong> {t("gainPoor")}</strong>}
    </p>
  );
}

const kMostCompared = 50; // the newest of the machine

// What would change for the machine: this one less another one, as the server compares them; the one in use unless another is chosen.
function Differences(props: { it: Calibration; inUse?: Calibration; mayChoose?: boolean; onPlaced?: () => void }) {
  const { it, inUse } = props;
  const [chosen, setChosen] = useState<bigint>();
  const listed = useLoad(`others ${it.machineId} ${props.mayChoose}`, async () =>
    props.mayChoose ? (await calibrations.listCalibrations({ machineId: it.machineId, pageSize: kMostCompared })).calibrations : [],
  );
  const others = (listed.data ?? []).filter((one) => one.calibrationId !== it.calibrationId);
  const other = chosen ?? (inUse?.calibrationId === it.calibrationId ? undefined : inUse?.calibrationId);
  const found = useLoad(`differences ${it.calibrationId} ${other}`, async () => {
    if (other === undefined) return undefined;
    const made = calibrations.compareCalibrations({ calibrationId: it.calibrationId, withCalibrationId: other });
    // Together: what comes later would move what is read. Where nothing is known of it nothing is said.
    const gain = other === inUse?.calibrationId ? calibrations.getVolumetricError({ calibrationId: it.calibrationId }).then(({ error }) => error, () => undefined) : undefined;
    return { made: await made, gain: await gain };
  });
  // Both or none: nothing that is seen moves when the other comes.
  const isPlaced = (listed.data !== undefined || listed.problem !== undefined) && (other === undefined || found.data !== undefined || found.problem !== undefined);
  usePlaced(isPlaced, props.onPlaced);
  const choice = (isPlaced || chosen !== undefined) && others.length > 0 && (
    <p class="no-print">
      <label>
        {t("compareWith")}{" "}
        <select value={String(other ?? "")} onChange={(event) => setChosen(event.currentTarget.value === "" ? undefined : BigInt(event.currentTarget.value))}>
          {other === undefined && <option value="">{t("pleaseChoose")}</option>}
          {others.map((one) => (
            <option value={String(one.calibrationId)}>{[t("calibrationN", { n: one.calibrationId }), one.provenance && dayText(one.provenance.measuredUtcUs), stateText(one.state)].filter(Boolean).join(", ")}</option>
          ))}
        </select>
      </label>
    </p>
  );
  if (other === undefined)
    return (
      <>
        <p>{t(inUse === undefined ? "differencesNone" : "differencesSelf")}</p>
        {choice}
      </>
    );
  return (
    <>
    {choice}
    <Show of={isPlaced ? { data: found.data, problem: found.problem } : {}} rows={8}>
      {({ made, gain }) => (
        <>
          <Gain error={gain} of={it} />
          <Moves made={made} />
          <p>{t("differencesHelp", { n: made.withCalibrationId })}</p>
          <Table
            label={t("differences")}
            head={[t("error"), t("isClear"), t(other === inUse?.calibrationId ? "nowValue" : "otherValue", { n: made.withCalibrationId }), t("thisValue"), t("difference"), "± 1 σ", t("unit"), t("atToolPoint")]}
            numbers={[2, 3, 4, 5, 7]}
          >
            {[...made.errors, ...made.combinations].sort((a, b) => kVerdictOrder.indexOf(a.verdict) - kVerdictOrder.indexOf(b.verdict)).map((one) => (
              <tr>
                <th scope="row" class="text">
                  <ErrorName name={one.name} />
                </th>
                <td>
                  <span class={`mark ${kVerdictMark[one.verdict] ?? "old"}`}>{tMaybe(`differs_${one.verdict}`)}</span>
                </td>
                <td class="number">{one.other === undefined ? "–" : valueText(one.other, one.sigma)}</td>
                <td class="number">{one.value === undefined ? "–" : valueText(one.value, one.sigma)}</td>
                <td class="number">{one.difference === undefined ? "–" : valueText(one.difference, one.sigma)}</td>
                <td class="number">{one.sigma === undefined ? "–" : sigmaText(one.sigma)}</td>
                <td>{unitText(one.unit)}</td>
                <td class="number">{one.toolPointRmsUm === undefined ? "–" : `${numberText(one.toolPointRmsUm)} µm`}</td>
              </tr>
            ))}
          </Table>
          {made.probability !== undefined && <p>{t("differencesChance", { p: probabilityText(made.probability) })}</p>}
          {made.notComparable.length > 0 && (
            <p>
              {t("notComparable")}: {made.notComparable.join("; ")}
            </p>
          )}
          {made.notes.map((note) => (
            <p>
              <Quoted said={t("compareNote")} text={note} />
            </p>
          ))}
        </>
      )}
    </Show>
    </>
  );
}

function HeardOf(props: { of: Heard }) {
  const { events, doubts } = props.of;
  if (events.length + doubts.length === 0) return null;
  return (
    <section>
      <h2>{t("heardTitle")}</h2>
      <ul class="findings">
        {doubts.map((one) => (
          <li class="now">
            <Worded said={findingSaid(one)} text={one.text} /> <ErrorWords text={one.text} />
            <p class="muted">{suspectWords(one.certainty)}</p>
          </li>
        ))}
        {events.map((event) => (
          <li class={isNew(event) ? "now" : ""}>
            <strong>{kindText(event)}</strong>: <Worded said={eventSaid(event)} text={event.text} /> <ErrorWords text={event.text} />
            {event.kind === EventKind.STEP && jumpWords(event.amounts, event.certainty) && <p class="muted">{jumpWords(event.amounts, event.certainty)}</p>}
            {event.kind === EventKind.SUSPECT && <p class="muted">{suspectWords(event.certainty)}</p>}
          </li>
        ))}
      </ul>
    </section>
  );
}

function Decide(props: { data: CalibrationData }) {
  const { it, inUse, heard } = props.data;
  const [asked, setAsked] = useState<"approve" | "retire">();
  const [note, setNote] = useState("");
  const [done, setDone] = useState<{ text: string; reason: string; left: number }>();
  if (!may(Role.APPROVER, it.machineId)) return <p class="muted no-print">{t("approverOnly")}</p>;
  const decide = async (form: FormData) => {
    const reason = fieldOf(form, "reason");
    if (reason === "") throw new Refusal(t("reasonNeeded"));
    if (new TextEncoder().encode(reason).length > kMaxReasonBytes) throw new Refusal(t("wordTooLong", { n: kMaxReasonBytes }));
    const request = { calibrationId: it.calibrationId, etag: it.etag, reason };
    try {
      if (asked === "approve") await calibrations.approveCalibration(request);
      else await calibrations.retireCalibration(request);
      const left = await listEvents(it.machineId, true).then(({ rows }) => rows.filter(isNew).length, () => 0);
      setDone({ text: t(asked === "approve" ? "approveDone" : "retireDone", { n: it.calibrationId }), reason, left });
    } catch (error) {
      if (problemOf(error).reason !== "ETAG_MISMATCH") throw error;
      setNote(t("changedMeanwhile"));
    }
    epoch.value++;
  };
  const isInUse = it.state === CalibrationState.APPROVED;
  const wasInUse = it.approvedUtcUs !== undefined;
  return (
    <div class="no-print">
      {note && (
        <p class="box" role="alert">
          {note}
        </p>
      )}
      <div role="status">
        {done && (
          <div class="box good">
            <p>
              {done.text} <q>{done.reason}</q>
            </p>
            {done.left > 0 && (
              <p>
                {t("approveNext", { n: countText(done.left) })} <a href={`#/events/${encodeURIComponent(it.machineId)}`}>{t("eventsOf", { machine: it.machineId })}</a>
              </p>
            )}
          </div>
        )}
      </div>
      <p class="buttons">
        {!isInUse && (
          <button type="button" onClick={() => setAsked("approve")}>
            {t(wasInUse ? "approveAgain" : "approve")}
          </button>
        )}
        {it.state !== CalibrationState.RETIRED && (
          <button type="button" class="quiet" onClick={() => setAsked("retire")}>
            {t(isInUse ? "retire" : "giveUp")}
          </button>
        )}
        {inUse && !isInUse && (
          <button type="button" class="quiet" onClick={() => document.getElementById("differences")?.scrollIntoView()}>
            {t("toDifferences")}
          </button>
        )}
      </p>
      {asked && (
        <FormDialog
          title={t(asked === "approve" ? "approveTitle" : isInUse ? "retireTitle" : "giveUp", { n: it.calibrationId })}
          submit={t(asked === "approve" ? (wasInUse ? "approveAgain" : "approve") : isInUse ? "retire" : "giveUp")}
          intro={
            <>
              <p>
                {asked === "approve"
                  ? inUse
                    ? t("approveEffect", { old: inUse.calibrationId })
                    : t("approveEffectFirst")
                  : t(isInUse ? "retireEffect" : "giveUpEffect")}
              </p>
              {asked === "approve" && <HeardOf of={heard} />}
              {asked === "approve" && inUse && <Differences it={it} inUse={inUse} />}
            </>
          }
          isPlain
          stays
          onSend={decide}
          onClose={() => setAsked(undefined)}
        >
          <label>
            {t("reason")}
            <input name="reason" required autocomplete="off" />
          </label>
        </FormDialog>
      )}
    </div>
  );
}

const formatText = (format: TableFormat) =>
  `${format.values}. ${format.limits}.${format.cannotCarry.length > 0 ? ` Cannot carry: ${format.cannotCarry.join("; ")}.` : ""}`;

function MakeTable(props: { it: Calibration }) {
  const formats = useLoad("formats", async () => (await tables.listTableFormats({})).formats);
  const [answer, setAnswer] = useState<{ done?: string; report?: string; problem?: Problem }>({});
  const [name, setName] = useState("general");
  // The server makes none of a retired one.
  if (!may(Role.TECHNICIAN, props.it.machineId) || props.it.state === CalibrationState.RETIRED) return null;
  const make = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    const tip = tipOf(String(form.get("tip")));
    if (tip === undefined) return setAnswer({ problem: { text: t("tipWrong"), reason: "", isConnection: false, isOwn: true } });
    try {
      const made = await tables.makeTable({
        machineId: props.it.machineId,
        calibrationId: props.it.calibrationId,
        format: name,
        toolTipMm: tip,
        axes: String(form.get("axes")).split(/\s+/).filter(Boolean),
      });
      save(`${props.it.machineId}-${name}-c${made.calibrationId}.txt`, "application/octet-stream", new Uint8Array(made.content));
      setAnswer({ done: t("tableDone", { n: countText(made.content.length), c: made.calibrationId }), report: made.reportJson });
    } catch (error) {
      setAnswer({ problem: problemOf(error) });
    }
  };
  return (
    <section class="no-print">
      <h2>{t("tablesTitle")}</h2>
      <Show of={formats}>
        {(list) => {
          const format = list.find((f) => f.name === name);
          return (
            <form class="form" onSubmit={make}>
              <label>
                {t("format")}
                <select value={name} onChange={(event) => setName(event.currentTarget.value)}>
                  {list.map((f) => (
                    <option value={f.name}>{formatTitle(f)}</option>
                  ))}
                </select>
              </label>
              {format && (
                <p>
                  <Worded said={formatSaid(format)} text={formatText(format)} />
                </p>
              )}
              <label>
                {t("tip")}
                <input name="tip" required autocomplete="off" inputMode="text" />
              </label>
              <label>
                {t("axesOptional")}
                <input name="axes" autocomplete="off" />
              </label>
              <p class="buttons">
                <button type="submit">{t("makeTable")}</button>
              </p>
              {answer.problem && <ProblemBox problem={answer.problem} />}
              <div role="status">{answer.done && <p class="box good">{answer.done}</p>}</div>
              {answer.report && (
                <p class="buttons">
                  <button type="button" class="quiet" onClick={() => save(`table-report.json`, "application/json", answer.report!)}>
                    {t("report")}
                  </button>
                </p>
              )}
            </form>
          );
        }}
      </Show>
    </section>
  );
}

// "-350.5" -> a number; to a German reader "-350,5" is one, too.
export function lengthOf(word: string): number | undefined {
  const number = Number(language.value === "de" ? word.replace(/^([+-]?\d+),(\d+)$/, "$1.$2") : word);
  return word !== "" && Number.isFinite(number) ? number : undefined;
}
// "0 0 -350" -> three of them.
export function tipOf(text: string): number[] | undefined {
  const numbers = text.trim().split(/[\s;]+/).map(lengthOf).filter((one) => one !== undefined);
  return text.trim().split(/[\s;]+/).length === 3 && numbers.length === 3 ? numbers : undefined;
}

export function Warnings(props: { list?: Warning[] }) {
  if (!props.list || props.list.length === 0) return null;
  return (
    <section>
      <h2>{t("warnings")}</h2>
      <ul class="findings">
        {props.list.map((one) => (
          <li class="now">
            <Worded said={germanOf(one.text_de)} text={one.text} /> <ErrorWords text={one.text} />
          </li>
        ))}
      </ul>
    </section>
  );
}

// "residual-X.svg" -> "Residuals over X, µm, n = 1,623": all readings are in it, and behind what was found; a trace has those of its sessions.
function captionOf(picture: CalibrationPicture, readings: bigint): string {
  const { file, yLabel, series } = picture;
  const [kind, name] = [file.slice(0, file.indexOf("-")), file.slice(file.indexOf("-") + 1).replace(/\.svg$/, "")];
  // Of pictures whose numbers had no room in the answer the label is not there.
  const unit = yLabel === "" ? "" : `, ${unitText(yLabel.slice(yLabel.lastIndexOf(" ") + 1))}`;
  if (kind === "trace") {
    const n = series.filter((one) => one.panel === series[0].panel).reduce((sum, one) => sum + one.x.length, 0);
    return `${t("traceOf", { session: name })}, µm${n > 0 ? `, n = ${countText(n)}` : ""}`;
  }
  const variable = name === "time" ? t("time") : name === "temperature" ? t("temperature") : name;
  // "EXX-X": an error and the axis that it changes along.
  if (kind === "found" || kind === "orders") {
    const [symbol, axis] = name.split("-");
    return `${t(kind === "found" ? "foundOver" : "ordersOf", { name: symbol, axis })}${unit}, n = ${countText(readings)}`;
  }
  return `${t(kind === "spectrum" ? "spectrumOver" : "residualsOver", { variable })}, µm, n = ${countText(readings)}`;
}

// Drawn by the server when they are asked for: that binds and fits all sessions again.
export function Pictures(props: { id: bigint }) {
  const [isAsked, setAsked] = useState(false);
  const found = useLoad(`pictures ${props.id} ${isAsked} ${language.value}`, async () =>
    isAsked ? calibrations.drawCalibration({ calibrationId: props.id, language: language.value }) : undefined,
  );
  return (
    <section>
      <h2>{t("pictures")}</h2>
      <p>{t("picturesHelp")}</p>
      {!isAsked ? (
        <p class="buttons">
          <button type="button" class="quiet" onClick={() => setAsked(true)}>
            {t("drawPictures")}
          </button>
        </p>
      ) : (
        <Show of={found.data === undefined ? { problem: found.problem } : { data: found.data }} rows={8}>
          {(drawn) => (
            <>
              {drawn.pictures.length === 0 && <p>{t("picturesNone")}</p>}
              {drawn.pictures.map((one) => (
                <ServerPicture
                  key={`${language.value} ${one.file}`}
                  name={`calibration-${props.id}-${one.file.replace(/\.svg$/, "")}`}
                  caption={captionOf(one, drawn.readings)}
                  picture={one}
                  load={async () => (await calibrations.drawCalibration({ calibrationId: props.id, file: one.file, language: language.value })).pictures[0]}
                />
              ))}
              {drawn.leftOut.length > 0 && <p>{t("picturesLeftOut", { names: drawn.leftOut.join(", ") })}</p>}
            </>
          )}
        </Show>
      )}
    </section>
  );
}

export function CalibrationPage(props: { id: bigint }) {
  const found = useLoad(`calibration ${props.id}`, () => load(props.id));
  const [placed, setPlaced] = useState<bigint>();
  return (
    <>
    <Title text={t("calibrationN", { n: props.id })}>{found.data && <StateMark state={found.data.it.state} />}</Title>
    <Show of={found} rows={8}>
      {(data) => {
        const { it } = data;
        const report = jsonOf<IdentificationReport & Partial<LoopReport>>(it.reportJson) ?? {};
        const loop = report.verdict === undefined ? undefined : (report as LoopReport);
        const readings = report.sessions?.reduce((sum, s) => sum + s.readings, 0);
        const stats = it.statistics;
        return (
          <>
            <p class="lead">
              <a href={`#/machines/${encodeURIComponent(it.machineId)}`}>{it.machineId}</a>, {t("versionN", { n: it.version })},{" "}
              {it.provenance && t("measuredOn", { day: dayText(it.provenance.measuredUtcUs) })}
            </p>
            {it.rejectedSessionIds.length > 0 && <p class="box bad">{t("standsOnRejected", { list: it.rejectedSessionIds.join(", ") })}</p>}
            <Decide data={data} />
            {loop && (
              <p>
                <a href={`#/loops/${it.calibrationId}`}>{t("loopLink")}</a>
              </p>
            )}
            <HeardOf of={data.heard} />
            <Warnings list={report.warnings} />
            <Found it={it} coverage={report.coverage_factor ?? kNormal95} readings={readings} />
            <NotSeparable it={it} loop={loop} />
            <section>
              <h2>{t("fit")}</h2>
              <dl class="facts">
                <Fact name={t("rms")}>
                  {stats?.rmsBeforeUm === undefined ? "–" : numberText(stats.rmsBeforeUm)} →{" "}
                  {stats?.rmsAfterUm === undefined ? "–" : numberText(stats.rmsAfterUm)} µm
                </Fact>
                <Fact name={t("chi2")}>{stats?.chi2PerDof === undefined ? "–" : numberText(stats.chi2PerDof)}</Fact>
                <Fact name={t("rankOf")}>{stats?.rank}</Fact>
                <Fact name={t("condition")}>{stats?.condition === undefined ? "–" : numberText(stats.condition)}</Fact>
              </dl>
              <p class="muted">{t("fitHelp")}</p>
              {report.sessions && (
                <Table label={t("perSession")} head={[t("sessions"), t("readings"), `${t("rms")}, µm`, `${t("greatest")}, µm`]} numbers={[1, 2, 3]}>
                  {report.sessions.map((s) => (
                    <tr>
                      <th scope="row">{s.session}</th>
                      <td class="number">{countText(s.readings)}</td>
                      <td class="number">{numberText(s.rms_um)}</td>
                      <td class="number">{numberText(s.max_um)}</td>
                    </tr>
                  ))}
                </Table>
              )}
            </section>
            <Pictures id={it.calibrationId} />
            <section id="differences">
              <h2>{t("differences")}</h2>
              <Differences key={String(it.calibrationId)} it={it} inUse={data.inUse} mayChoose onPlaced={() => setPlaced(it.calibrationId)} />
            </section>
            {placed === it.calibrationId && (
            <>
            <section>
              <h2>{t("provenance")}</h2>
              <dl class="facts">
                <Fact name={t("job")}>
                  {it.provenance && <a href={`#/jobs/${it.provenance.jobId}`}>{t("jobN", { n: it.provenance.jobId })}</a>}
                </Fact>
                <Fact name={t("by")}>{it.provenance?.createdBy}</Fact>
                <Fact name={t("created")}>{timeText(it.createdUtcUs)}</Fact>
                <Fact name={t("engine")}>{it.provenance?.engineVersion}</Fact>
                <Fact name={t("approvedAt")}>
                  {it.approvedUtcUs === undefined ? "–" : `${timeText(it.approvedUtcUs)}, ${it.approvedBy}`}
                </Fact>
                {it.retiredUtcUs !== undefined && <Fact name={t("retiredAt")}>{timeText(it.retiredUtcUs)}</Fact>}
              </dl>
              {it.decisions.length > 0 && (
                <Table label={t("decisions")} head={[t("time"), t("what"), t("who"), t("why")]}>
                  {it.decisions.map((one) => (
                    <tr>
                      <th scope="row">{timeText(one.atUtcUs)}</th>
                      <td>{t(one.state === CalibrationState.APPROVED ? "approvedAt" : "retiredAt")}</td>
                      <td>{one.principal}</td>
                      <td class="text">{one.reason || "–"}</td>
                    </tr>
                  ))}
                </Table>
              )}
              <p class="buttons no-print">
                <button type="button" class="quiet" onClick={() => save(`errors-${it.calibrationId}.json`, "application/json", it.modelJson)}>
                  errors.json
                </button>
                <button type="button" class="quiet" onClick={() => save(`report-${it.calibrationId}.json`, "application/json", it.reportJson)}>
                  {t("report")}
                </button>
                <a class="button" href={`v1/calibrations/${it.calibrationId}/report?language=${language.value}`} target="_blank" rel="noopener">
                  {t("print")}
                </a>
              </p>
            </section>
            <MakeTable it={it} />
            </>
            )}
            {it.estimates.length === 0 && <Empty text={t("none")} />}
          </>
        );
      }}
    </Show>
    </>
  );
}
