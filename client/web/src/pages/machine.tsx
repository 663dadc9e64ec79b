// One machine: what happened to it, each error over time, its calibrations and sessions, and a new calibration from them.
import { create } from "@bufbuild/protobuf";
import { useState } from "preact/hooks";
import { all, epoch, events, history, ingest, problemOf, useLoad, type Problem, Refusal } from "../api";
import { known, open } from "../care";
import { jumpWords, suspectWords } from "../certainty";
import { countText, dayText, figureText, numberText, proseText, sigmaText, timeText, unitText, valueText } from "../format";
import { CalibrationState, type Calibration } from "../gen/axiscal/v1/calibration_pb";
import { DriftFindingKind, MarkKind, type DriftAmount, type DriftFinding, type DriftSeries, type ErrorForecast, type FindDriftResponse, type LimitForecast, type Mark } from "../gen/axiscal/v1/history_service_pb";
import { CloseLoopParamsSchema, IdentifyParamsSchema } from "../gen/axiscal/v1/job_pb";
import { SessionState, type Session } from "../gen/axiscal/v1/session_pb";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { isNew, isOpen, isShelved, listEvents } from "../events";
import { EventKind, type Event, type GetExpectationsResponse } from "../gen/axiscal/v1/events_service_pb";
import { TimeLine, type Band, type EventMark, type TimePoint } from "../charts";
import type { VolumetricError } from "../gen/axiscal/v1/volumetric_pb";
import { Asking, Empty, ErrorWords, Fact, Figure, FormDialog, ProblemBox, Quoted, Server, Show, StateMark, Table, Title, Worded, fieldOf, noteOf, usePlaced } from "../parts";
import { eventSaid, findingSaid, limitSaid } from "../german";
import { isoWords } from "../iso";
import { refusalSaid } from "../refusals";
import { calibrations, createJob, machines } from "../services";
import { may } from "../session";
import { kindText } from "./events";
import { Priority } from "./jobs";
import { t, tMaybe } from "../text";

const kMostCalibrations = 2000;
const kMostSessions = 300;
const kMostPoints = 400;
// 95 % of a normal distribution, as the server's own intervals with known sigma.
const kCoverage = 1.96;
const kDayUs = 86_400_000_000n;

interface MachineData {
  isDeleted: boolean;
  list: Calibration[]; // newest first
  isWhole: boolean;
  series: DriftSeries[];
  drift: FindDriftResponse;
  sessions: Session[];
  sessionsWhole: boolean;
  events: Event[]; // newest first
  expected: GetExpectationsResponse;
}

async function loadMachine(machineId: string): Promise<MachineData> {
  const [machine, list, series, drift, sessions, standing, expected] = await Promise.all([
    machines.getMachine({ machineId }),
    all(kMostCalibrations, async (pageToken) => {
      const page = await calibrations.listCalibrations({ machineId, pageSize: 1000, pageToken });
      return { rows: page.calibrations, nextPageToken: page.nextPageToken };
    }),
    history.queryDrift({ machineId, maxPoints: kMostPoints }),
    history.findDrift({ machineId, countsCandidates: true }),
    all(kMostSessions, async (pageToken) => {
      const page = await ingest.listSessions({ machineId, state: SessionState.COMPLETE, pageSize: kMostSessions, pageToken });
      return { rows: page.sessions, nextPageToken: page.nextPageToken };
    }),
    listEvents(machineId, false),
    events.getExpectations({ machineId }),
  ]);
  return {
    isDeleted: machine.machine?.deletedUtcUs !== undefined,
    list: list.rows,
    isWhole: list.isWhole,
    series: series.series,
    drift,
    sessions: sessions.rows,
    sessionsWhole: sessions.isWhole,
    events: standing.rows,
    expected,
  };
}

function CertaintyWords(props: { kind: DriftFindingKind; amounts: DriftAmount[]; certainty?: number }) {
  const { kind, amounts, certainty } = props;
  const words = kind === DriftFindingKind.STEP ? jumpWords(amounts, certainty) : kind === DriftFindingKind.SUSPECT ? suspectWords(certainty) : "";
  return words === "" ? null : <p class="muted">{words}</p>;
}

function Findings(props: { data: MachineData }) {
  const { data } = props;
  const { inUse } = known(data.list);
  const now = open(data.drift.findings, inUse);
  if (data.list.length === 0) return <Empty text={t("happenedEmpty")} />;
  return (
    <>
      {data.drift.findings.length === 0 && <p>{t("happenedNothing", { n: data.drift.calibrationIds.length })}</p>}
      <ul class="findings">
        {[...data.drift.findings].reverse().map((finding) => (
          <li class={finding.isOver ? "over" : now.includes(finding) ? "now" : ""}>
            <Worded said={findingSaid(finding)} text={finding.text} /> <ErrorWords text={finding.text} />{" "}
            {now.includes(finding) && <CertaintyWords kind={finding.kind} amounts={finding.amounts} certainty={finding.certainty} />}
            {finding.isOver && <span class="mark old">{t("over")}</span>}
            {now.includes(finding) && inUse && <span class="mark bad">{t("since")}</span>}
          </li>
        ))}
        {data.drift.notCounted.map((one) => (
          <li>
            {t("notCounted")}: <a href={`#/calibrations/${one.calibrationId}`}>{t("calibrationN", { n: one.calibrationId })}</a>:{" "}
            <Server text={one.text} />
          </li>
        ))}
      </ul>
    </>
  );
}

// What stands and is not on the shelf; its page has the rest, and what one can do.
function OpenEvents(props: { data: MachineData; machineId: string }) {
  const heard = props.data.events.filter((event) => isOpen(event) && !isShelved(event));
  return (
    <section>
      <h2>{t("events")}</h2>
      {heard.length === 0 ? (
        <p>{t("eventsNone")}</p>
      ) : (
        <ul class="findings">
          {heard.map((event) => (
            <li class={isNew(event) ? "now" : ""}>
              <strong>{kindText(event)}</strong>: <Worded said={eventSaid(event)} text={event.text} /> <ErrorWords text={event.text} />{" "}
              {isNew(event) ? <span class="mark bad">{t("eventNew")}</span> : <span class="mark wait">{t("eventSeen")}</span>}
            </li>
          ))}
        </ul>
      )}
      <p>
        <a href={`#/events/${encodeURIComponent(props.machineId)}`}>{t("allEvents")}</a>
      </p>
    </section>
  );
}

function bandsOf(findings: DriftFinding[], symbol: string): Band[] {
  return findings
    .filter((f) => f.kind === DriftFindingKind.STEP && f.afterUtcUs && f.byUtcUs && f.amounts.some((a) => a.symbol === symbol))
    .map((f) => ({ fromUs: f.afterUtcUs!, toUs: f.byUtcUs!, label: findingSaid(f)?.text ?? proseText(f.text) }));
}

// Events about an error, each at the calibration that shows it; several of one time are one. Steps are bands already.
function eventsOf(data: MachineData, symbol: string, machineId: string): EventMark[] {
  const measured = new Map(data.list.map((c) => [c.calibrationId, c.provenance?.measuredUtcUs]));
  const found = new Map<bigint, string[]>();
  for (const event of data.events) {
    if (event.kind === EventKind.STEP || !(event.subject === symbol || event.amounts.some((one) => one.symbol === symbol))) continue;
    const us = (event.calibrationId === undefined ? undefined : measured.get(event.calibrationId)) ?? event.raisedUtcUs;
    found.set(us, [...(found.get(us) ?? []), `${kindText(event)}: ${eventSaid(event)?.text ?? proseText(event.text)}${isOpen(event) ? "" : ` (${t("eventCleared")})`}`]);
  }
  const href = `#/events/${encodeURIComponent(machineId)}`;
  return [...found].map(([us, texts]) => ({ us, label: `${dayText(us)}, ${texts.join("; ")}`, href }));
}

const kHourUs = 3_600_000_000n;
export const markText = (mark: Mark) => tMaybe(`mark_${mark.kind}`) ?? String(mark.kind);

// "EX0C -20 20" a line; undefined where a line is none.
function tolerancesOf(text: string): { symbol: string; low: number; high: number }[] | undefined {
  const lines = text.split("\n").map((line) => line.trim().split(/\s+/)).filter((words) => words[0] !== "");
  const rows = lines.map(([symbol, low, high]) => ({ symbol, low: Number(low), high: Number(high) }));
  return rows.every((row, i) => lines[i].length === 3 && Number.isFinite(row.low) && Number.isFinite(row.high)) ? rows : undefined;
}
// "nightly 24" a line; the hours are the last word.
function expectedSessionsOf(text: string): { name: string; everyHours: number }[] | undefined {
  const lines = text.split("\n").map((line) => line.trim()).filter(Boolean);
  const rows = lines.map((line) => ({ name: line.replace(/\s+\S+$/, ""), everyHours: Number(line.split(/\s+/).pop()) }));
  return rows.every((row, i) => row.name !== lines[i] && Number.isInteger(row.everyHours)) ? rows : undefined;
}

// Says what is expected of a machine; what is not named is not expected any more.
function Expect(props: { machineId: string; expected: GetExpectationsResponse; onClose: () => void }) {
  const said = props.expected.expectations;
  const save = async (form: FormData) => {
    const tolerances = tolerancesOf(fieldOf(form, "tolerances")), sessions = expectedSessionsOf(fieldOf(form, "sessions"));
    if (tolerances === undefined) throw new Refusal(t("tolerancesWrong"));
    if (sessions === undefined) throw new Refusal(t("sessionsWrong"));
    const days = fieldOf(form, "days");
    await events.setExpectations({
      machineId: props.machineId,
      etag: props.expected.etag,
      expectations: { tolerances, sessions, calibrationDays: days === "" ? undefined : Number(days), countsCandidates: form.get("candidates") !== null },
    });
    epoch.value++;
  };
  return (
    <FormDialog title={t("expect")} submit={t("save")} intro={<p>{t("expectHelp")}</p>} onSend={save} onClose={props.onClose}>
      <label>
        {t("expectTolerances")}
        <textarea name="tolerances" rows={4} defaultValue={said?.tolerances.map((one) => `${one.symbol} ${one.low} ${one.high}`).join("\n")} />
      </label>
      <label>
        {t("expectSessions")}
        <textarea name="sessions" rows={3} defaultValue={said?.sessions.map((one) => `${one.name} ${one.everyHours}`).join("\n")} />
      </label>
      <label>
        {t("expectDays")}
        <input name="days" type="number" min="1" max="3650" defaultValue={said?.calibrationDays === undefined ? "" : String(said.calibrationDays)} />
      </label>
      <label class="check">
        <input name="candidates" type="checkbox" defaultChecked={said?.countsCandidates} /> {t("expectCandidates")}
      </label>
    </FormDialog>
  );
}

// What comes next, the most urgent first: sessions that come regularly and the age of the calibration in use.
function Due(props: { data: MachineData; machineId: string }) {
  const [isAsked, setAsked] = useState(false);
  const { expectations, etag } = props.data.expected;
  const mayAct = may(Role.TECHNICIAN, props.machineId) || may(Role.APPROVER, props.machineId);
  const now = BigInt(Date.now()) * 1000n;
  const rows: { what: string; isNamed?: boolean; last?: bigint; due?: bigint }[] = (expectations?.sessions ?? []).map((one) => {
    const times = props.data.sessions.filter((s) => s.name === one.name).map((s) => s.measuredUtcUs ?? s.createdUtcUs);
    const last = times.reduce<bigint | undefined>((newest, us) => (newest === undefined || us > newest ? us : newest), undefined);
    return { what: t("dueSession", { name: one.name, n: countText(one.everyHours) }), isNamed: true, last, due: last === undefined ? undefined : last + BigInt(one.everyHours) * kHourUs };
  });
  if (expectations?.calibrationDays !== undefined) {
    const last = known(props.data.list).inUse?.provenance?.measuredUtcUs;
    rows.push({
      what: t("dueCalibration", { n: countText(expectations.calibrationDays) }),
      last,
      due: last === undefined ? undefined : last + BigInt(expectations.calibrationDays) * kDayUs,
    });
  }
  const unitOf = (symbol: string) => unitText(props.data.series.find((one) => one.symbol === symbol)?.unit ?? "");
  rows.sort((a, b) => ((a.due ?? 0n) < (b.due ?? 0n) ? -1 : 1));
  return (
    <section>
      <h2>{t("due")}</h2>
      {rows.length === 0 ? (
        <Empty text={t(etag === 0n ? "dueNothingSaid" : "dueNone")} first={mayAct ? undefined : t("dueFirst")} />
      ) : (
        <Table label={t("due")} head={[t("what"), t("lastTime"), t("dueBy"), t("state")]}>
          {rows.map((row) => (
            <tr>
              <th scope="row" class="text">
                {row.what}
              </th>
              <td>{row.last !== undefined ? timeText(row.last) : t(row.isNamed ? "neverNamed" : "never")}</td>
              <td>{row.due === undefined ? "–" : timeText(row.due)}</td>
              <td>
                {row.due === undefined || row.due < now ? <span class="mark bad">{t("isDue")}</span> : <span class="mark good">{t("notYetDue")}</span>}
              </td>
            </tr>
          ))}
        </Table>
      )}
      {expectations && expectations.tolerances.length > 0 && (
        <p>
          {t("tolerances")}:{" "}
          {expectations.tolerances.map((one) => `${one.symbol} ${numberText(one.low, 6)} … ${numberText(one.high, 6)} ${unitOf(one.symbol)}`.trim()).join("; ")}
        </p>
      )}
      {mayAct && !props.data.isDeleted && (
        <p class="buttons">
          <button type="button" class="quiet" onClick={() => setAsked(true)}>
            {t("expect")}
          </button>
        </p>
      )}
      {isAsked && <Expect machineId={props.machineId} expected={props.data.expected} onClose={() => setAsked(false)} />}
    </section>
  );
}

// How far the tool point is off over the measured box: of the calibration in use, and of those before it where they are asked for. `onPlaced`: it
// is as high now as it will be, so that what stands below may be shown.
function Volumetric(props: { machineId: string; inUse?: Calibration; newest?: Calibration; onPlaced: () => void }) {
  const id = props.inUse?.calibrationId;
  const [isAsked, setAsked] = useState(false);
  const newest = props.newest?.calibrationId;
  const found = useLoad(`volumetric ${id} ${newest}`, async () => {
    if (id === undefined) return undefined;
    const asked = calibrations.getVolumetricError({ calibrationId: id });
    // What a later one cannot say is not said.
    const seen = newest === undefined ? undefined : calibrations.getVolumetricError({ calibrationId: newest }).then(({ error }) => error, () => undefined);
    return { error: (await asked).error, seen: await seen };
  });
  const isPlaced = found.data !== undefined || found.problem !== undefined;
  usePlaced(isPlaced, props.onPlaced);
  const past = useLoad(`volumetric history ${props.machineId} ${isAsked}`, async () =>
    isAsked ? (await calibrations.listVolumetricErrors({ machineId: props.machineId, pageSize: 40 })).errors : undefined,
  );
  if (id === undefined) return null;
  return (
    <section>
      <h2>{t("volumetric")}</h2>
      {found.problem && !found.problem.isConnection ? (
        <p>
          <Quoted said={refusalSaid(found.problem)} text={found.problem.text} />
        </p>
      ) : (
        <Show of={{ data: found.data?.error }} rows={3}>
          {(error) => (
            <>
              <p>
                {t("overBox")}{" "}
                {error.box
                  .filter((span) => span.toMmOrDeg > span.fromMmOrDeg)
                  .map((span) => `${span.axis} ${numberText(span.fromMmOrDeg, 4)} … ${numberText(span.toMmOrDeg, 4)}`)
                  .join(", ")}{" "}
                ({t("mmOrDeg")}), {t("poses", { n: countText(error.poses) })}
              </p>
              <dl class="facts">
                <Fact name={t("asIs")}>{figureText(error.uncorrected)} µm</Fact>
                {error.before && <Fact name={t("correctedBefore", { n: error.beforeCalibrationId ?? "" })}>{figureText(error.before)} µm</Fact>}
                <Fact name={t("correctedNow")}>{figureText(error.after)} µm</Fact>
                {found.data?.seen?.before?.rms && <Fact name={t("correctedSeen", { n: newest ?? "" })}>{figureText(found.data.seen.before)} µm</Fact>}
              </dl>
              <p class="muted">{t("volumetricHelp")}</p>
              {error.unknown.length > 0 && (
                <p class="box">
                  {t("volumetricUnknown")} {error.unknown.join(", ")}
                </p>
              )}
            </>
          )}
        </Show>
      )}
      {!isPlaced ? null : !isAsked ? (
        <p class="buttons">
          <button type="button" class="quiet" onClick={() => setAsked(true)}>
            {t("volumetricPast")}
          </button>
        </p>
      ) : (
        <Show of={{ data: past.data, problem: past.problem }} rows={6}>
          {(list) => <VolumetricPast machineId={props.machineId} list={list} />}
        </Show>
      )}
    </section>
  );
}

function VolumetricPast(props: { machineId: string; list: VolumetricError[] }) {
  const known = props.list.filter((one) => one.uncorrected?.rms !== undefined).reverse();
  const caption = t("volumetricOverTime", { n: countText(known.length) });
  const times = known.map((one) => one.measuredUtcUs);
  const first = times[0] ?? 0n, last = times[times.length - 1] ?? 0n;
  const room = (last - first) / 50n + kDayUs / 2n;
  const head = [t("calibration"), t("measured"), t("asIs"), t("before"), t("after")];
  const shown = props.list.map((one) => [
    t("calibrationN", { n: one.calibrationId }),
    dayText(one.measuredUtcUs),
    figureText(one.uncorrected),
    figureText(one.before),
    one.problem === "" ? figureText(one.after) : one.problem,
  ]);
  return (
    <>
      {known.length > 1 && (
        <Figure
          name={`${props.machineId}-volumetric`}
          caption={caption}
          head={[t("time"), "calibration", "as it is, um", "95 % −", "95 % +", "after, um", "95 % −", "95 % +"]}
          rows={known.map((one) => [
            new Date(Number(one.measuredUtcUs / 1000n)).toISOString(),
            String(one.calibrationId),
            one.uncorrected!.rms!.expectedUm,
            one.uncorrected!.rms!.lowUm,
            one.uncorrected!.rms!.highUm,
            one.after?.rms?.expectedUm,
            one.after?.rms?.lowUm,
            one.after?.rms?.highUm,
          ])}
        >
          <TimeLine
            title={caption}
            points={known.map((one) => ({
              us: one.measuredUtcUs,
              value: one.uncorrected!.rms!.expectedUm,
              low: one.uncorrected!.rms!.lowUm,
              high: one.uncorrected!.rms!.highUm,
              wasApproved: one.state !== CalibrationState.CANDIDATE,
              label: `${dayText(one.measuredUtcUs)}: ${figureText(one.uncorrected)} µm`,
              href: `#/calibrations/${one.calibrationId}`,
            }))}
            bands={[]}
            approvals={[]}
            marks={[]}
            events={[]}
            foretold={[]}
            fromUs={first - room}
            toUs={last + room}
          />
        </Figure>
      )}
      <p>{t("volumetricPastHelp")}</p>
      <Table label={t("volumetricPast")} head={head} numbers={[2, 3, 4]}>
        {shown.map((row, i) => (
          <tr>
            <th scope="row">
              <a href={`#/calibrations/${props.list[i].calibrationId}`}>{row[0]}</a>
            </th>
            <td>{row[1]}</td>
            <td class="number">{row[2]}</td>
            <td class="number">{row[3]}</td>
            <td class={props.list[i].problem === "" ? "number" : "text"} lang={props.list[i].problem === "" ? undefined : "en"}>
              {row[4]}
            </td>
          </tr>
        ))}
      </Table>
    </>
  );
}

const kMarkKinds = [MarkKind.COLLISION, MarkKind.SERVICE, MarkKind.REFIXTURING];

// What people say has happened: where it stands, and what was known ends there.
function Marks(props: { data: MachineData; machineId: string }) {
  // The request's number while it is asked: sent again after an answer that was lost, it is the same mark.
  const [isAsked, setAsked] = useState("");
  const mayAct = may(Role.TECHNICIAN, props.machineId) || may(Role.APPROVER, props.machineId);
  const marks = [...props.data.drift.marks].reverse();
  const put = async (form: FormData) => {
    const at = Date.parse(fieldOf(form, "at"));
    if (Number.isNaN(at)) throw new Refusal(t("timeNeeded"));
    await history.putMark({
      requestId: isAsked,
      machineId: props.machineId,
      atUtcUs: BigInt(at) * 1000n,
      kind: Number(form.get("kind")) as MarkKind,
      symbols: form.getAll("symbol").map(String).filter(Boolean),
      note: noteOf(form, true),
    });
    epoch.value++;
  };
  const withdraw = async (mark: Mark) => {
    await history.withdrawMark({ markId: mark.markId });
    epoch.value++;
  };
  const symbols = props.data.series.map((s) => s.symbol);
  return (
    <section>
      <h2>{t("marks")}</h2>
      <p>{t("marksHelp")}</p>
      {marks.length === 0 ? (
        <p>{t("marksNone")}</p>
      ) : (
        <Table label={t("marks")} head={[t("time"), t("kind"), t("markErrors"), t("notes"), t("by"), ...(mayAct ? [t("withdraw")] : [])]}>
          {marks.map((mark) => (
            <tr key={String(mark.markId)}>
              <th scope="row">{timeText(mark.atUtcUs)}</th>
              <td>{markText(mark)}</td>
              <td>{mark.symbols.length === 0 ? t("allErrors") : mark.symbols.join(", ")}</td>
              <td class="text">{mark.note}</td>
              <td>{mark.createdBy}</td>
              {mayAct && (
                <td>
                  <Asking
                    text={t("withdraw")}
                    of={mark.note}
                    effect={t("withdrawEffect", { by: mark.createdBy, time: timeText(mark.createdUtcUs) })}
                    onSure={() => withdraw(mark)}
                  />
                </td>
              )}
            </tr>
          ))}
        </Table>
      )}
      {mayAct && !props.data.isDeleted && (
        <p class="buttons">
          <button type="button" class="quiet" onClick={() => setAsked(crypto.randomUUID())}>
            {t("putMark")}
          </button>
        </p>
      )}
      {isAsked && (
        <FormDialog title={t("putMark")} submit={t("putMark")} intro={<p>{t("marksHelp")}</p>} isPlain onSend={put} onClose={() => setAsked("")}>
          <label>
            {t("kind")}
            <select name="kind">
              {kMarkKinds.map((kind) => (
                <option value={kind}>{tMaybe(`mark_${kind}`)}</option>
              ))}
            </select>
          </label>
          <label>
            {t("happenedAt")}
            <input name="at" type="datetime-local" required />
          </label>
          {symbols.length > 0 && (
            <label>
              {t("markErrorsHelp")}
              <select name="symbol" multiple size={Math.min(5, symbols.length)}>
                {symbols.map((symbol) => (
                  <option value={symbol}>{symbol}</option>
                ))}
              </select>
            </label>
          )}
          <label>
            {t("markWord")}
            <input name="note" required autocomplete="off" />
          </label>
        </FormDialog>
      )}
    </section>
  );
}

// Drawn with the error as long as no other limits are asked for.
function toleranceOf(data: MachineData, symbol: string): [number, number] | undefined {
  const found = data.expected.expectations?.tolerances.find((one) => one.symbol === symbol);
  return found && [found.low, found.high];
}

const kForecastDays = [0, 90, 365, 1826];

function History(props: { data: MachineData; machineId: string; limits: Map<string, [number, number]> }) {
  const { data } = props;
  const [days, setDays] = useState(0);
  const foretold = useLoad(`forecast ${props.machineId} ${days}`, async () =>
    days === 0 ? undefined : history.findDrift({ machineId: props.machineId, countsCandidates: true, forecastDays: days }),
  );
  const forecasts = new Map<string, ErrorForecast>(foretold.data?.forecasts.map((one) => [one.symbol, one]));
  const shown = data.series.filter((s) => s.points.length > 0);
  const never = data.series.filter((s) => s.points.length === 0).map((s) => s.symbol);
  const times = shown.flatMap((s) => s.points.flatMap((p) => [p.firstUtcUs, p.lastUtcUs]));
  const ofTimes = times.reduce<[bigint, bigint]>(([a, b], us) => [us < a ? us : a, us > b ? us : b], [times[0] ?? 0n, times[0] ?? 0n]);
  const [zoom, setZoom] = useState<[string, string]>(["", ""]);
  const day = (text: string, otherwise: bigint, after = 0n) =>
    text === "" || Number.isNaN(Date.parse(text)) ? otherwise : BigInt(Date.parse(text)) * 1000n + after;
  const room = (ofTimes[1] - ofTimes[0]) / 50n + kDayUs / 2n;
  const from = day(zoom[0], ofTimes[0] - room), to = day(zoom[1], ofTimes[1] + room + BigInt(days) * kDayUs, kDayUs);
  if (shown.length === 0) return null;
  const byId = new Map(data.list.map((c) => [c.calibrationId, c]));
  const approvals = data.list.filter((c) => c.approvedUtcUs !== undefined).map((c) => c.provenance?.measuredUtcUs ?? 0n);
  return (
    <section>
      <h2>{t("timeLine")}</h2>
      <p>{t("timeLineHelp")}</p>
      <div class="filters">
        <label>
          {t("from")}
          <input type="date" value={zoom[0]} onInput={(event) => setZoom([event.currentTarget.value, zoom[1]])} />
        </label>
        <label>
          {t("to")}
          <input type="date" value={zoom[1]} onInput={(event) => setZoom([zoom[0], event.currentTarget.value])} />
        </label>
        <label>
          {t("forecast")}
          <select value={days} onChange={(event) => setDays(Number(event.currentTarget.value))}>
            {kForecastDays.map((n) => (
              <option value={n}>{n === 0 ? t("none") : t("forecastDays", { n: countText(n) })}</option>
            ))}
          </select>
        </label>
      </div>
      {days > 0 && <p role="status">{foretold.data ? t("forecastHelp") : foretold.problem ? "" : t("loading")}</p>}
      {foretold.problem && <ProblemBox problem={foretold.problem} />}
      {to > from &&
        shown.map((series) => {
          const unit = unitText(series.unit);
          const points: (TimePoint & { sigma?: number })[] = series.points
            .filter((p) => p.lastUtcUs >= from && p.firstUtcUs <= to)
            .map((p) => {
              const half = p.count === 1n ? kCoverage * (p.sigma ?? 0) : 0;
              const calibration = byId.get(p.lastCalibrationId);
              return {
                us: p.lastUtcUs,
                value: p.meanValue,
                low: Math.min(p.minValue, p.meanValue - half),
                high: Math.max(p.maxValue, p.meanValue + half),
                sigma: p.sigma,
                wasApproved: calibration?.approvedUtcUs !== undefined,
                label: `${dayText(p.lastUtcUs)}: ${valueText(p.meanValue, p.sigma)} ${unit}`,
                href: `#/calibrations/${p.lastCalibrationId}`,
              };
            });
          const n = series.points.reduce((sum, p) => sum + p.count, 0n);
          const words = isoWords(series.symbol);
          const caption = t("timeLineOf", { name: series.symbol, unit, n: countText(n) }) + (words && `; ${words}`);
          const forecast = forecasts.get(series.symbol);
          const later = forecast?.points ?? [];
          const told = t("forecast");
          const bands = bandsOf(data.drift.findings, series.symbol).filter((b) => b.toUs > from && b.fromUs < to);
          const marks = data.drift.marks.filter((m) => m.symbols.length === 0 || m.symbols.includes(series.symbol));
          const heard = eventsOf(data, series.symbol, props.machineId).filter((one) => one.us >= from && one.us <= to);
          const isoTime = (us: bigint) => new Date(Number(us / 1000n)).toISOString();
          // What has no value, in the table and in the file.
          const toldOf = [
            ...bands.map((b) => ({ us: b.toUs, text: b.label })),
            ...marks.map((m) => ({ us: m.atUtcUs, text: `${markText(m)}: ${m.note}` })),
            ...heard.map((one) => ({ us: one.us, text: one.label })),
          ];
          return (
            <Figure
              name={`${props.machineId}-${series.symbol}`}
              caption={
                series.notIdentifiableCount > 0n ? `${caption}; ${t("notTold", { n: countText(series.notIdentifiableCount) })}` : caption
              }
              head={[t("time"), `${t("value")} (${unit})`, "95 % −", "95 % +", `1 σ (${unit})`, t("notes")]}
              words={5}
              rows={[
                ...points.map((p) => [isoTime(p.us), p.value, p.low, p.high, p.sigma, p.wasApproved ? t("wasInUse") : ""]),
                ...later.map((p) => [isoTime(p.atUtcUs), p.value, p.low, p.high, undefined, "forecast, 90 %"]),
                ...toldOf.map((one) => [isoTime(one.us), undefined, undefined, undefined, undefined, one.text]),
              ]}
              shown={[
                ...points.map((p) => [
                  dayText(p.us),
                  valueText(p.value, p.sigma),
                  valueText(p.low, p.sigma),
                  valueText(p.high, p.sigma),
                  p.sigma === undefined ? "–" : sigmaText(p.sigma),
                  p.wasApproved ? t("wasInUse") : "",
                ]),
                ...later.map((p) => [dayText(p.atUtcUs), numberText(p.value, 4), numberText(p.low, 4), numberText(p.high, 4), "–", `${told}, 90 %`]),
                ...toldOf.map((one) => [dayText(one.us), "–", "–", "–", "–", one.text]),
              ]}
            >
              <TimeLine
                title={caption}
                points={points}
                bands={bands}
                approvals={approvals}
                marks={marks.map((m) => ({ us: m.atUtcUs, label: `${dayText(m.atUtcUs)}, ${markText(m)}: ${m.note}` }))}
                events={heard}
                foretold={later.map((p) => ({ us: p.atUtcUs, value: p.value, low: p.low, high: p.high }))}
                fromUs={from}
                toUs={to}
                limits={props.limits.get(series.symbol) ?? toleranceOf(data, series.symbol)}
              />
            </Figure>
          );
        })}
      {[...forecasts.values()]
        .filter((one) => one.text !== "")
        .map((one) => (
          <p>
            {one.symbol}: <Quoted said={t("noForecast")} text={one.text} />
          </p>
        ))}
      {never.length > 0 && <p>{t("neverTold", { names: never.join(", ") })}</p>}
    </section>
  );
}

function Limits(props: { machineId: string; data: MachineData; onLimits: (limits: Map<string, [number, number]>) => void }) {
  const symbols = props.data.series.filter((s) => s.points.length > 0);
  const [symbol, setSymbol] = useState(symbols[0]?.symbol ?? "");
  const [answer, setAnswer] = useState<{ limit?: LimitForecast; problem?: Problem }>({});
  if (symbols.length === 0) return null;
  const ask = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    const low = Number(form.get("low")), high = Number(form.get("high"));
    try {
      const found = await history.findDrift({ machineId: props.machineId, countsCandidates: true, limits: [{ symbol, low, high }] });
      setAnswer({ limit: found.limits[0] });
      props.onLimits(new Map([[symbol, [low, high]]]));
    } catch (error) {
      setAnswer({ problem: problemOf(error) });
    }
  };
  const unit = unitText(symbols.find((s) => s.symbol === symbol)?.unit ?? "");
  return (
    <section>
      <h2>{t("limits")}</h2>
      <form class="filters" onSubmit={ask}>
        <label>
          {t("error")}
          <select value={symbol} onChange={(event) => setSymbol(event.currentTarget.value)}>
            {symbols.map((s) => (
              <option value={s.symbol}>{s.symbol}</option>
            ))}
          </select>
        </label>
        <label>
          {t("low")}, {unit}
          <input name="low" type="number" step="any" required />
        </label>
        <label>
          {t("high")}, {unit}
          <input name="high" type="number" step="any" required />
        </label>
        <button type="submit">{t("foretell")}</button>
      </form>
      <div role="status">
        {answer.limit && (
          <p class="box">
            <Worded said={limitSaid(answer.limit)} text={answer.limit.text} />
          </p>
        )}
      </div>
      {answer.problem && <ProblemBox problem={answer.problem} />}
    </section>
  );
}

function CalibrationList(props: { data: MachineData }) {
  const [most, setMost] = useState(12);
  const { list } = props.data;
  if (list.length === 0) return null;
  return (
    <section>
      <h2>{t("calibrationsTitle")}</h2>
      <Table label={t("calibrationsTitle")} head={[t("calibration"), t("state"), t("measured"), t("by"), t("approvedAt"), t("rms")]} numbers={[5]}>
        {list.slice(0, most).map((c) => (
          <tr>
            <th scope="row">
              <a href={`#/calibrations/${c.calibrationId}`}>
                {t("calibrationN", { n: c.calibrationId })}, {t("versionN", { n: c.version })}
              </a>
            </th>
            <td>
              <StateMark state={c.state} />
            </td>
            <td>{c.provenance && dayText(c.provenance.measuredUtcUs)}</td>
            <td>{c.provenance?.createdBy}</td>
            <td>{c.approvedUtcUs !== undefined ? `${timeText(c.approvedUtcUs)}, ${c.approvedBy}` : "–"}</td>
            <td class="number">{c.statistics?.rmsAfterUm !== undefined ? `${valueText(c.statistics.rmsAfterUm)} µm` : "–"}</td>
          </tr>
        ))}
      </Table>
      {list.length > most && (
        <p class="buttons">
          {t("shownOf", { n: most, all: list.length })}{" "}
          <button type="button" class="quiet" onClick={() => setMost(most + 100)}>
            {t("more")}
          </button>
        </p>
      )}
    </section>
  );
}

// What people say of a session, and whether it counts; who may says otherwise with a reason.
function Remark(props: { session: Session; mayAct: boolean }) {
  const { sessionId, name, remark } = props.session;
  const [isAsked, setAsked] = useState(false);
  const isRejected = remark?.isRejected ?? false;
  const decide = async (form: FormData) => {
    await ingest.rejectSession({ sessionId, isRejected: !isRejected, reason: noteOf(form, true) });
    epoch.value++;
  };
  const text = t(isRejected ? "sessionAccept" : "sessionReject");
  return (
    <>
      {isRejected && <span class="mark bad">{t("sessionRejected")}</span>} {isRejected && remark?.reason}
      {remark?.note} {remark?.labels.map((label) => <span class="mark old">{label}</span>)}{" "}
      {props.mayAct && (
        <button type="button" class="quiet" aria-label={`${text}: ${name}`} onClick={() => setAsked(true)}>
          {text}
        </button>
      )}
      {isAsked && (
        <FormDialog
          title={`${text}: ${name}`}
          submit={text}
          intro={<p>{t(isRejected ? "sessionAcceptEffect" : "sessionRejectEffect")}</p>}
          isPlain
          onSend={decide}
          onClose={() => setAsked(false)}
        >
          <label>
            {t("whyWord")}
            <input name="note" required autocomplete="off" />
          </label>
        </FormDialog>
      )}
    </>
  );
}

// Sessions with what a new calibration shall do with each.
function NewCalibration(props: { data: MachineData; machineId: string }) {
  const [roles, setRoles] = useState(new Map<bigint, "fit" | "check">());
  const [most, setMost] = useState(10);
  const [problem, setProblem] = useState<Problem>();
  const { sessions } = props.data;
  const [onlyRejected, setOnlyRejected] = useState(false);
  const [priority, setPriority] = useState(0);
  const mayRun = may(Role.TECHNICIAN, props.machineId) && !props.data.isDeleted;
  const mayReject = may(Role.TECHNICIAN, props.machineId) || may(Role.APPROVER, props.machineId);
  const rejected = sessions.filter((s) => s.remark?.isRejected);
  const listed = onlyRejected ? rejected : sessions;
  const of = (role: string) => sessions.filter((s) => roles.get(s.sessionId) === role && !s.remark?.isRejected).map((s) => s.sessionId);
  const fit = of("fit"), check = of("check");
  const run = async (isLoop: boolean) => {
    try {
      const id = await createJob(
        isLoop
          ? { case: "closeLoop", value: create(CloseLoopParamsSchema, { machineId: props.machineId, fitSessionIds: fit, checkSessionIds: check }) }
          : { case: "identify", value: create(IdentifyParamsSchema, { machineId: props.machineId, sessionIds: fit }) },
        priority,
      );
      location.hash = `#/jobs/${id}`;
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  return (
    <section>
      <h2>{mayRun ? t("newCalibration") : t("sessions")}</h2>
      {sessions.length === 0 ? (
        <Empty text={t("noSessions")}>
          {may(Role.CELL, props.machineId) ? <a href={`#/upload/${encodeURIComponent(props.machineId)}`}>{t("uploadTitle")}</a> : t("noSessionsHelp")}
        </Empty>
      ) : (
        <>
          {mayRun && <p>{t("chooseSessions")}</p>}
          {rejected.length > 0 && (
            <label class="check">
              <input type="checkbox" checked={onlyRejected} onChange={(event) => setOnlyRejected(event.currentTarget.checked)} />{" "}
              {t("onlyRejected", { n: countText(rejected.length) })}
            </label>
          )}
          <Table
            label={t("sessions")}
            head={[t("name"), t("instrument"), t("readings"), t("measured"), t("by"), ...(mayRun ? [t("use")] : []), t("remark"), t("download")]}
            numbers={[2]}
          >
            {listed.slice(0, most).map((s) => (
              <tr>
                <th scope="row">{s.name}</th>
                <td>{tMaybe(`instrument_${s.instrument}`)}</td>
                <td class="number">{countText(s.readings)}</td>
                <td>{dayText(s.measuredUtcUs ?? s.createdUtcUs)}</td>
                <td>{s.createdBy}</td>
                {mayRun && s.remark?.isRejected && <td>–</td>}
                {mayRun && !s.remark?.isRejected && (
                  <td>
                    <select
                      aria-label={t("useOf", { name: s.name })}
                      value={roles.get(s.sessionId) ?? ""}
                      onChange={(event) => {
                        const next = new Map(roles);
                        const value = event.currentTarget.value;
                        if (value === "") next.delete(s.sessionId);
                        else next.set(s.sessionId, value as "fit" | "check");
                        setRoles(next);
                      }}
                    >
                      <option value="">{t("unusedRole")}</option>
                      <option value="fit">{t("fitRole")}</option>
                      <option value="check">{t("checkRole")}</option>
                    </select>
                  </td>
                )}
                <td class="text">
                  <Remark session={s} mayAct={mayReject} />
                </td>
                <td>
                  <a href={`v1/sessions/${s.sessionId}`} download={`${s.name}.csv`}>
                    CSV
                  </a>
                </td>
              </tr>
            ))}
          </Table>
          <p class="buttons">
            {listed.length > most && (
              <>
                {t("shownOf", { n: most, all: listed.length })}{" "}
                <button type="button" class="quiet" onClick={() => setMost(most + 50)}>
                  {t("more")}
                </button>
              </>
            )}
            {!props.data.sessionsWhole && t("notAll", { n: sessions.length })}
          </p>
          {mayRun && <Priority value={priority} onChange={setPriority} />}
          {mayRun && (
            <p class="buttons">
              <button type="button" disabled={fit.length === 0 || check.length > 0} onClick={() => void run(false)}>
                {t("identify")}
              </button>
              <button type="button" disabled={fit.length === 0} onClick={() => void run(true)}>
                {t("closeLoop")}
              </button>
              {may(Role.CELL, props.machineId) ? <a href={`#/upload/${encodeURIComponent(props.machineId)}`}>{t("uploadTitle")}</a> : t("noSessionsHelp")}
            </p>
          )}
          {problem && <ProblemBox problem={problem} />}
        </>
      )}
    </section>
  );
}

// What tells a good one from another: "residual 1.5 → 0.29 µm".
export function residualText({ statistics: s }: Calibration): string {
  if (s?.rmsBeforeUm === undefined || s.rmsAfterUm === undefined) return "";
  return t("residualOf", { before: numberText(s.rmsBeforeUm), after: numberText(s.rmsAfterUm) });
}

export function MachinePage(props: { machineId: string }) {
  const machine = useLoad(`machine ${props.machineId}`, () => loadMachine(props.machineId), 60_000);
  const [limits, setLimits] = useState(new Map<string, [number, number]>());
  const [placed, setPlaced] = useState("");
  return (
    <>
      <Title text={props.machineId} />
      <Show of={machine} rows={8}>
        {(data) => {
          const { inUse, waiting } = known(data.list);
          return (
            <>
              {data.isDeleted && <p class="box">{t("deleted")}</p>}
              {inUse && (
                <p class="lead">
                  {t("inUse")}: <a href={`#/calibrations/${inUse.calibrationId}`}>{t("calibrationN", { n: inUse.calibrationId })}</a>,{" "}
                  {[inUse.provenance && t("measuredOn", { day: dayText(inUse.provenance.measuredUtcUs) }), residualText(inUse)].filter(Boolean).join(", ")}
                </p>
              )}
              {waiting.length > 0 && (
                <p class="lead">
                  {t("waitsForDecision")}:{" "}
                  {waiting.slice(0, 3).map((one, i) => (
                    <>
                      {i > 0 && ", "}
                      <a href={`#/calibrations/${one.calibrationId}`}>{t("calibrationN", { n: one.calibrationId })}</a>
                      {` (${[
                        i === 0 && waiting.length > 1 && t("theNewest"),
                        one.provenance && t("measuredOn", { day: dayText(one.provenance.measuredUtcUs) }),
                        residualText(one),
                      ]
                        .filter(Boolean)
                        .join(", ")})`}
                    </>
                  ))}
                  . {t(may(Role.APPROVER, props.machineId) ? "howToDecide" : "howToSee")}
                </p>
              )}
              <section>
                <h2>{t("happened")}</h2>
                <Findings data={data} />
              </section>
              <OpenEvents data={data} machineId={props.machineId} />
              <Volumetric machineId={props.machineId} inUse={inUse} newest={inUse && waiting[0]} onPlaced={() => setPlaced(props.machineId)} />
              {(inUse === undefined || placed === props.machineId) && (
                <>
                  <Due data={data} machineId={props.machineId} />
                  <History data={data} machineId={props.machineId} limits={limits} />
                  <Marks data={data} machineId={props.machineId} />
                  <Limits machineId={props.machineId} data={data} onLimits={setLimits} />
                  <CalibrationList data={data} />
                  {!data.isWhole && <p>{t("notAll", { n: data.list.length })}</p>}
                  <NewCalibration data={data} machineId={props.machineId} />
                </>
              )}
            </>
          );
        }}
      </Show>
    </>
  );
}
