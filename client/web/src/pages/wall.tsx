// The fleet for a display on a wall: large, without anything to touch, turning its pages by itself.
import { useEffect, useMemo, useState } from "preact/hooks";
import { useLoad } from "../api";
import { Care } from "../gen/axiscal/v1/history_service_pb";
import { Empty, Show, Title } from "../parts";
import { countText, nowText } from "../format";
import { language, t } from "../text";
import { byNeed, CareMark, everyMs, kCareMarks, loadFleet, Why, type Fleet } from "./fleet";

const kTurnMs = 15_000;
const kRows = 10;

function Board(props: { fleet: Fleet }) {
  const { rows } = props.fleet;
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const timer = window.setInterval(() => setTurn((n) => n + 1), kTurnMs);
    return () => clearInterval(timer);
  }, []);
  // Those that need something turn by, in the order in which they stood when the page was turned; the others are in the counts.
  const order = useMemo(() => [...rows].sort(byNeed).map((row) => row.machineId), [turn]);
  const of = new Map(rows.map((row) => [row.machineId, row]));
  const wanted = order.flatMap((id) => of.get(id) ?? []).filter((row) => row.care !== Care.GOOD);
  const pages = Math.max(1, Math.ceil(wanted.length / kRows));
  const page = turn % pages;
  return (
    <>
      <ul class="wall-counts">
        {([Care.NOW, Care.DECIDE, Care.UNKNOWN, Care.GOOD] as const).map((care) => {
          const [kind, text] = kCareMarks[care]!;
          return (
            <li class={`wall-count ${kind}`}>
              <strong>{countText(rows.filter((row) => row.care === care).length)}</strong> {t(text)}
            </li>
          );
        })}
      </ul>
      {wanted.length > 0 && (
        <ul class="wall-list">
          {wanted.slice(page * kRows, page * kRows + kRows).map((row) => (
            <li key={row.machineId}>
              <strong>{row.machineId}</strong> <CareMark of={row} />{" "}
              <span>
                <Why of={row} events={props.fleet.events.get(row.machineId)} isWall />
              </span>
            </li>
          ))}
        </ul>
      )}
      <p class="muted">
        {countText(rows.length)} {t("wallMachines")}
        {pages > 1 && `; ${t("wallPage", { n: page + 1, all: pages })}`}
      </p>
    </>
  );
}

export function WallPage() {
  const fleet = useLoad(`wall ${language.value}`, async () => ({ fleet: await loadFleet(), at: nowText() }), (found) => everyMs(found?.fleet));
  return (
    <div class="wall">
      <Title text={t("fleetTitle")}>{fleet.data && <span class="muted">{t("wallAt", { time: fleet.data.at })}</span>}</Title>
      <Show of={fleet} rows={8}>
        {({ fleet }) => (fleet.rows.length === 0 ? <Empty text={t("fleetEmpty")} first={t("fleetFirst")} /> : <Board fleet={fleet} />)}
      </Show>
    </div>
  );
}
