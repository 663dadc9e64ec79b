// Every machine at a glance, those that need care first.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { all, history, ingest, useLoad, type Problem } from "../api";
import { countText, dayText, numberText } from "../format";
import { Care, type MachineCare } from "../gen/axiscal/v1/history_service_pb";
import { isNew, listEvents } from "../events";
import { eventSaid, standingSaid, type Said } from "../german";
import type { Event } from "../gen/axiscal/v1/events_service_pb";
import { Empty, ErrorWords, ProblemBox, Show, Table, Title, Worded, fieldOf } from "../parts";
import { language, t } from "../text";

const kMostMachines = 5000;
const kMostLabelled = 5000; // sessions with a label
const kShownAtOnce = 50;
// Rows that fill a screen. Others of those that are shown come one frame later, so that a key in the filter is answered at once.
const kFirstRows = 15;
const kEveryMs = 60_000;
// While the server looks through histories, as after one was changed.
const kSoonMs = 2000;

export interface Fleet {
  rows: MachineCare[];
  isWhole: boolean;
  events: Map<string, Event[]>; // of machines, newest first; where german.ts words them
}

export async function loadFleet(): Promise<Fleet> {
  const found = await all(kMostMachines, async (pageToken) => {
    const page = await history.listCare({ pageSize: 1000, pageToken });
    return { rows: page.machines, nextPageToken: page.nextPageToken };
  });
  // With the rows, so that no text changes under the reader's eyes.
  const asked = language.value === "de" && found.rows.some((row) => row.care === Care.NOW) ? (await listEvents("", true)).rows : [];
  const events = new Map<string, Event[]>();
  for (const event of asked) events.set(event.machineId, [...(events.get(event.machineId) ?? []), event]);
  return { ...found, events };
}
export const everyMs = (fleet?: Fleet) => (fleet?.rows.some((row) => !row.isFollowed) ? kSoonMs : kEveryMs);

const told = (row: MachineCare) => Number(row.newEvents) + row.findings.length;
// Those that need care first, those with most to tell before others.
export const byNeed = (a: MachineCare, b: MachineCare) => a.care - b.care || told(b) - told(a) || (a.machineId < b.machineId ? -1 : 1);

// The rows in an order that nothing changes under the reader's eyes: that of the first load, until he asks for it anew. What came since stands
// last. `isStale`: the order of now would be another one.
function useOrdered(fleet: Fleet): { rows: MachineCare[]; placed: Map<string, Care>; isStale: boolean; order: () => void } {
  const [asked, setAsked] = useState(0);
  const held = useRef<{ asked: number; placed: Map<string, Care> } | undefined>(undefined);
  return useMemo(() => {
    const now = [...fleet.rows].sort(byNeed);
    if (held.current?.asked !== asked) held.current = { asked, placed: new Map(now.map((row) => [row.machineId, row.care])) };
    const { placed } = held.current;
    const of = new Map(fleet.rows.map((row) => [row.machineId, row]));
    const rows = [
      ...[...placed.keys()].flatMap((id) => of.get(id) ?? []),
      ...now.filter((row) => !placed.has(row.machineId)),
    ];
    const isStale = now.some((row) => placed.get(row.machineId) !== row.care);
    return { rows, placed, isStale, order: () => setAsked(asked + 1) };
  }, [fleet, asked]);
}

export function CareMark(props: { of: MachineCare }) {
  const { care, inUse, isFollowed } = props.of;
  // Nothing is good before its history was looked through.
  if (care === Care.GOOD && inUse && !isFollowed) return <span class="mark old">{t("careLooking")}</span>;
  const [kind, text] = kCareMarks[care] ?? kCareMarks[Care.UNKNOWN]!;
  return <span class={`mark ${kind}`}>{t(text)}</span>;
}

export const kCareMarks: Partial<Record<Care, readonly ["bad" | "wait" | "old" | "good", "careNow" | "careDecide" | "careUnknown" | "careGood"]>> = {
  [Care.NOW]: ["bad", "careNow"],
  [Care.DECIDE]: ["wait", "careDecide"],
  [Care.UNKNOWN]: ["old", "careUnknown"],
  [Care.GOOD]: ["good", "careGood"],
};

// Events have the sizes of what is found, and what is new.
function saidOf(of: MachineCare, events: Event[]): Said | undefined {
  const [finding] = of.findings;
  if (finding === undefined) {
    const newest = events.find((event) => isNew(event) && event.text === of.newestEvent);
    return newest && eventSaid(newest);
  }
  const event = events.find((one) => one.text === finding.text);
  return (event && eventSaid(event)) ?? standingSaid(finding);
}

// What nobody has seen yet beside the finding: an error that is out of its tolerance is certain, a jump may not be.
function AlsoNew(props: { of: MachineCare; told: string; events: Event[] }) {
  const { newestEvent, newEvents } = props.of;
  const event = props.events.find((one) => one.text === newestEvent);
  const isOther = newestEvent !== "" && newestEvent !== props.told;
  // The newest is told above, or here.
  const rest = Number(newEvents) - 1;
  if (!isOther && rest < 1) return null;
  return (
    <p>
      {isOther && (
        <>
          {t("whyAlso")} <Worded said={event && eventSaid(event)} text={newestEvent} />{" "}
        </>
      )}
      {rest > 0 && t("whyMore", { n: countText(rest) })}
    </p>
  );
}

// `isWall`: nothing can be chosen there.
export function Why(props: { of: MachineCare; events?: Event[]; isWall?: boolean }) {
  const { care, findings, newestEvent, inUse, waiting, isFollowed } = props.of;
  const n = countText(waiting);
  if (care === Care.NOW) {
    const text = findings[0]?.text ?? newestEvent;
    return (
      <>
        <Worded said={saidOf(props.of, props.events ?? [])} text={text} isShort={props.isWall} /> <ErrorWords text={text} />
        {findings.length > 0 && !props.isWall && <AlsoNew of={props.of} told={text} events={props.events ?? []} />}
        {findings.length === 0 && <p>{t(props.isWall ? "whyNewsWall" : "whyNews")}</p>}
        {waiting > 0n && <p>{t(!inUse ? "whyFirst" : props.isWall ? "whyWaits" : "whyWaitsToo", { n })}</p>}
      </>
    );
  }
  if (care === Care.DECIDE) return <>{t(inUse ? "whyWaits" : "whyFirst", { n })}</>;
  if (care === Care.UNKNOWN) return <>{t("whyNever")}</>;
  return <>{isFollowed ? t("whyGood") : ""}</>;
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
  // All stay until it is known which have it.
  const ids = found.data || found.problem ? new Set(found.data?.rows) : undefined;
  return { ids, isWhole: found.data?.isWhole ?? true, problem: found.problem };
}

// Made anew only when something of its machine is new, not at each key in the filter. `isNews`: it needs something else now than by its place.
function FleetRow(props: { of: MachineCare; events?: Event[]; isNews: boolean }) {
  const { of, events: open, isNews } = props;
  return useMemo(() => {
    const { machineId, inUse, newEvents } = of;
    const events = countText(newEvents);
    return (
      <tr>
        <th scope="row">
          <a href={`#/machines/${encodeURIComponent(machineId)}`}>{machineId}</a>
        </th>
        <td>
          <CareMark of={of} />
        </td>
        <td class="text">{isNews ? t("whyMoved") : <Why of={of} events={open} />}</td>
        <td class="number" data-head={t("openEvents")}>
          <a href={`#/events/${encodeURIComponent(machineId)}`} aria-label={`${events}: ${t("eventsOf", { machine: machineId })}`}>
            {events}
          </a>
        </td>
        <td class="whole" data-head={t("inUse")}>
          {inUse ? (
            <>
              <a href={`#/calibrations/${inUse.calibrationId}`}>{t("calibrationN", { n: inUse.calibrationId })}</a>
              <br />
              <small>{dayText(inUse.measuredUtcUs)}</small>
            </>
          ) : (
            t("none")
          )}
        </td>
        <td class="number" data-head={t("residual")}>
          {inUse?.rmsBeforeUm !== undefined && inUse.rmsAfterUm !== undefined
            ? `${numberText(inUse.rmsBeforeUm)} → ${numberText(inUse.rmsAfterUm)} µm`
            : "–"}
        </td>
      </tr>
    );
  }, [of, open, isNews, language.value]);
}

// Of rows that are new to the reader as many as fill a screen at once, the others in the next frame.
function useFew(key: string, most: number): number {
  const [whole, setWhole] = useState("");
  useEffect(() => {
    const frame = requestAnimationFrame(() => setWhole(key));
    return () => cancelAnimationFrame(frame);
  }, [key]);
  return whole === key ? most : Math.min(most, kFirstRows);
}

function FleetTable(props: { fleet: Fleet }) {
  const { fleet } = props;
  const [filter, setFilter] = useState("");
  const [group, setGroup] = useState("");
  const [label, setLabel] = useState("");
  const labelled = useLabelled(label);
  const [most, setMost] = useState(kShownAtOnce);
  const { rows, placed, isStale, order } = useOrdered(fleet);
  const words = filter.toLowerCase();
  const fits = rows.filter(
    (row) => row.machineId.toLowerCase().includes(words) && (group === "" || row.groups.includes(group)) &&
      (labelled.ids === undefined || labelled.ids.has(row.machineId)),
  );
  const shown = fits.slice(0, useFew(JSON.stringify([words, group, label]), most));
  const groups = useMemo(() => [...new Set(fleet.rows.flatMap((row) => row.groups))].sort(), [fleet]);
  const calibrated = rows.filter((row) => row.inUse || row.waiting > 0n);
  const looked = calibrated.filter((row) => row.isFollowed).length;
  return (
    <>
      <p class="lead">
        {t("fleetCounts", {
          n: countText(rows.length),
          sick: countText(rows.filter((row) => row.care === Care.NOW).length),
          wait: countText(rows.filter((row) => row.waiting > 0n).length),
        })}{" "}
        {calibrated.length > 0 &&
          (looked < calibrated.length
            ? t("fleetLooked", { n: countText(looked), all: countText(calibrated.length) })
            : t("fleetAllLooked", { n: countText(looked) }))}
        {!fleet.isWhole && t("notAll", { n: countText(rows.length) })}
      </p>
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
        {/* Its place is kept: what comes while one reads moves nothing. */}
        <button type="button" class="quiet" disabled={!isStale} title={isStale ? undefined : t("orderIsNow")} onClick={order}>
          {t("fleetOrder")}
        </button>
      </div>
      {labelled.problem && <ProblemBox problem={labelled.problem} />}
      {!labelled.isWhole && <p>{t("notAll", { n: countText(kMostLabelled) })}</p>}
      {fits.length === 0 ? (
        <Empty text={t("fleetNothing")} />
      ) : (
        <Table
          cards
          kind="fleet"
          label={t("fleet")}
          head={[t("machine"), t("care"), t("why"), t("openEvents"), t("inUse"), t("residual")]}
          numbers={[3, 5]}
        >
          {shown.map((row) => (
            <FleetRow key={row.machineId} of={row} events={fleet.events.get(row.machineId)} isNews={placed.has(row.machineId) && placed.get(row.machineId) !== row.care} />
          ))}
        </Table>
      )}
      {fits.length > most && (
        <p class="buttons">
          {t("shownOf", { n: countText(most), all: countText(fits.length) })}{" "}
          <button type="button" class="quiet" onClick={() => setMost(most + kShownAtOnce)}>
            {t("more")}
          </button>
        </p>
      )}
    </>
  );
}

export function FleetPage() {
  const fleet = useLoad(`fleet ${language.value}`, loadFleet, everyMs);
  return (
    <>
      <Title text={t("fleetTitle")} />
      <Show of={fleet} rows={8}>
        {(data) => (data.rows.length === 0 ? <Empty text={t("fleetEmpty")} first={t("fleetFirst")} /> : <FleetTable fleet={data} />)}
      </Show>
    </>
  );
}
