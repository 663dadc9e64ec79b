// What a compensation did to a program: sizes, lines that were left, the program to take away.
import { numberText } from "../format";
import { Server, Table } from "../parts";
import type { CompensationReport } from "../reports";
import { t } from "../text";

export function Outcome(props: { report: CompensationReport; programId?: bigint }) {
  const { report } = props;
  const left = report.not_corrected ?? [];
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
      <p class="lead">{t("blocks", report.blocks)}</p>
      <Table label={t("outcome")} head={[t("what"), t("maxUm"), t("rmsUm")]} numbers={[1, 2]}>
        {Object.entries(report.correction).map(([axis, peak]) => (
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
      <h3>{t("leftLines")}</h3>
      {left.length === 0 ? (
        <p>{t("none")}</p>
      ) : (
        <>
          <Table label={t("leftLines")} head={[t("lines"), t("why")]}>
            {left.map((range) => (
              <tr>
                <th scope="row">{range.first === range.last ? range.first : `${range.first} – ${range.last}`}</th>
                <td class="text" lang="en">
                  {range.reason}
                </td>
              </tr>
            ))}
          </Table>
          {report.ranges_not_corrected > left.length && <p>{t("shownOf", { n: left.length, all: report.ranges_not_corrected })}</p>}
        </>
      )}
      {report.notes.length > 0 && (
        <>
          <h3>{t("notes")}</h3>
          <ul class="findings">
            {report.notes.map((note) => (
              <li>
                <Server text={note} />
              </li>
            ))}
          </ul>
        </>
      )}
    </section>
  );
}
