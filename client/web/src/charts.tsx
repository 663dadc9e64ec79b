// Pictures that are drawn here: plain SVG, styled by app.css. Every number in them comes from the API.
import { dateOf, dayText, numberText } from "./format";
import { language } from "./text";

export interface TimePoint {
  us: bigint;
  value: number;
  low: number; // of the 95 % interval; of a point that stands for many: of their values
  high: number;
  wasApproved: boolean;
  label: string;
  href: string;
}
export interface Band {
  fromUs: bigint;
  toUs: bigint;
  label: string;
}
// What people said has happened.
export interface PersonMark {
  us: bigint;
  label: string;
}
// What people should hear of, at the calibration that shows it.
export interface EventMark {
  us: bigint;
  label: string;
  href: string;
}
// What is foretold at a time: the median, and where it lies with 90 %.
export interface Foretold {
  us: bigint;
  value: number;
  low: number;
  high: number;
}

// Half of what "Sept. 2026" and "30 Sept, 14:05" are wide, in units of the picture.
const kHalfLabel = 34, kHalfLabelOfHours = 48;
const kMostTimes = 7;
// First days of months, where the reader is: each month, or each second, third ... as many as there is room for; `areYears`: Januaries.
export function calendarTicks(from: Date, to: Date): { months: Date[]; areYears: boolean } {
  const first = 12 * from.getFullYear() + from.getMonth();
  const last = 12 * to.getFullYear() + to.getMonth();
  const step = [1, 2, 3, 6, 12, 24, 60, 120].find((one) => (last - first) / one < kMostTimes) ?? 240;
  const months: Date[] = [];
  for (let month = Math.ceil(first / step) * step; month <= last; month += step) months.push(new Date(Math.floor(month / 12), month % 12, 1));
  return { months: months.filter((month) => month >= from), areYears: step >= 12 };
}

// Ticks at 1, 2 or 5 times a power of ten.
function ticks(low: number, high: number, most: number): number[] {
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough) ?? rough;
  const found: number[] = [];
  for (let i = Math.ceil(low / step); i * step <= high + step * 1e-9; ++i) found.push(i * step || 0); // no -0
  return found;
}

const kWidth = 720;
const kLeft = 64;
const kRight = 12;

// "12.5,30 14,31 ..." of a polygon or a line.
const pathOf = (points: [number, number][]) => points.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(" ");

// One error over time: marks with intervals, bands of jumps, diamonds of events, triangles where a calibration was put in use, limits; what
// people say has happened; what is foretold.
export function TimeLine(props: {
  title: string;
  points: TimePoint[];
  bands: Band[];
  approvals: bigint[];
  marks: PersonMark[];
  events: EventMark[];
  foretold: Foretold[];
  fromUs: bigint;
  toUs: bigint;
  limits?: [number, number];
}) {
  const height = 232, top = 10, bottom = 58;
  const from = Number(props.fromUs), span = Math.max(1, Number(props.toUs - props.fromUs));
  const x = (us: bigint) => kLeft + ((Number(us) - from) / span) * (kWidth - kLeft - kRight);
  const foretold = props.foretold.filter((f) => f.us >= props.fromUs && f.us <= props.toUs);
  let low = Math.min(0, ...props.points.map((p) => p.low), ...foretold.map((f) => f.low), ...(props.limits ?? []));
  let high = Math.max(0, ...props.points.map((p) => p.high), ...foretold.map((f) => f.high), ...(props.limits ?? []));
  const room = (high - low || 1) * 0.06;
  low -= room;
  high += room;
  const y = (value: number) => top + ((high - value) / (high - low)) * (height - top - bottom);
  const kDayUs = 86400e6;
  const days = span < 90 * kDayUs, hours = span < 4 * kDayUs;
  const { months, areYears } = calendarTicks(dateOf(props.fromUs), dateOf(props.toUs));
  const formatOf = (options: Intl.DateTimeFormatOptions) => new Intl.DateTimeFormat(language.value === "de" ? "de-DE" : "en-GB", options);
  const daily = formatOf(hours ? { day: "numeric", month: "short", hour: "2-digit", minute: "2-digit" } : { day: "numeric", month: "short" });
  const yearly = formatOf({ year: "numeric" }), monthly = formatOf({ month: "short" }), first = formatOf({ month: "short", year: "numeric" });
  // The year stands with the first month and with each January: "May 26" could be a day.
  const tickText = (us: bigint, i: number) => (days ? daily : areYears ? yearly : i === 0 || dateOf(us).getMonth() === 0 ? first : monthly).format(dateOf(us));
  const half = hours ? kHalfLabelOfHours : kHalfLabel;
  const marks = days
    ? [0, 1, 2, 3, 4, 5].map((i) => props.fromUs + BigInt(Math.round((span * i) / 5)))
    : months.map((month) => BigInt(month.getTime()) * 1000n);
  // At the edges a label stands inside.
  const side = (us: bigint) => (x(us) < kLeft + half ? "" : x(us) > kWidth - kRight - half ? "end" : "middle");
  return (
    <svg class="chart" viewBox={`0 0 ${kWidth} ${height}`} role="group" aria-label={props.title}>
      {props.bands.map((band) => (
        <rect class="band" x={x(band.fromUs)} y={top} width={Math.max(3, x(band.toUs) - x(band.fromUs))} height={height - top - bottom}>
          <title>{band.label}</title>
        </rect>
      ))}
      {ticks(low, high, 5).map((value) => (
        <g>
          <line class={value === 0 ? "axis" : "grid"} x1={kLeft} x2={kWidth - kRight} y1={y(value)} y2={y(value)} />
          <text class="tick end" x={kLeft - 6} y={y(value) + 4}>
            {numberText(value, 4)}
          </text>
        </g>
      ))}
      {foretold.length > 1 && (
        <>
          <polygon
            class="foretold"
            points={pathOf([
              ...foretold.map((f): [number, number] => [x(f.us), y(f.high)]),
              ...[...foretold].reverse().map((f): [number, number] => [x(f.us), y(f.low)]),
            ])}
          />
          <polyline class="foretold-middle" points={pathOf(foretold.map((f): [number, number] => [x(f.us), y(f.value)]))} />
        </>
      )}
      {props.marks
        .filter((mark) => mark.us >= props.fromUs && mark.us <= props.toUs)
        .map((mark) => (
          <g>
            <line class="person-mark" x1={x(mark.us)} x2={x(mark.us)} y1={top} y2={height - bottom} />
            <path class="person-flag" d={`M${x(mark.us)} ${top}h10l-3 4l3 4h-10z`}>
              <title>{mark.label}</title>
            </path>
          </g>
        ))}
      {props.limits?.map((value) => <line class="limit" x1={kLeft} x2={kWidth - kRight} y1={y(value)} y2={y(value)} />)}
      {marks.map((us, i) => (
        <>
          <line class="axis time-tick" x1={x(us)} x2={x(us)} y1={height - 28} y2={height - 24} />
          <text class={`tick ${side(us)}`} x={x(us)} y={height - 6}>
            {tickText(us, i)}
          </text>
        </>
      ))}
      {props.approvals
        .filter((us) => us >= props.fromUs && us <= props.toUs)
        .map((us) => (
          <path class="approval" d={`M${x(us)} ${height - bottom + 2}l-5 9h10z`}>
            <title>{dayText(us)}</title>
          </path>
        ))}
      {props.events
        .filter((event) => event.us >= props.fromUs && event.us <= props.toUs)
        .map((event) => (
          <a href={event.href} aria-label={event.label}>
            <path class="event-mark" d={`M${x(event.us)} ${height - bottom + 14}l6 7l-6 7l-6 -7z`}>
              <title>{event.label}</title>
            </path>
          </a>
        ))}
      {props.points.map((point) => (
        <a href={point.href} aria-label={point.label}>
          <title>{point.label}</title>
          <line class="interval" x1={x(point.us)} x2={x(point.us)} y1={y(point.low)} y2={y(point.high)} />
          <circle class={point.wasApproved ? "point" : "point hollow"} cx={x(point.us)} cy={y(point.value)} r="5" />
        </a>
      ))}
    </svg>
  );
}

export interface Interval {
  name: string;
  value: number;
  low: number;
  high: number;
  label: string;
}

// Values with intervals side by side, of one unit, about zero.
export function Intervals(props: { title: string; rows: Interval[] }) {
  const row = 26, height = props.rows.length * row + 30, left = 190;
  let low = Math.min(0, ...props.rows.map((r) => r.low)), high = Math.max(0, ...props.rows.map((r) => r.high));
  const room = (high - low || 1) * 0.04;
  low -= room;
  high += room;
  const x = (value: number) => left + ((value - low) / (high - low)) * (kWidth - left - kRight);
  return (
    <svg class="chart" viewBox={`0 0 ${kWidth} ${height}`} role="img" aria-label={props.title}>
      {ticks(low, high, 6).map((value) => (
        <g>
          <line class={value === 0 ? "axis" : "grid"} x1={x(value)} x2={x(value)} y1={4} y2={height - 24} />
          <text class="tick middle" x={x(value)} y={height - 8}>
            {numberText(value, 4)}
          </text>
        </g>
      ))}
      {props.rows.map((r, i) => {
        const y = 4 + i * row + row / 2;
        return (
          <g>
            <title>{r.label}</title>
            <text class="name end" x={left - 10} y={y + 4}>
              {r.name.length > 20 ? r.name.slice(0, 19) + "…" : r.name}
            </text>
            <line class="interval" x1={x(r.low)} x2={x(r.high)} y1={y} y2={y} />
            <circle class="point" cx={x(r.value)} cy={y} r="5" />
          </g>
        );
      })}
    </svg>
  );
}

export interface Bar {
  name: string;
  value: number;
  kind?: string;
}

// Positive values as bars; from the power of ten below the least on, as they go over several of them.
export function LogBars(props: { title: string; bars: Bar[] }) {
  const row = 28, left = 250, right = 70, height = props.bars.length * row + 6;
  const values = props.bars.map((bar) => bar.value).filter((value) => value > 0);
  const low = Math.floor(Math.log10(Math.min(...values)) - 0.05);
  const high = Math.max(low + 0.5, Math.log10(Math.max(...values)));
  const width = (value: number) =>
    value > 0 ? Math.max(2, ((Math.log10(value) - low) / (high - low)) * (kWidth - left - right)) : 0;
  return (
    <svg class="chart" viewBox={`0 0 ${kWidth} ${height}`} role="img" aria-label={props.title}>
      {props.bars.map((bar, i) => (
        <g>
          <text class="name end" x={left - 10} y={i * row + 19}>
            {bar.name.length > 26 ? bar.name.slice(0, 25) + "…" : bar.name}
          </text>
          <rect class={`bar ${bar.kind ?? ""}`} x={left} y={i * row + 5} width={width(bar.value)} height={row - 8} rx="2" />
          <text class="tick" x={left + width(bar.value) + 6} y={i * row + 19}>
            {numberText(bar.value, 4)}
          </text>
        </g>
      ))}
    </svg>
  );
}

export interface PathSeries {
  name: string; // "X"
  low: number[];
  high: number[];
}

// Values along a way, each stretch from its least to its greatest, so that no peak is lost; of up to six series. A click or the
// arrow keys choose a stretch.
export function PathChart(props: {
  title: string;
  xLabel: string;
  way: number[]; // to the end of each stretch, not falling
  series: PathSeries[];
  chosen?: number;
  onChoose: (stretch: number) => void;
}) {
  const height = 260, top = 10, bottom = 48, right = 84;
  const { way, series } = props;
  const last = Math.max(way[way.length - 1] ?? 0, 1e-9);
  // Where nothing goes along a linear axis there is only the order.
  const isByOrder = way.length > 1 && last - way[0] < 1e-6;
  const place = (i: number) => (isByOrder ? i / Math.max(1, way.length - 1) : way[i] / last);
  const x = (i: number) => kLeft + place(i) * (kWidth - kLeft - right);
  let low = Math.min(0, ...series.flatMap((s) => s.low)), high = Math.max(0, ...series.flatMap((s) => s.high));
  const room = (high - low || 1) * 0.06;
  low -= room;
  high += room;
  const y = (value: number) => top + ((high - value) / (high - low)) * (height - top - bottom);
  const nearest = (event: MouseEvent & { currentTarget: SVGSVGElement }) => {
    const box = event.currentTarget.getBoundingClientRect();
    const at = ((event.clientX - box.left) / box.width) * kWidth;
    let best = 0;
    for (let i = 1; i < way.length; ++i) if (Math.abs(x(i) - at) < Math.abs(x(best) - at)) best = i;
    props.onChoose(best);
  };
  const step = (event: KeyboardEvent) => {
    const by = { ArrowRight: 1, ArrowLeft: -1, PageDown: 20, PageUp: -20 }[event.key];
    const to =
      event.key === "Home" ? 0 : event.key === "End" ? way.length - 1 : by === undefined ? undefined : (props.chosen ?? (by > 0 ? -1 : way.length)) + by;
    if (to === undefined) return;
    event.preventDefault();
    props.onChoose(Math.max(0, Math.min(way.length - 1, to)));
  };
  return (
    <svg
      class="chart path-chart"
      viewBox={`0 0 ${kWidth} ${height}`}
      role="slider"
      aria-label={props.title}
      aria-valuemin={1}
      aria-valuemax={way.length}
      aria-valuenow={(props.chosen ?? 0) + 1}
      tabindex={0}
      onClick={nearest}
      onKeyDown={step}
    >
      {ticks(low, high, 5).map((value) => (
        <g>
          <line class={value === 0 ? "axis" : "grid"} x1={kLeft} x2={kWidth - right} y1={y(value)} y2={y(value)} />
          <text class="tick end" x={kLeft - 6} y={y(value) + 4}>
            {numberText(value, 4)}
          </text>
        </g>
      ))}
      {!isByOrder &&
        ticks(0, last, 6).map((value) => (
          <text class="tick middle" x={kLeft + (value / last) * (kWidth - kLeft - right)} y={height - 26}>
            {numberText(value, 5)}
          </text>
        ))}
      <text class="tick middle" x={(kLeft + kWidth - right) / 2} y={height - 6}>
        {props.xLabel}
      </text>
      {series.map((s, k) => (
        <g class={`path-${k % 6}`}>
          <polygon
            class="path-band"
            points={pathOf([
              ...s.high.map((value, i): [number, number] => [x(i), y(value)]),
              ...s.low.map((value, i): [number, number] => [x(i), y(value)]).reverse(),
            ])}
          />
          <polyline class="path-line" points={pathOf(s.high.map((value, i): [number, number] => [x(i), y(value)]))} />
          <polyline class="path-line" points={pathOf(s.low.map((value, i): [number, number] => [x(i), y(value)]))} />
          {/* The names stand at the right end, each a line apart. */}
          <rect class="path-key" x={kWidth - right + 8} y={top + 3 + k * 18} width="12" height="8" />
          <text class="tick" x={kWidth - right + 24} y={top + 12 + k * 18}>
            {s.name}
          </text>
        </g>
      ))}
      {props.chosen !== undefined && <line class="path-chosen" x1={x(props.chosen)} x2={x(props.chosen)} y1={top} y2={height - bottom} />}
    </svg>
  );
}
