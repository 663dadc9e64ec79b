// How the loop found a calibration: what it added and what that bought, what else it might be, what to measure next.
import { jsonOf, useLoad } from "../api";
import { LogBars } from "../charts";
import { countText, numberText, percentText, probabilityText, sigmaText, unitText, valueText } from "../format";
import { germanOf, proposalSaid, todoSaid } from "../german";
import { Empty, ErrorName, Figure, Quoted, Server, Show, Table, Title, Worded } from "../parts";
import { besideText, nameOf, type BoxError, type LoopReport } from "../reports";
import { calibrations } from "../services";
import { t, tMaybe } from "../text";
import { Pictures, Warnings } from "./calibration";

function Ladder(props: { report: LoopReport }) {
  const { fit, steps, sessions } = props.report;
  const readings = sessions?.reduce((sum, s) => sum + s.readings, 0);
  const rows = [
    { name: t("ladderStart"), change: "", rms: fit.before.rms_um ?? 0 },
    ...steps.map((step) => ({ name: step.name, change: step.change, rms: step.rms_um })),
  ];
  const caption = t("ladderPicture", { n: readings === undefined ? "–" : countText(readings) });
  const words = (change: string) => (change === "" ? "" : (tMaybe(`change_${change}`) ?? change));
  // What a step took from the residual, as share of what was there before it.
  const bought = (i: number) => (i === 0 || rows[i - 1].rms <= 0 ? "" : percentText((rows[i - 1].rms - rows[i].rms) / rows[i - 1].rms));
  const shown: (string | number)[][] = rows.map((r, i) => [r.name, words(r.change), numberText(r.rms, 4), bought(i)]);
  return (
    <section>
      <h2>{t("ladder")}</h2>
      <Table label={t("ladder")} head={[t("step"), t("what"), t("rmsUm"), t("bought")]} numbers={[2, 3]}>
        {shown.map((row) => (
          <tr>
            <th scope="row">{row[0]}</th>
            <td>{row[1]}</td>
            <td class="number">{row[2]}</td>
            <td class="number">{row[3]}</td>
          </tr>
        ))}
      </Table>
      <p class="muted">{t("logScale")}</p>
      <Figure
        name="ladder"
        caption={caption}
        head={[t("step"), t("what"), t("rmsUm"), t("bought")]}
        rows={rows.map((r, i) => [r.name, r.change, r.rms, bought(i)])}
        shown={shown.map((row) => row.map(String))}
      >
        <LogBars
          title={caption}
          bars={rows.map((r) => ({ name: r.name, value: r.rms, kind: r.change === "refused" || r.change === "withdrawn" ? "off" : "" }))}
        />
      </Figure>
    </section>
  );
}

function BeforeAfter(props: { report: LoopReport }) {
  const { fit, check, volumetric } = props.report;
  const box = (error: BoxError) => `${numberText(error.rms_um)} [${numberText(error.low_um)}, ${numberText(error.high_um)}]`;
  const rms = (value?: number) => (value === undefined ? "–" : numberText(value, 4));
  return (
    <section>
      <h2>{t("beforeAfter")}</h2>
      <Table label={t("beforeAfter")} head={[`${t("rms")}, µm`, t("before"), t("after")]} numbers={[1, 2]}>
        <tr>
          <th scope="row">{t("fitSessions")}</th>
          <td class="number">{rms(fit.before.rms_um)}</td>
          <td class="number">{rms(fit.after.rms_um)}</td>
        </tr>
        {check?.before && (
          <tr>
            <th scope="row">{t("checkSessions")}</th>
            <td class="number">{rms(check.before.rms_um)}</td>
            <td class="number">{rms(check.after?.rms_um)}</td>
          </tr>
        )}
      </Table>
      {volumetric && (
        <>
          <h3>{t("toolPoint")}</h3>
          <p>{volumetric.box.map((b) => `${b.axis} ${numberText(b.from, 4)} … ${numberText(b.to, 4)} ${unitText(b.unit)}`).join(", ")}</p>
          <Table label={t("toolPoint")} head={[t("state"), `${t("rmsUm")} [${t("interval")}]`]} numbers={[1]}>
            <tr>
              <th scope="row">{t("asIs")}</th>
              <td class="number">{box(volumetric.uncorrected)}</td>
            </tr>
            <tr>
              <th scope="row">{t("correctedDeclared")}</th>
              <td class="number">{box(volumetric.before)}</td>
            </tr>
            <tr>
              <th scope="row">{t("correctedAll")}</th>
              <td class="number">{box(volumetric.after)}</td>
            </tr>
          </Table>
          {!volumetric.gain_is_held && <p class="box">{t("noGain")}</p>}
        </>
      )}
    </section>
  );
}

function Effects(props: { report: LoopReport }) {
  const { effects } = props.report;
  if (effects.length === 0) return null;
  return (
    <section>
      <h2>{t("effects")}</h2>
      {effects.map((effect) => {
        const same = (effect.same_always ?? []).map(nameOf);
        const others = (effect.equivalent ?? []).map((one) => besideText(effect.name, one)).filter((name) => !same.includes(name));
        return (
          <article class="box">
            <h3>
              <ErrorName name={effect.name} />
            </h3>
            <p>
              {t("amplitude")}: {valueText(effect.amplitude, effect.amplitude_sigma)} ± {sigmaText(effect.amplitude_sigma)}{" "}
              {unitText(effect.unit)}; {t("rmsOf", { n: numberText(effect.rms_um) })}
            </p>
            {others.length > 0 && (
              <p>
                {t("mayBe")}: <strong>{others.join(", ")}</strong>
              </p>
            )}
            {same.length > 0 && (
              <p>
                {t("sameAlways")}: {same.join(", ")}
              </p>
            )}
          </article>
        );
      })}
    </section>
  );
}

// What was found and is not corrected, and what to do about it. `harm`: the probability that the machine would be worse for it.
// `subjectDe`, `todoDe`: in German, where the report has it.
interface ToDo {
  kind: string;
  subject: string;
  subjectDe?: string;
  evidence?: number;
  harm?: number;
  todo: string;
  todoDe?: string;
}
function Todo(props: { title: string; rows: ToDo[] }) {
  const { rows } = props;
  if (rows.length === 0) return null;
  const hasHarm = rows.some((one) => one.harm !== undefined);
  return (
    <section>
      <h2>{props.title}</h2>
      <Table label={props.title} head={[t("subject"), t("evidence"), ...(hasHarm ? [t("harm")] : []), t("todo")]} numbers={hasHarm ? [1, 2] : [1]}>
        {rows.map((one) => (
          <tr>
            <th scope="row" class="text">
              <Worded said={germanOf(one.subjectDe)} text={one.subject} />
            </th>
            <td class="number">{one.evidence === undefined ? "–" : numberText(one.evidence)}</td>
            {hasHarm && <td class="number">{one.harm === undefined ? "–" : probabilityText(one.harm)}</td>}
            <td class="text">
              {germanOf(one.todoDe) ? <Worded said={germanOf(one.todoDe)} text={one.todo} /> : <Quoted said={todoSaid(one.kind)} text={one.todo} />}
            </td>
          </tr>
        ))}
      </Table>
    </section>
  );
}

function Rest(props: { report: LoopReport }) {
  const { causes, held_back, unexplained, next_measurement, noise, axes_at_rest, not_visible } = props.report;
  // The same session may serve several effects.
  const next = (next_measurement ?? []).filter((one, i, list) => list.findIndex((o) => o.text === one.text && o.effect === one.effect) === i);
  return (
    <>
      <Todo
        title={t("causes")}
        rows={(causes ?? []).map((one) => ({ ...one, subjectDe: one.subject_de, todo: one.correction, todoDe: one.correction_de }))}
      />
      <Todo
        title={t("heldBack")}
        rows={(held_back ?? []).map((one) => ({ kind: one.kind, subject: one.subject, evidence: one.evidence, harm: one.harm, todo: one.measure }))}
      />
      {unexplained.length > 0 && (
        <section>
          <h2>{t("unexplained")}</h2>
          <Table label={t("unexplained")} head={[t("kind"), t("where"), t("rmsUm")]} numbers={[2]}>
            {unexplained.map((one) => (
              <tr>
                <th scope="row" class="text">
                  {tMaybe(`unexplained_${one.kind}`) ?? one.kind}
                </th>
                <td>
                  {[one.session, one.variable, one.from !== undefined && one.to !== undefined ? `${numberText(one.from, 4)} … ${numberText(one.to, 4)} ${unitText(one.unit ?? "")}` : ""]
                    .filter(Boolean)
                    .join(" ")}
                </td>
                <td class="number">{one.rms_um === undefined ? "–" : numberText(one.rms_um)}</td>
              </tr>
            ))}
          </Table>
        </section>
      )}
      {next.length > 0 && (
        <section>
          <h2>{t("nextMeasurement")}</h2>
          <ol class="findings">
            {next.map((one) => (
              <li>
                {one.text ? <Worded said={proposalSaid(one)} text={one.text} /> : t("none")}
                <br />
                <small>
                  {t("tellsApart")} {(one.separates ?? [one.effect]).join(", ")}
                  {one.correlation_before !== undefined &&
                    one.correlation_after !== undefined &&
                    `; ${t("correlation")} ${numberText(one.correlation_before)} → ${numberText(one.correlation_after)}`}
                  {one.beyond && (
                    <>
                      ; {t("beyondTravel")}: <Server text={one.beyond} />
                    </>
                  )}
                </small>
              </li>
            ))}
          </ol>
        </section>
      )}
      {noise && noise.length > 0 && (
        <section>
          <h2>{t("noise")}</h2>
          <Table label={t("noise")} head={[t("sessions"), `${t("statedSigma")}, µm`, `${t("shownSigma")}, µm`]} numbers={[1, 2]}>
            {noise.map((one) => (
              <tr>
                <th scope="row">{one.session}</th>
                <td class="number">{numberText(one.stated_sigma_um)}</td>
                <td class="number">{numberText(one.sigma_um)}</td>
              </tr>
            ))}
          </Table>
        </section>
      )}
      {axes_at_rest && axes_at_rest.length > 0 && (
        <p>
          {t("atRest")}: <strong>{axes_at_rest.join(", ")}</strong>
        </p>
      )}
      {not_visible && not_visible.length > 0 && (
        <details>
          <summary>{t("notVisible")}</summary>
          <p>{not_visible.join(", ")}</p>
        </details>
      )}
    </>
  );
}

export function LoopPage(props: { id: bigint }) {
  const found = useLoad(`loop ${props.id}`, async () => (await calibrations.getCalibration({ calibrationId: props.id })).calibration!);
  return (
    <>
      <Title text={t("loopTitle", { n: props.id })} />
      <Show of={found} rows={8}>
        {(it) => {
          const report = jsonOf<LoopReport>(it.reportJson);
          return (
            <>
              <p class="lead">
                <a href={`#/machines/${encodeURIComponent(it.machineId)}`}>{it.machineId}</a>,{" "}
                <a href={`#/calibrations/${it.calibrationId}`}>{t("calibrationN", { n: it.calibrationId })}</a>
              </p>
              {report?.verdict === undefined ? (
                <Empty text={t("loopNone")} />
              ) : (
                <>
                  <p class="lead">
                    <strong>{tMaybe(`verdict_${report.verdict}`) ?? report.verdict}</strong>
                  </p>
                  <Warnings list={report.warnings} />
                  <Ladder report={report} />
                  <BeforeAfter report={report} />
                  <Effects report={report} />
                  <Rest report={report} />
                  <Pictures id={it.calibrationId} />
                </>
              )}
            </>
          );
        }}
      </Show>
    </>
  );
}
