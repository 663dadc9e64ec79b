// What a compensation did to a program: corrections along its path, lines that were left or refused, the program to take away.
import { useState } from "preact/hooks";
import { PathChart } from "../charts";
import { countText, numberText } from "../format";
import { germanOf, noteSaid, todoSaid } from "../german";
import { ErrorWords, Figure, Quoted, Server, Table, Worded } from "../parts";
import type { Cause, CompensationReport, PathStretch, Warning } from "../reports";
import { t, tMaybe } from "../text";

function linesText(first: number, last: number): string {
  return first === last ? String(first) : `${first} – ${last}`;
}

// Corrections and errors by stretches of the path, each from its least to its greatest.
function AlongPath(props: { path: PathStretch[] }) {
  const { path } = props;
  const [chosen, setChosen] = useState<number>();
  const axes = Object.keys(path[0].correction);
  const caption = t("alongPath", { n: countText(path.length) });
  const errors = t("errorsAlongPath", { n: countText(path.length) });
  const way = path.map((one) => one.way_mm);
  const at = chosen === undefined ? undefined : path[chosen];
  const range = (low: number, high: number) => (low === high ? numberText(low, 4) : `${numberText(low, 4)} … ${numberText(high, 4)}`);
  const head = [t("lines"), t("wayMm"), ...axes.flatMap((axis) => [`${axis} − (µm)`, `${axis} + (µm)`]), t("errorBeforeUm"), t("errorAfterUm")];
  const rows = path.map((one) => [
    linesText(one.first, one.last),
    one.way_mm,
    ...axes.flatMap((axis) => [one.correction[axis].low_um, one.correction[axis].high_um]),
    one.before_max_um,
    one.after_max_um,
  ]);
  const shown = rows.map((row) => row.map((cell) => (typeof cell === "number" ? numberText(cell, 6) : cell)));
  return (
    <section>
      <h3>{t("alongPathTitle")}</h3>
      <p>{t("alongPathHelp")}</p>
      <Figure name="corrections" caption={caption} head={head} rows={rows} shown={shown}>
        <PathChart
          title={`${caption}. ${t("chooseByKeys")}`}
          xLabel={t("wayMm")}
          way={way}
          series={axes.map((axis) => ({
            name: axis,
            low: path.map((one) => one.correction[axis].low_um),
            high: path.map((one) => one.correction[axis].high_um),
          }))}
          chosen={chosen}
          onChoose={setChosen}
        />
      </Figure>
      <p role="status" class="box">
        {at === undefined
          ? t("choosePlace")
          : `${t("lines")} ${linesText(at.first, at.last)}, ${numberText(at.way_mm, 6)} mm: ${axes
              .map((axis) => `${axis} ${range(at.correction[axis].low_um, at.correction[axis].high_um)} µm`)
              .join(", ")}; ${t("toolErrorBefore")} ${numberText(at.before_max_um, 4)} µm, ${t("toolErrorAfter")} ${numberText(at.after_max_um, 4)} µm`}
      </p>
      <Figure name="tool-point-errors" caption={errors} head={head} rows={rows} shown={shown}>
        <PathChart
          title={`${errors}. ${t("chooseByKeys")}`}
          xLabel={t("wayMm")}
          way={way}
          series={[
            { name: t("before"), low: path.map((one) => one.before_max_um), high: path.map((one) => one.before_max_um) },
            { name: t("after"), low: path.map((one) => one.after_max_um), high: path.map((one) => one.after_max_um) },
          ]}
          chosen={chosen}
          onChoose={setChosen}
        />
      </Figure>
    </section>
  );
}

// Blocks with their reasons, the first of `all`.
function Blocks(props: { title: string; help: string; list: { line: number; block: string; reason: string }[]; all: number }) {
  if (props.all === 0) return null;
  return (
    <section>
      <h3>{props.title}</h3>
      <p>{props.help}</p>
      <Table label={props.title} head={[t("line"), t("block"), t("why")]}>
        {props.list.map((one) => (
          <tr>
            <th scope="row">{one.line}</th>
            <td class="text">
              <code>{one.block}</code>
            </td>
            <td class="text">
              <Server text={one.reason} />
            </td>
          </tr>
        ))}
      </Table>
      {props.all > props.list.length && <p>{t("shownOf", { n: countText(props.list.length), all: countText(props.all) })}</p>}
    </section>
  );
}

// What the engine asks for in the words of the command line: by its name in the form, where the form asks for it.
function Missing(props: { option: string }) {
  const [name, ...value] = props.option.split(" ");
  if (name === "--unit") {
    return (
      <>
        {t("programUnit")} ({t("missingInForm")}): <code lang="en">{value.join(" ")}</code>
      </>
    );
  }
  const what = tMaybe(`option_${name}`);
  return (
    <>
      {what === undefined ? t("missingOnline") : `${what} (${t("missingOnline")})`}: <code lang="en">{props.option}</code>
    </>
  );
}

// What the calibration's own report says against it: where one chooses it, and of what was corrected with it.
export function Doubts(props: { warnings?: Warning[]; causes?: Cause[] }) {
  const { warnings = [], causes = [] } = props;
  if (warnings.length === 0 && causes.length === 0) return null;
  return (
    <section class="box bad doubts">
      <h3>{t("doubtsTitle")}</h3>
      <ul class="findings">
        {warnings.map((one) => (
          <li>
            <Worded said={germanOf(one.text_de)} text={one.text} /> <ErrorWords text={one.text} />
          </li>
        ))}
        {causes.map((one) => (
          <li>
            {t("noMachineError")}: <Worded said={germanOf(one.subject_de)} text={one.subject} />
            <br />
            {germanOf(one.correction_de) ? (
              <Worded said={germanOf(one.correction_de)} text={one.correction} />
            ) : (
              <Quoted said={todoSaid(one.kind) ?? `${t("todo")}:`} text={one.correction} />
            )}
          </li>
        ))}
      </ul>
    </section>
  );
}

// Moves that nobody programmed.
function WaysBack(props: { report: CompensationReport }) {
  const list = props.report.ways_back ?? [], all = props.report.blocks.going_back ?? list.length;
  if (list.length === 0) return null;
  return (
    <section>
      <h3>{t("waysBack")}</h3>
      <p>{t("waysBackHelp")}</p>
      <Table label={t("waysBack")} head={[t("beforeLine"), t("block"), t("wayUm")]} numbers={[2]}>
        {list.map((one) => (
          <tr>
            <th scope="row">{one.line}</th>
            <td class="text">
              <code>{one.block}</code>
            </td>
            <td class="number">{numberText(one.way_um, 4)}</td>
          </tr>
        ))}
      </Table>
      {all > list.length && <p>{t("shownOf", { n: countText(list.length), all: countText(all) })}</p>}
    </section>
  );
}

export function Outcome(props: { report: CompensationReport; programId?: bigint }) {
  const { report } = props;
  const left = report.not_corrected ?? [];
  const path = report.path ?? [];
  // Codes, dwells, tool changes.
  const moveless = report.blocks.read - report.blocks.corrected - report.blocks.passed - report.blocks.refused;
  return (
    <section>
      <h2>{t("outcome")}</h2>
      {props.programId !== undefined && (
        <p class="buttons">
          <a class="button" href={`v1/programs/${props.programId}`} download>
            {t("downloadCorrected")}
          </a>
        </p>
      )}
      {report.null_correction && <p class="box bad">{t("nullCorrection")}</p>}
      <Doubts warnings={report.calibration_warnings} causes={report.calibration_causes} />
      <p class="lead">
        {t("blocks", report.blocks)}
        {moveless > 0 && !report.null_correction && `; ${t("blocksMoveless", { n: countText(moveless) })}`}
      </p>
      <Table label={t("outcome")} head={[t("what"), t("maxUm"), t("rmsUm")]} numbers={[1, 2]}>
        {Object.entries(report.correction ?? {}).map(([axis, peak]) => (
          <tr>
            <th scope="row">{t("correctionOf", { axis })}</th>
            <td class="number">{numberText(peak.max_um, 4)}</td>
            <td class="number">{numberText(peak.rms_um, 4)}</td>
          </tr>
        ))}
        {report.tool_point_error &&
          (["before", "after"] as const).map((when) => (
            <tr>
              <th scope="row">{t(when === "before" ? "toolErrorBefore" : "toolErrorAfter")}</th>
              <td class="number">{numberText(report.tool_point_error![when].max_um, 4)}</td>
              <td class="number">{numberText(report.tool_point_error![when].rms_um, 4)}</td>
            </tr>
          ))}
      </Table>
      <Blocks title={t("refusedLines")} help={t("refusedHelp")} list={report.refused ?? []} all={report.blocks.refused} />
      <WaysBack report={report} />
      {path.length > 0 && <AlongPath path={path} />}
      <h3>{t("leftLines")}</h3>
      {left.length === 0 ? (
        <p>{t("none")}</p>
      ) : (
        <>
          <p>{t("leftHelp")}</p>
          <Table label={t("leftLines")} head={[t("lines"), t("why")]}>
            {left.map((range) => (
              <tr>
                <th scope="row">{linesText(range.first, range.last)}</th>
                <td class="text">
                  <Server text={range.reason} />
                  {/* A range has the reason of its first block. */}
                  {(report.passed ?? [])
                    .filter((one) => one.line > range.first && one.line <= range.last && one.reason !== range.reason)
                    .map((one) => (
                      <>
                        <br />
                        {t("line")} {one.line}: <Server text={one.reason} />
                      </>
                    ))}
                </td>
              </tr>
            ))}
          </Table>
          {report.ranges_not_corrected > left.length && (
            <p>{t("shownOf", { n: countText(left.length), all: countText(report.ranges_not_corrected) })}</p>
          )}
        </>
      )}
      {report.missing && report.missing.length > 0 && (
        <section>
          <h3>{t("missingOptions")}</h3>
          <ul class="findings">
            {report.missing.map((option) => (
              <li>
                <Missing option={option} />
              </li>
            ))}
          </ul>
        </section>
      )}
      {report.shifts && report.shifts.length > 1 && (
        <section>
          <h3>{t("shifts")}</h3>
          <Table label={t("shifts")} head={[t("tool"), t("workOffset"), t("moves"), t("maxUm"), t("rmsUm"), t("line")]} numbers={[2, 3, 4, 5]}>
            {report.shifts.map((shift) => (
              <tr>
                <th scope="row">{shift.tool || "–"}</th>
                <td>{shift.work_offset || "–"}</td>
                <td class="number">{countText(shift.moves)}</td>
                <td class="number">{numberText(shift.max_um, 4)}</td>
                <td class="number">{numberText(shift.rms_um, 4)}</td>
                <td class="number">{shift.line}</td>
              </tr>
            ))}
          </Table>
        </section>
      )}
      {report.notes.length > 0 && (
        <>
          <h3>{t("notes")}</h3>
          <ul class="findings">
            {report.notes.map((note, i) => (
              <li>
                <Worded said={noteSaid(report.note_kinds?.[i], note)} text={note} />
              </li>
            ))}
          </ul>
        </>
      )}
    </section>
  );
}
