// Session files and logs up, each with what became of it. A wrong one is shown with the place that the server names.
import { useState } from "preact/hooks";
import { all, epoch, refusalOf, useLoad, watchedFetch, type Problem } from "../api";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { DropZone, Empty, FileField, Quoted, Show, Table, Title } from "../parts";
import { refusalSaid } from "../refusals";
import { machines } from "../services";
import { may } from "../session";
import { t } from "../text";

interface Sent {
  name: string;
  state: "underWay" | "stored" | "wasThere" | "refused" | "notSent";
  problem?: Problem;
  line?: string; // the file's own line that the error names
  made?: Made;
}

// Of a log the server says it as facts; of a session file in its text: "session file: line 11, column 3 (C_deg): ..."
function placeIn(problem: Problem): { line?: number; column?: number } {
  const { line, column } = problem.facts ?? {};
  if (line !== undefined) return { line: Number(line), column: column === undefined ? undefined : Number(column) };
  const found = /\bline (\d+)(?:, column (\d+))?/.exec(problem.text);
  return found ? { line: Number(found[1]), column: found[2] === undefined ? undefined : Number(found[2]) } : {};
}

const kMostShown = 200;

async function sentOf(name: string, file: File, sending: Promise<Response>): Promise<Sent> {
  try {
    const response = await sending;
    if (response.ok) return { name, state: response.status === 201 ? "stored" : "wasThere", made: (await response.json()) as Made };
    const problem = await refusalOf(response);
    const { line } = placeIn(problem);
    const own = line === undefined ? undefined : (await file.text()).split(/\r?\n/)[line - 1];
    return { name, state: "refused", problem, line: own?.slice(0, kMostShown) };
  } catch {
    return { name, state: "notSent" };
  }
}
const sendSession = (machineId: string, file: File) =>
  sentOf(file.name, file, watchedFetch(`v1/machines/${encodeURIComponent(machineId)}/sessions`, { method: "POST", body: file }));

// What an upload answers: a session, or of a log a session with what was read (PutLogResponse).
interface Made {
  name?: string;
  session?: { name?: string };
  notes?: string[];
  firstLine?: string;
  lastLine?: string;
}

// The names that the server knows (docs/logs.md), which need no template.
const kKnownLogs = ["dprnt", "linuxcnc-probe", "sinumerik-write"];

function LogForm(props: { machineId: string; onSent: (sent: Sent) => void }) {
  const [form, setForm] = useState("");
  const [isBusy, setBusy] = useState(false);
  const [problem, setProblem] = useState("");
  const send = async (event: SubmitEvent) => {
    event.preventDefault();
    const given = new FormData(event.currentTarget as HTMLFormElement);
    const file = (name: string) => {
      const one = given.get(name);
      return one instanceof File && one.name !== "" ? one : undefined;
    };
    const log = file("log"), plan = file("plan"), template = form === "" ? file("template") : form;
    if (log === undefined || template === undefined || (form !== "" && plan === undefined)) return setProblem(t("logNeeds"));
    setProblem("");
    const body = new FormData();
    body.set("log", log);
    body.set("template", template);
    if (plan) body.set("plan", plan);
    const session = String(given.get("session")).trim();
    if (session !== "") body.set("session", session);
    setBusy(true);
    props.onSent({ name: log.name, state: "underWay" });
    props.onSent(await sentOf(log.name, log, watchedFetch(`v1/machines/${encodeURIComponent(props.machineId)}/logs`, { method: "POST", body })));
    setBusy(false);
    epoch.value++;
  };
  return (
    <section>
      <h2>{t("logTitle")}</h2>
      <p>{t("logHelp")}</p>
      <form class="form" onSubmit={send} noValidate>
        <FileField name="log" label={t("logFile")} required />
        <label>
          {t("logForm")}
          <select value={form} onChange={(event) => setForm(event.currentTarget.value)}>
            <option value="">{t("logTemplate")}</option>
            {kKnownLogs.map((name) => (
              <option value={name}>{name}</option>
            ))}
          </select>
        </label>
        {form === "" && <FileField name="template" label={t("logTemplateFile")} required />}
        <FileField name="plan" label={t("logPlan")} />
        <label>
          {t("logSession")}
          <input name="session" autocomplete="off" />
        </label>
        <div role="status">{problem && <p class="box bad">{problem}</p>}</div>
        <p class="buttons">
          <button type="submit" disabled={isBusy || props.machineId === ""}>
            {t("logSend")}
          </button>
        </p>
      </form>
    </section>
  );
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
      now[i] = await sendSession(chosen, files[i]);
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
              const { line, column }: { line?: number; column?: number } = one.problem ? placeIn(one.problem) : {};
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
                    {one.made && (one.made.session?.name ?? one.made.name)}
                    {one.made?.firstLine && `, ${t("logLines", { first: one.made.firstLine, last: one.made.lastLine ?? "" })}`}
                    {one.made?.notes?.map((note) => (
                      <p>
                        <Quoted said={t("compareNote")} text={note} />
                      </p>
                    ))}
                    {one.problem && (
                      <>
                        {line !== undefined && (
                          <strong>{column !== undefined ? t("lineColumn", { line, column }) : t("lineOnly", { line })}. </strong>
                        )}
                        <Quoted said={refusalSaid(one.problem)} text={one.problem.text} />
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
      {list.data && list.data.rows.length > 0 && <LogForm machineId={chosen} onSent={(one) => setSent([one])} />}
    </>
  );
}
