// The fleet for a display on a wall: large, without anything to touch, turning its pages by itself.
import { useEffect, useState } from "preact/hooks";
import { useLoad } from "../api";
import { Empty, Show, Title } from "../parts";
import { countText, nowText } from "../format";
import { t } from "../text";
import { CareMark, loadFleet, useRated, Why, type Fleet } from "./fleet";

const kEveryMs = 60_000;
const kTurnMs = 15_000;
const kRows = 10;

function Board(props: { fleet: Fleet }) {
  const { rated } = useRated(props.fleet);
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const timer = window.setInterval(() => setTurn((n) => n + 1), kTurnMs);
    return () => clearInterval(timer);
  }, []);
  const count = (care: string) => rated.filter((row) => row.care === care).length;
  // Those that need something turn by; the others are in the counts.
  const wanted = rated.filter((row) => row.care !== "good");
  const pages = Math.max(1, Math.ceil(wanted.length / kRows));
  const page = turn % pages;
  return (
    <>
      <ul class="wall-counts">
        {(
          [
            ["bad", "careNow", count("now")],
            ["wait", "careDecide", count("decide")],
            ["old", "careUnknown", count("unknown")],
            ["good", "careGood", count("good")],
          ] as const
        ).map(([kind, text, n]) => (
          <li class={`wall-count ${kind}`}>
            <strong>{countText(n)}</strong> {t(text)}
          </li>
        ))}
      </ul>
      {wanted.length > 0 && (
        <ul class="wall-list">
          {wanted.slice(page * kRows, page * kRows + kRows).map((row) => (
            <li key={row.id}>
              <strong>{row.id}</strong> <CareMark of={row} />{" "}
              <span>
                <Why what={row.what} care={row.care} findings={row.findings} news={row.news} />
              </span>
            </li>
          ))}
        </ul>
      )}
      <p class="muted">
        {countText(rated.length)} {t("wallMachines")}
        {pages > 1 && `; ${t("wallPage", { n: page + 1, all: pages })}`}
      </p>
    </>
  );
}

export function WallPage() {
  const fleet = useLoad("wall", async () => ({ fleet: await loadFleet(), at: nowText() }), kEveryMs);
  return (
    <div class="wall">
      <Title text={t("fleetTitle")}>{fleet.data && <span class="muted">{t("wallAt", { time: fleet.data.at })}</span>}</Title>
      <Show of={fleet} rows={8}>
        {({ fleet }) => (fleet.rows.length === 0 ? <Empty text={t("fleetEmpty")} first={t("fleetFirst")} /> : <Board fleet={fleet} />)}
      </Show>
    </div>
  );
}
