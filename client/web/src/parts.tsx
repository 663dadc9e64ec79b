// What all pages are made of.
import type { ComponentChildren } from "preact";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { problemOf, Refusal, type Loaded, type Problem } from "./api";
import { CalibrationState } from "./gen/axiscal/v1/calibration_pb";
import type { CalibrationPicture } from "./gen/axiscal/v1/calibrations_service_pb";
import { countText, csv, numberText, proseText, save } from "./format";
import type { Said } from "./german";
import { errorsIn, isoWords } from "./iso";
import { refusalSaid } from "./refusals";
import { language, t } from "./text";

// The server writes English: on a German page that is a quotation, beside what the page says of it.
export function Server(props: { text: string }) {
  if (props.text === "") return null;
  const text = proseText(props.text);
  return language.value === "de" ? <q lang="en">{text}</q> : <span lang="en">{text}</span>;
}

// What the page says, and the server's own words behind it, both in sight.
export function Quoted(props: { said?: string; text: string }) {
  return (
    <>
      {props.said && <>{props.said} </>}
      <Server text={props.text} />
    </>
  );
}

// What the server says, in the reader's language where german.ts has it: with the server's own words folded behind it where they say more.
// `isShort`: nothing can be opened there.
export function Worded(props: { said?: Said; text: string; isShort?: boolean }) {
  const { said, text } = props;
  if (said === undefined) return <Server text={text} />;
  return (
    <>
      <span>{said.text}</span>
      {!said.isWhole && !props.isShort && (
        <details class="original">
          <summary>{t("originalWords")}</summary>
          <Server text={text} />
        </details>
      )}
    </>
  );
}

export function Title(props: { text: string; children?: ComponentChildren }) {
  useEffect(() => {
    document.title = `${props.text} · Axiscal`;
  }, [props.text]);
  return (
    <header class="title">
      <h1>{props.text}</h1>
      {props.children}
    </header>
  );
}

// What was refused, in the reader's language where the page knows the reason, and in the server's own words.
export function ProblemBox(props: { problem: Problem }) {
  const { problem } = props;
  const said = problem.isOwn ? undefined : refusalSaid(problem);
  return (
    <div class="box bad" role="alert">
      {said !== undefined && <p>{said}</p>}
      {problem.isOwn ? (
        problem.text
      ) : (
        <>
          <strong>{t("problem")}:</strong> <Server text={problem.text} />
        </>
      )}
      {problem.reason && <code class="reason">{problem.reason}</code>}
    </div>
  );
}

// What is loaded, or why not. `rows` keeps the place while it loads.
export function Show<Data>(props: { of: Loaded<Data>; rows?: number; children: (data: Data) => ComponentChildren }) {
  if (props.of.problem) return <ProblemBox problem={props.of.problem} />;
  if (props.of.data === undefined) {
    return (
      <div class={`waiting rows-${props.rows ?? 3}`} role="status">
        {t("loading")}
      </div>
    );
  }
  return <>{props.children(props.of.data)}</>;
}

// Tells once when a part of the page has its height: what stands below it is shown then, so that nothing moves while the page loads.
export function usePlaced(isPlaced: boolean, onPlaced?: () => void) {
  useEffect(() => {
    if (isPlaced) onPlaced?.();
  }, [isPlaced]);
}

export function Empty(props: { text: string; first?: string; children?: ComponentChildren }) {
  return (
    <div class="box empty">
      <p>{props.text}</p>
      {props.first && <p>{props.first}</p>}
      {props.children}
    </div>
  );
}

// As many columns as a phone has room for.
const kFewColumns = 2;
const kManyColumns = 8; // beside each other in 1200 px only where none is held wide

// Wide tables scroll in a box of their own, which the keyboard reaches. Of more columns than a phone has room for a row is a card there: each
// cell then says by `data-head` what it is. With `cards` the rows say that themselves.
export function Table(props: {
  label: string;
  head: ComponentChildren[];
  numbers?: number[];
  cards?: boolean;
  kind?: string; // a class of its own
  children: ComponentChildren;
}) {
  const table = useRef<HTMLTableElement>(null);
  const areNamed = !props.cards && props.head.length > kFewColumns;
  useLayoutEffect(() => {
    if (!areNamed || !table.current) return;
    const [head, ...rows] = table.current.rows;
    const names = [...(head?.cells ?? [])].map((cell) => cell.textContent ?? "");
    for (const row of rows) {
      let column = 0;
      for (const cell of row.cells) {
        if (cell.tagName === "TD") cell.dataset.head = names[column];
        column += cell.colSpan;
      }
    }
  });
  const layout = props.cards ? "cards" : areNamed ? "cards named" : "";
  const kind = props.kind ?? (props.head.length >= kManyColumns ? "dense" : "");
  return (
    <div class={`scroll ${layout} ${kind}`} role="region" aria-label={props.label} tabIndex={0}>
      <table ref={table}>
        <thead>
          <tr>
            {props.head.map((cell, i) => (
              <th scope="col" class={props.numbers?.includes(i) ? "number" : undefined}>
                {cell}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>{props.children}</tbody>
      </table>
    </div>
  );
}

// An error by its symbol, and what ISO 230-1 calls it.
export function ErrorName(props: { name: string }) {
  const words = isoWords(props.name);
  return (
    <>
      {props.name}
      {words && (
        <>
          {" "}
          <small class="muted">{words}</small>
        </>
      )}
    </>
  );
}

// What the errors are that a text of the server names by their symbols.
export function ErrorWords(props: { text: string }) {
  const words = errorsIn(props.text).map((name) => `${name}: ${isoWords(name)}`);
  return words.length === 0 ? null : <small class="error-words muted">{words.join("; ")}</small>;
}

const kStates: Partial<Record<CalibrationState, ["good" | "wait", "approved" | "candidate"]>> = {
  [CalibrationState.APPROVED]: ["good", "approved"],
  [CalibrationState.CANDIDATE]: ["wait", "candidate"],
};
export const stateText = (state: CalibrationState) => t(kStates[state]?.[1] ?? "retired");
export const StateMark = (props: { state: CalibrationState }) => <span class={`mark ${kStates[props.state]?.[0] ?? "old"}`}>{stateText(props.state)}</span>;

// A picture may be looked at larger: it then scrolls in its place, by keys as well.
const kZooms = [1, 2, 4];
function Zoomed(props: { label: string; children: ComponentChildren }) {
  const [zoom, setZoom] = useState(0);
  return (
    <>
      <div
        class={`zoom zoom-${kZooms[zoom]}`}
        {...(zoom > 0 ? { role: "region", "aria-label": `${t("pictureLarger")}: ${props.label}`, tabIndex: 0 } : {})}
      >
        {props.children}
      </div>
      <p class="zoom-buttons no-print">
        <button
          type="button"
          class="quiet"
          aria-label={`${t("zoomOut")}: ${props.label}`}
          title={t("zoomOut")}
          disabled={zoom === 0}
          onClick={() => setZoom(zoom - 1)}
        >
          −
        </button>
        <button
          type="button"
          class="quiet"
          aria-label={`${t("zoomIn")}: ${props.label}`}
          title={t("zoomIn")}
          disabled={zoom === kZooms.length - 1}
          onClick={() => setZoom(zoom + 1)}
        >
          +
        </button>
      </p>
    </>
  );
}

// A picture with its numbers: as a table beside it, and to save.
export function Figure(props: {
  name: string; // of its files
  caption: string;
  head: string[];
  rows: (string | number | undefined)[][];
  shown?: string[][]; // as people read them
  words?: number; // the column of words; all others but the first are numbers
  children: ComponentChildren;
}) {
  const kindOf = (i: number) => (i === props.words ? "text" : i > 0 ? "number" : undefined);
  const box = useRef<HTMLDivElement>(null);
  const saveSvg = () => {
    const svg = box.current?.querySelector("svg");
    if (svg) save(`${props.name}.svg`, "image/svg+xml", standalone(svg));
  };
  return (
    <figure>
      <figcaption>{props.caption}</figcaption>
      <Zoomed label={props.caption}>
        <div ref={box}>{props.children}</div>
      </Zoomed>
      <details class="numbers">
        <summary>{t("showTable")}</summary>
        <Table label={props.caption} head={props.head} numbers={props.head.map((_, i) => i).filter((i) => kindOf(i) === "number")}>
          {(props.shown ?? props.rows).map((row) => (
            <tr>
              {row.map((cell, i) => (
                <td class={kindOf(i)}>{cell ?? "–"}</td>
              ))}
            </tr>
          ))}
        </Table>
        <p class="buttons">
          <button type="button" class="quiet" onClick={saveSvg}>
            {t("saveSvg")}
          </button>
          <button
            type="button"
            class="quiet"
            onClick={() => save(`${props.name}.csv`, "text/csv", csv(props.head, props.rows))}
          >
            {t("saveCsv")}
          </button>
        </p>
      </details>
    </figure>
  );
}

// Rows that a table beside a picture has at most; a file has them all.
const kMostRows = 200;

// A picture of the server's own. It is loaded as a picture, so nothing in it runs. Its numbers come with it, or are asked for
// where there was no room for them.
export function ServerPicture(props: {
  name: string; // of its files
  caption: string;
  picture: CalibrationPicture;
  load: () => Promise<CalibrationPicture | undefined>;
}) {
  const { picture } = props;
  const [url, setUrl] = useState("");
  const [isOpen, setOpen] = useState(false);
  const [asked, setAsked] = useState<Loaded<CalibrationPicture>>({});
  useEffect(() => {
    const made = URL.createObjectURL(new Blob([picture.svg], { type: "image/svg+xml" }));
    setUrl(made);
    return () => URL.revokeObjectURL(made);
  }, [picture.svg]);
  const shown = picture.series.length > 0 ? picture : asked.data;
  const open = async (is: boolean) => {
    setOpen(is);
    if (!is || shown) return;
    try {
      setAsked({ data: await props.load() });
    } catch (error) {
      setAsked({ problem: problemOf(error) });
    }
  };
  return (
    <figure>
      <figcaption>{props.caption}</figcaption>
      <Zoomed label={props.caption}>{url && <img class="server-picture" src={url} alt={props.caption} />}</Zoomed>
      <p class="buttons no-print">
        <button type="button" class="quiet" onClick={() => save(`${props.name}.svg`, "image/svg+xml", picture.svg)}>
          {t("saveSvg")}
        </button>
      </p>
      <details class="numbers no-print" onToggle={(event) => void open(event.currentTarget.open)}>
        <summary>{t("showTable")}</summary>
        {isOpen && (
          <Show of={shown ? { data: shown } : asked}>{(one) => <Numbers name={props.name} caption={props.caption} picture={one} />}</Show>
        )}
      </details>
    </figure>
  );
}

function Numbers(props: { name: string; caption: string; picture: CalibrationPicture }) {
  const { series, xLabel, yLabel } = props.picture;
  const head = ["panel", "series", xLabel, yLabel];
  const rows = series.flatMap((one) => one.x.map((x, i) => [one.panel, one.name, x, one.y[i]] as [string, string, number, number]));
  if (rows.length === 0) return <p>{t("numbersTooMany")}</p>;
  return (
    <>
      {rows.length > kMostRows && <p>{t("shownOf", { n: kMostRows, all: countText(rows.length) })}</p>}
      <Table
        label={`${props.caption}: ${t("numbers")}`}
        head={[t("state"), t("sessions"), xLabel, yLabel]}
        numbers={[2, 3]}
      >
        {rows.slice(0, kMostRows).map((row) => (
          <tr>
            <td>{row[0]}</td>
            <td>{row[1]}</td>
            <td class="number">{numberText(row[2], 6)}</td>
            <td class="number">{numberText(row[3], 4)}</td>
          </tr>
        ))}
      </Table>
      <p class="buttons">
        <button type="button" class="quiet" onClick={() => save(`${props.name}.csv`, "text/csv", csv(head, rows))}>
          {t("saveCsv")}
        </button>
      </p>
    </>
  );
}

// A picture that shows alone as it does here: what the style sheet says of each shape goes into its attributes.
function standalone(svg: SVGSVGElement): string {
  const copy = svg.cloneNode(true) as SVGSVGElement;
  const from = [svg, ...svg.querySelectorAll("*")];
  const to = [copy, ...copy.querySelectorAll("*")];
  from.forEach((element, i) => {
    const style = getComputedStyle(element);
    for (const name of ["fill", "stroke", "stroke-width", "stroke-dasharray", "opacity", "font-size", "font-family", "text-anchor"])
      to[i].setAttribute(name, style.getPropertyValue(name));
    to[i].removeAttribute("class");
  });
  const box = svg.viewBox.baseVal;
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  copy.setAttribute("width", String(box.width));
  copy.setAttribute("height", String(box.height));
  const ground = document.createElementNS("http://www.w3.org/2000/svg", "rect");
  ground.setAttribute("width", "100%");
  ground.setAttribute("height", "100%");
  ground.setAttribute("fill", getComputedStyle(document.body).backgroundColor);
  copy.prepend(ground);
  return new XMLSerializer().serializeToString(copy);
}

// The browser's own field says in its own language that no file is chosen, also when one has gone up: it is there for the keyboard alone.
export function DropZone(props: { label: string; button: string; many?: boolean; disabled?: boolean; onFiles: (files: File[]) => void }) {
  const [isOver, setOver] = useState(false);
  return (
    <label
      class={`drop ${isOver ? "over" : ""}`}
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={(event) => {
        event.preventDefault();
        setOver(false);
        if (!props.disabled) props.onFiles([...(event.dataTransfer?.files ?? [])]);
      }}
    >
      <span>{props.label}</span>
      <span class={props.disabled ? "button off" : "button"} aria-hidden="true">
        {props.button}
      </span>
      <input
        class="unseen"
        type="file"
        multiple={props.many}
        disabled={props.disabled}
        onChange={(event) => {
          const input = event.currentTarget;
          props.onFiles([...(input.files ?? [])]);
          input.value = "";
        }}
      />
    </label>
  );
}

// A file in a form. Empty where none was chosen, also to FormData.
export function FileField(props: { name: string; label: string; required?: boolean; onFile?: (file: File | undefined) => void }) {
  const [chosen, setChosen] = useState("");
  return (
    <label class="file">
      {props.label}
      <span>
        <span class="button quiet" aria-hidden="true">
          {t("chooseFile")}
        </span>{" "}
        {chosen}
      </span>
      <input
        class="unseen"
        type="file"
        name={props.name}
        required={props.required}
        onChange={(event) => {
          const file = event.currentTarget.files?.[0];
          setChosen(file?.name ?? "");
          props.onFile?.(file);
        }}
      />
    </label>
  );
}

// A question with the keyboard's focus in it, closed by Escape.
export function Dialog(props: { title: string; onClose: () => void; children: ComponentChildren }) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    dialog.current?.showModal();
  }, []);
  return (
    <dialog ref={dialog} aria-labelledby="dialog-title" onClose={props.onClose}>
      <h2 id="dialog-title">{props.title}</h2>
      {props.children}
    </dialog>
  );
}

// A form in a dialog, which closes once `onSend` has done what it asks; what it throws stands above the buttons. `intro`: what stands above the
// form. `isPlain`: the browser itself refuses nothing, `onSend` says what is missing. `stays`: a short form below a
// long intro stays in sight.
export function FormDialog(props: {
  title: string;
  submit: string;
  intro: ComponentChildren;
  isPlain?: boolean;
  stays?: boolean;
  onSend: (form: FormData) => Promise<void>;
  onClose: () => void;
  children?: ComponentChildren;
}) {
  const [problem, setProblem] = useState<Problem>();
  const send = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = event.currentTarget as HTMLFormElement;
    try {
      await props.onSend(new FormData(form));
    } catch (error) {
      // What is missing is filled in at once.
      [...form.elements].find((one) => one instanceof HTMLInputElement && one.required && one.value.trim() === "" && (one.focus(), true));
      return setProblem(problemOf(error));
    }
    props.onClose();
  };
  return (
    <Dialog title={props.title} onClose={props.onClose}>
      {props.intro}
      <form class={props.stays ? "form stays" : "form"} onSubmit={send} noValidate={props.isPlain}>
        {props.children}
        <div role="status">{problem && <ProblemBox problem={problem} />}</div>
        <p class="buttons">
          <button type="submit">{props.submit}</button>
          <button type="button" class="quiet" onClick={props.onClose}>
            {t("cancel")}
          </button>
        </p>
      </form>
    </Dialog>
  );
}

// Of a form: a field's text without blanks around it.
export const fieldOf = (form: FormData, name: string) => String(form.get(name) ?? "").trim();

// The word of a person in the field `note`, of at most so many bytes: the server takes no longer one.
export function noteOf(form: FormData, isNeeded: boolean, mostBytes = 1000): string {
  const note = fieldOf(form, "note");
  if (isNeeded && note === "") throw new Refusal(t("wordNeeded"));
  if (new TextEncoder().encode(note).length > mostBytes) throw new Refusal(t("wordTooLong", { n: mostBytes }));
  return note;
}

// A button that asks once more, with what it will do, before it does it; with `note` for a word of the person.
export function Asking(props: { text: string; of: string; effect: string; note?: string; onSure: (note: string) => Promise<void> }) {
  const [isAsked, setAsked] = useState(false);
  return (
    <>
      <button type="button" class="quiet" aria-label={`${props.text}: ${props.of}`} onClick={() => setAsked(true)}>
        {props.text}
      </button>
      {isAsked && (
        <FormDialog
          title={`${props.text}: ${props.of}`}
          submit={props.text}
          intro={<p>{props.effect}</p>}
          isPlain
          onSend={(form) => props.onSure(noteOf(form, false, 250))}
          onClose={() => setAsked(false)}
        >
          {props.note !== undefined && (
            <label>
              {props.note}
              <input name="note" autocomplete="off" />
            </label>
          )}
        </FormDialog>
      )}
    </>
  );
}

export function Fact(props: { name: string; children: ComponentChildren }) {
  return (
    <div class="fact">
      <dt>{props.name}</dt>
      <dd>{props.children}</dd>
    </div>
  );
}
