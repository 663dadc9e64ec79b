// Every machine at a glance, those that need care first.
import { useEffect, useMemo, useState } from "preact/hooks";
import { access, all, calibrations, epoch, history, ingest, isConnected, machines, problemOf, useLoad, type Problem } from "../api";
import { careOf, kCares, known, open, type Care, type Known } from "../care";
import { isNew, listEvents } from "../events";
import { countText, dayText, numberText } from "../format";
import { CalibrationState, type Calibration } from "../gen/axiscal/v1/calibration_pb";
import type { Event } from "../gen/axiscal/v1/events_service_pb";
import type { DriftFinding } from "../gen/axiscal/v1/history_service_pb";
import { Empty, ErrorWords, ProblemBox, Server, Show, Table, Title, fieldOf } from "../parts";
import { isAdminOfAll } from "../session";
import { language, t } from "../text";

const kMostMachines = 5000;
const kMostLabelled = 5000; // sessions with a label
const kShownAtOnce = 50;
// Histories asked for at a time: a browser has six connections.
const kAtATime = 2;
const kEveryMs = 60_000;
const kNoEvents: Event[] = [];

export interface Fleet {
  rows: { id: string; what: Known; news: Event[] }[]; // news: events that nobody has seen, newest first
  groups: Map<string, string[]>; // of each machine; empty where one may not know
  isWhole: boolean;
}

export async function loadFleet(): Promise<Fleet> {
  const list = (state: CalibrationState) =>
    all(2 * kMostMachines, async (pageToken) => {
      const page = await calibrations.listCalibrations({ state, pageSize: 1000, pageToken });
      return { rows: page.calibrations, nextPageToken: page.nextPageToken };
    });
  const [found, inUse, candidates, events, rights] = await Promise.all([
    all(kMostMachines, async (pageToken) => {
      const page = await machines.listMachines({ pageSize: 1000, pageToken });
      return { rows: page.machines.map((m) => m.machineId), nextPageToken: page.nextPageToken };
    }),
    list(CalibrationState.APPROVED),
    list(CalibrationState.CANDIDATE),
    listEvents("", true),
    isAdminOfAll()
      ? all(kMostMachines, async (pageToken) => {
          const page = await access.listMachineAccess({ pageSize: 1000, pageToken });
          return { rows: page.machines, nextPageToken: page.nextPageToken };
        })
      : undefined,
  ]);
  const news = new Map<string, Event[]>();
  for (const event of events.rows.filter(isNew)) news.set(event.machineId, [...(news.get(event.machineId) ?? []), event]);
  const groups = new Map<string, string[]>();
  for (const machine of rights?.rows ?? []) groups.set(machine.machineId, machine.groups);
  const of = new Map<string, Calibration[]>();
  for (const calibration of [...inUse.rows, ...candidates.rows]) {
    const list = of.get(calibration.machineId);
    if (list) list.push(calibration);
    else of.set(calibration.machineId, [calibration]);
  }
  return {
    rows: found.rows.map((id) => ({ id, what: known(of.get(id) ?? []), news: news.get(id) ?? kNoEvents })),
    groups,
    isWhole: found.isWhole && inUse.isWhole && candidates.isWhole && events.isWhole,
  };
}

// The findings of each machine, asked for one after the other.
function useFindings(ids: string[]): { of: Map<string, DriftFinding[]>; problem?: string } {
  const [state, setState] = useState<{ of: Map<string, DriftFinding[]>; problem?: string }>({ of: new Map() });
  const key = ids.join("\n");
  useEffect(() => {
    let isOver = false;
    const left = [...ids];
    const found = new Map<string, DriftFinding[]>();
    let shownAt = 0;
    const work = async () => {
      for (let id = left.shift(); id !== undefined && !isOver; id = left.shift()) {
        try {
          found.set(id, (await history.findDrift({ machineId: id, countsCandidates: true })).findings);
        } catch (error) {
          if (!isOver && isConnected.value) setState({ of: new Map(found), problem: problemOf(error).text });
          return;
        }
        // Not for each of a thousand machines.
        if (!isOver && (left.length === 0 || performance.now() - shownAt > 500)) {
          shownAt = performance.now();
          setState({ of: new Map(found) });
        }
      }
    };
    for (let i = 0; i < kAtATime; ++i) void work();
    return () => {
      isOver = true;
    };
  }, [key, epoch.value]);
  return state;
}

export interface Rated {
  id: string;
  what: Known;
  news: Event[];
  care: Care;
  told: number;
  findings?: DriftFinding[];
}

// Those that need care first; `left`: how many were not looked through yet.
export function useRated(fleet: Fleet): { rated: Rated[]; looked: number; left: number; problem?: string } {
  const withData = useMemo(
    () => fleet.rows.filter((row) => row.what.inUse || row.what.waiting.length > 0).map((row) => row.id),
    [fleet],
  );
  const found = useFindings(withData);
  const rated = useMemo(
    () =>
      fleet.rows
        .map((row) => {
          const findings = found.of.get(row.id);
          const care = careOf(row.what, findings, row.news);
          return { ...row, findings, care, told: row.news.length + open(findings ?? [], row.what.inUse).length };
        })
        .sort((a, b) => kCares.indexOf(a.care) - kCares.indexOf(b.care) || b.told - a.told || (a.id < b.id ? -1 : 1)),
    [fleet, found.of],
  );
  return { rated, looked: found.of.size, left: withData.length - found.of.size, problem: found.problem };
}

export function CareMark(props: { of: Rated }) {
  const { care, findings, what } = props.of;
  // Nothing is good before its history was looked through.
  if (care === "good" && what.inUse && !findings) return <span class="mark old">{t("careLooking")}</span>;
  return <span class={`mark ${kCareMark[care]}`}>{t(kCareText[care])}</span>;
}

const kCareText = { now: "careNow", decide: "careDecide", unknown: "careUnknown", good: "careGood" } as const;
const kCareMark = { now: "bad", decide: "wait", unknown: "old", good: "good" } as const;

export function Why(props: { what: Known; findings?: DriftFinding[]; news: Event[]; care: Care }) {
  const { what, care } = props;
  if (care === "now") {
    const finding: DriftFinding | undefined = open(props.findings ?? [], what.inUse)[0];
    const { text } = finding ?? props.news[0];
    return (
      <>
        <Server text={text} /> <ErrorWords text={text} />
        {!finding && <p>{t("whyNews")}</p>}
        {what.waiting.length > 0 && <p>{t(what.inUse ? "whyWaitsToo" : "whyFirst", { n: what.waiting.length })}</p>}
      </>
    );
  }
  if (care === "decide") return <>{t(what.inUse ? "whyWaits" : "whyFirst", { n: what.waiting.length })}</>;
  if (care === "unknown") return <>{t("whyNever")}</>;
  return <>{props.findings ? t("whyGood") : ""}</>;
}

// Machines of which a session has this label; none asked: undefined.
function useLabelled(label: string): { ids?: Set<string>; isWhole: boolean; problem?: Problem } {
  const found = useLoad(`label ${label}`, async () =>
    label === ""
      ? undefined
      : await all(kMostLabelled, async (pageToken) => {
          const page = await ingest.listSessions({ label, pageSize: 1000, pageToken });
          return { rows: page.sessions.map((s) => s.machineId), nextPageToken: page.nextPageToken };
        }),
  );
  if (label === "") return { isWhole: true };
  return { ids: new Set(found.data?.rows), isWhole: found.data?.isWhole ?? true, problem: found.problem };
}

// Made anew only when something of its machine is new, not at each key in the filter.
function FleetRow(props: { of: Rated }) {
  const { id, what, news, care, findings } = props.of;
  return useMemo(() => {
    const { inUse } = what;
    const fit = inUse?.statistics;
    return (
      <tr>
        <th scope="row">
          <a href={`#/machines/${encodeURIComponent(id)}`}>{id}</a>
        </th>
        <td>
          <CareMark of={props.of} />
        </td>
        <td class="text">
          <Why what={what} care={care} findings={findings} news={news} />
        </td>
        <td class="number" data-head={t("openEvents")}>
          <a href={`#/events/${encodeURIComponent(id)}`} aria-label={`${countText(news.length)}: ${t("eventsOf", { machine: id })}`}>
            {countText(news.length)}
          </a>
        </td>
        <td class="whole" data-head={t("inUse")}>
          {inUse ? (
            <>
              <a href={`#/calibrations/${inUse.calibrationId}`}>{t("versionN", { n: inUse.version })}</a>
              <br />
              <small>{inUse.provenance && dayText(inUse.provenance.measuredUtcUs)}</small>
            </>
          ) : (
            t("none")
          )}
        </td>
        <td class="number" data-head={t("residual")}>
          {fit?.rmsBeforeUm !== undefined && fit.rmsAfterUm !== undefined
            ? `${numberText(fit.rmsBeforeUm)} → ${numberText(fit.rmsAfterUm)} µm`
            : "–"}
        </td>
      </tr>
    );
  }, [id, what, news, care, findings, language.value]);
}

function FleetTable(props: { fleet: Fleet }) {
  const { fleet } = props;
  const [filter, setFilter] = useState("");
  const [group, setGroup] = useState("");
  const [label, setLabel] = useState("");
  const labelled = useLabelled(label);
  const [most, setMost] = useState(kShownAtOnce);
  const { rated, looked, left, problem } = useRated(fleet);
  const words = filter.toLowerCase();
  const fits = rated.filter(
    (row) => row.id.toLowerCase().includes(words) && (group === "" || (fleet.groups.get(row.id) ?? []).includes(group)) &&
      (labelled.ids === undefined || labelled.ids.has(row.id)),
  );
  const groups = useMemo(() => [...new Set([...fleet.groups.values()].flat())].sort(), [fleet]);
  return (
    <>
      <p class="lead">
        {t("fleetCounts", {
          n: rated.length,
          sick: rated.filter((row) => row.care === "now").length,
          wait: rated.filter((row) => row.what.waiting.length > 0).length,
        })}{" "}
        {looked + left > 0 && (left > 0 ? t("fleetLooked", { n: looked, all: looked + left }) : t("fleetAllLooked", { n: looked }))}
        {!fleet.isWhole && t("notAll", { n: rated.length })}
      </p>
      {problem && <ProblemBox problem={{ text: problem, reason: "", isConnection: false }} />}
      <div class="filters">
        <label>
          {t("filter")}
          <input type="search" value={filter} onInput={(event) => setFilter(event.currentTarget.value)} />
        </label>
        {groups.length > 0 && (
          <label>
            {t("group")}
            <select value={group} onChange={(event) => setGroup(event.currentTarget.value)}>
              <option value="">{t("allGroups")}</option>
              {groups.map((name) => (
                <option value={name}>{name}</option>
              ))}
            </select>
          </label>
        )}
        <form
          class="filters"
          onSubmit={(event) => {
            event.preventDefault();
            setLabel(fieldOf(new FormData(event.currentTarget), "label"));
          }}
        >
          <label>
            {t("labelFilter")}
            <input name="label" type="search" autocomplete="off" onInput={(event) => event.currentTarget.value === "" && setLabel("")} />
          </label>
          <button type="submit" class="quiet">
            {t("filterButton")}
          </button>
        </form>
      </div>
      {labelled.problem && <ProblemBox problem={labelled.problem} />}
      {!labelled.isWhole && <p>{t("notAll", { n: countText(kMostLabelled) })}</p>}
      {fits.length === 0 ? (
        <Empty text={t("fleetNothing")} />
      ) : (
        <Table cards label={t("fleet")} head={[t("machine"), t("care"), t("why"), t("openEvents"), t("inUse"), t("residual")]} numbers={[3, 5]}>
          {fits.slice(0, most).map((row) => (
            <FleetRow key={row.id} of={row} />
          ))}
        </Table>
      )}
      {fits.length > most && (
        <p class="buttons">
          {t("shownOf", { n: most, all: fits.length })}{" "}
          <button type="button" class="quiet" onClick={() => setMost(most + kShownAtOnce)}>
            {t("more")}
          </button>
        </p>
      )}
    </>
  );
}

export function FleetPage() {
  const fleet = useLoad("fleet", loadFleet, kEveryMs);
  return (
    <>
      <Title text={t("fleetTitle")} />
      <Show of={fleet} rows={8}>
        {(data) => (data.rows.length === 0 ? <Empty text={t("fleetEmpty")} first={t("fleetFirst")} /> : <FleetTable fleet={data} />)}
      </Show>
    </>
  );
}
