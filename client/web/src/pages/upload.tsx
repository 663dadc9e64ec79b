// Session files up, each with what became of it. A wrong one is shown with the place that the server names.
import { useState } from "preact/hooks";
import { all, epoch, machines, useLoad, watchedFetch, type Problem } from "../api";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { DropZone, Empty, Server, Show, Table, Title } from "../parts";
import { may } from "../session";
import { t } from "../text";
import { refusalOf } from "./programs";

interface Sent {
  name: string;
  state: "underWay" | "stored" | "wasThere" | "refused" | "notSent";
  problem?: Problem;
  line?: string; // the file's own line that the error names
  sessionName?: string;
}

// "session file: line 11, column 3 (C_deg): ..."
function placeIn(text: string): { line?: number; column?: number } {
  const found = /\bline (\d+)(?:, column (\d+))?/.exec(text);
  return found ? { line: Number(found[1]), column: found[2] === undefined ? undefined : Number(found[2]) } : {};
}

const kMostShown = 200;

async function send(machineId: string, file: File): Promise<Sent> {
  const name = file.name;
  try {
    const response = await watchedFetch(`v1/machines/${encodeURIComponent(machineId)}/sessions`, { method: "POST", body: file });
    if (response.ok) {
      const session = (await response.json()) as { name?: string };
      return { name, state: response.status === 201 ? "stored" : "wasThere", sessionName: session.name };
    }
    const problem = await refusalOf(response);
    const { line } = placeIn(problem.text);
    const own = line === undefined ? undefined : (await file.text()).split(/\r?\n/)[line - 1];
    return { name, state: "refused", problem, line: own?.slice(0, kMostShown) };
  } catch {
    return { name, state: "notSent" };
  }
}

export function UploadPage(props: { machineId?: string }) {
  const [machineId, setMachine] = useState(props.machineId ?? "");
  const [sent, setSent] = useState<Sent[]>([]);
  const list = useLoad("machines", () =>
    all(5000, async (pageToken) => {
      const page = await machines.listMachines({ pageSize: 1000, pageToken });
      return { rows: page.machines.map((m) => m.machineId), nextPageToken: page.nextPageToken };
    }),
  );
  const offered = (list.data?.rows ?? []).filter((id) => may(Role.CELL, id));
  const chosen = machineId || offered[0] || "";
  const take = async (files: File[]) => {
    const first: Sent[] = files.map((file) => ({ name: file.name, state: "underWay" }));
    setSent(first);
    const now = [...first];
    for (let i = 0; i < files.length; ++i) {
      now[i] = await send(chosen, files[i]);
      setSent([...now]);
    }
    epoch.value++;
  };
  if (!may(Role.CELL)) {
    return (
      <>
        <Title text={t("uploadTitle")} />
        <p class="muted">{t("cellOnly")}</p>
      </>
    );
  }
  return (
    <>
      <Title text={t("uploadTitle")} />
      <p>{t("uploadHelp")}</p>
      <Show of={list}>
        {(found) =>
          found.rows.length === 0 ? (
            <Empty text={t("fleetEmpty")} first={t("fleetFirst")} />
          ) : (
            <>
              <div class="filters">
                <label>
                  {t("machine")}
                  <select value={chosen} onChange={(event) => setMachine(event.currentTarget.value)}>
                    {offered.map((id) => (
                      <option value={id}>{id}</option>
                    ))}
                  </select>
                </label>
              </div>
              <DropZone label={t("dropSessions")} button={t("chooseFile")} many disabled={chosen === ""} onFiles={(files) => void take(files)} />
            </>
          )
        }
      </Show>
      <div role="status">
        {sent.length > 0 && (
          <Table label={t("uploadTitle")} head={[t("file"), t("state"), t("what")]}>
            {sent.map((one) => {
              const { line, column } = placeIn(one.problem?.text ?? "");
              return (
                <tr>
                  <th scope="row" class="text">
                    {one.name}
                  </th>
                  <td>
                    <span class={`mark ${one.state === "refused" || one.state === "notSent" ? "bad" : one.state === "underWay" ? "wait" : "good"}`}>
                      {t(one.state)}
                    </span>
                  </td>
                  <td class="text">
                    {one.sessionName}
                    {one.problem && (
                      <>
                        {line !== undefined && (
                          <strong>{column !== undefined ? t("lineColumn", { line, column }) : t("lineOnly", { line })}. </strong>
                        )}
                        <Server text={one.problem.text} />
                        {one.line !== undefined && <pre>{one.line}</pre>}
                      </>
                    )}
                  </td>
                </tr>
              );
            })}
          </Table>
        )}
      </div>
      {sent.some((one) => one.state === "stored" || one.state === "wasThere") && (
        <p>
          <a href={`#/machines/${encodeURIComponent(chosen)}`}>{t("nextStep")}</a>
        </p>
      )}
    </>
  );
}
