// Programs that bring files from the shop floor (docs/cell.md): which are heard, what waits with them, what wants a person.
import { all, epoch, ingest, useLoad } from "../api";
import { bytesText, countText, timeText } from "../format";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import type { Cell } from "../gen/axiscal/v1/ingest_service_pb";
import { Asking, Empty, Server, Show, Table, Title } from "../parts";
import { may } from "../session";
import { t } from "../text";

const kMostCells = 5000;
const kEveryMs = 10_000;

// Those that want somebody first.
const needOf = (cell: Cell) => (cell.isSilent ? 0 : cell.report!.problem !== "" ? 1 : 2);

function CellMark(props: { cell: Cell }) {
  const need = needOf(props.cell);
  return <span class={`mark ${need === 2 ? "good" : "bad"}`}>{t(need === 0 ? "cellSilent" : need === 1 ? "cellWants" : "cellWell")}</span>;
}

export function CellsPage() {
  const found = useLoad(
    "cells",
    () =>
      all(kMostCells, async (pageToken) => {
        const page = await ingest.listCells({ pageSize: 1000, pageToken });
        return { rows: page.cells, nextPageToken: page.nextPageToken };
      }),
    kEveryMs,
  );
  return (
    <>
      <Title text={t("cellsTitle")} />
      <p>{t("cellsHelp")}</p>
      <Show of={found} rows={5}>
        {(list) =>
          list.rows.length === 0 ? (
            <Empty text={t("cellsNone")} first={t("cellsFirst")} />
          ) : (
            <>
              {!list.isWhole && <p>{t("notAll", { n: countText(list.rows.length) })}</p>}
              <Table
                label={t("cells")}
                head={[t("cell"), t("machine"), t("state"), t("why"), t("waiting"), t("quarantined"), t("heard"), t("cellForget")]}
                numbers={[4, 5]}
              >
                {[...list.rows]
                  .sort((a, b) => needOf(a) - needOf(b))
                  .map((cell) => {
                    const report = cell.report!;
                    return (
                      <tr key={`${report.machineId} ${report.name}`}>
                        <th scope="row">
                          {report.name}
                          <br />
                          <small class="muted">
                            {t("version")} {report.version}
                          </small>
                        </th>
                        <td>
                          <a href={`#/machines/${encodeURIComponent(report.machineId)}`}>{report.machineId}</a>
                        </td>
                        <td>
                          <CellMark cell={cell} />
                        </td>
                        <td class="text">
                          <Server text={report.problem} />
                        </td>
                        <td class="number">
                          {countText(report.waitingFiles)}, {bytesText(report.waitingBytes)}
                        </td>
                        <td class="number">
                          {countText(report.quarantinedFiles)}, {bytesText(report.quarantinedBytes)}
                        </td>
                        <td>
                          {timeText(cell.reportedUtcUs)}, {cell.reportedBy}
                        </td>
                        <td>
                          {may(Role.TECHNICIAN, report.machineId) && (
                            <Asking
                              text={t("cellForget")}
                              of={`${report.name}, ${report.machineId}`}
                              effect={t("cellForgetEffect")}
                              onSure={async () => {
                                await ingest.forgetCell({ machineId: report.machineId, name: report.name });
                                epoch.value++;
                              }}
                            />
                          )}
                        </td>
                      </tr>
                    );
                  })}
              </Table>
            </>
          )
        }
      </Show>
    </>
  );
}
