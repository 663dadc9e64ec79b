// NC programs: drop one, choose machine and calibration, see what was corrected and what was left, take it away.
import { create } from "@bufbuild/protobuf";
import { useState } from "preact/hooks";
import { all, calibrations, createJob, epoch, jsonOf, machines, problemOf, programs, useLoad, watchedFetch, type Problem } from "../api";
import { bytesText, dayText, timeText } from "../format";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { CalibrationState } from "../gen/axiscal/v1/calibration_pb";
import { CompensateParamsSchema, JobState, ProgramUnit, RewriteOptionsSchema } from "../gen/axiscal/v1/job_pb";
import type { Program } from "../gen/axiscal/v1/program_pb";
import { DropZone, Empty, ProblemBox, Show, Table, Title } from "../parts";
import type { CompensationReport } from "../reports";
import { may } from "../session";
import { t } from "../text";
import { tipOf } from "./calibration";
import { hasEnded, JobMark, JobProgressBar, useJob } from "./jobs";
import { Outcome } from "./outcome";

const kDialects = ["fanuc", "mazak", "haas", "linuxcnc", "sinumerik", "heidenhain"];
const kMostMachines = 5000;

interface Chosen {
  id: bigint;
  name: string;
}

// The body of an answer that is no success (docs/http.md).
export async function refusalOf(response: Response): Promise<Problem> {
  const body = jsonOf<{ message?: string; details?: { debug?: { reason?: string } }[] }>(await response.text());
  return {
    text: body?.message ?? `HTTP ${response.status}`,
    reason: body?.details?.[0]?.debug?.reason ?? "",
    isConnection: false,
  };
}

export async function putProgram(file: File): Promise<Chosen | Problem> {
  try {
    const response = await watchedFetch(`v1/programs/${encodeURIComponent(file.name)}`, { method: "POST", body: file });
    if (!response.ok) return await refusalOf(response);
    const program = (await response.json()) as { programId: string; name: string };
    return { id: BigInt(program.programId), name: program.name };
  } catch {
    return { text: t("notSent"), reason: "", isConnection: true };
  }
}

function Compensate(props: { chosen: Chosen }) {
  const [machineId, setMachine] = useState("");
  const [calibration, setCalibration] = useState("");
  const [problem, setProblem] = useState<Problem>();
  const [jobId, setJob] = useState<bigint>();
  const { job, problem: lost } = useJob(jobId);
  const list = useLoad("machines", () =>
    all(kMostMachines, async (pageToken) => {
      const page = await machines.listMachines({ pageSize: 1000, pageToken });
      return { rows: page.machines.map((m) => m.machineId), nextPageToken: page.nextPageToken };
    }),
  );
  const chosenMachine = machineId || list.data?.rows[0] || "";
  const versions = useLoad(`versions ${chosenMachine}`, async () =>
    chosenMachine === "" ? [] : (await calibrations.listCalibrations({ machineId: chosenMachine, pageSize: 50 })).calibrations,
  );
  const run = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    const tip = tipOf(String(form.get("tip")));
    setProblem(undefined);
    if (tip === undefined) return setProblem({ text: t("tipWrong"), reason: "", isConnection: false });
    const limit = String(form.get("limit"));
    try {
      setJob(
        await createJob({
          case: "compensate",
          value: create(CompensateParamsSchema, {
            machineId: chosenMachine,
            programId: props.chosen.id,
            calibrationId: calibration === "" ? undefined : BigInt(calibration),
            toolTipMm: tip,
            tablesAreOff: form.get("tablesOff") !== null,
            options: create(RewriteOptionsSchema, {
              dialect: String(form.get("dialect")),
              unit: Number(form.get("unit")) as ProgramUnit,
              maxCorrectionMm: limit === "" ? undefined : Number(limit) / 1000,
            }),
          }),
        }),
      );
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  const report = job?.state === JobState.SUCCEEDED ? jsonOf<CompensationReport>(job.result?.reportJson ?? "") : undefined;
  return (
    <section>
      <h2>{t("compensateTitle")}</h2>
      <Show of={list}>
        {(found) => (
          <form class="form" onSubmit={run}>
            <p>
              <strong>{t("chosenProgram", { n: props.chosen.id, name: props.chosen.name })}</strong>
            </p>
            <label>
              {t("machine")}
              <select
                value={chosenMachine}
                onChange={(event) => {
                  setMachine(event.currentTarget.value);
                  setCalibration("");
                }}
              >
                {found.rows.map((id) => (
                  <option value={id}>{id}</option>
                ))}
              </select>
            </label>
            <label>
              {t("calibration")}
              <select value={calibration} onChange={(event) => setCalibration(event.currentTarget.value)}>
                <option value="">{t("calibrationInUse")}</option>
                {(versions.data ?? [])
                  .filter((c) => c.state !== CalibrationState.RETIRED)
                  .map((c) => (
                    <option value={String(c.calibrationId)}>
                      {t("calibrationN", { n: c.calibrationId })},{" "}
                      {t(c.state === CalibrationState.APPROVED ? "approved" : "candidate")},{" "}
                      {c.provenance ? dayText(c.provenance.measuredUtcUs) : ""}
                    </option>
                  ))}
              </select>
            </label>
            <label>
              {t("tip")}
              <input name="tip" required autocomplete="off" />
            </label>
            <label>
              {t("dialect")}
              <select name="dialect">
                {kDialects.map((name) => (
                  <option value={name}>{name}</option>
                ))}
              </select>
            </label>
            <label>
              {t("programUnit")}
              <select name="unit">
                <option value={ProgramUnit.UNSPECIFIED}>{t("unitNone")}</option>
                <option value={ProgramUnit.MILLIMETRE}>{t("mm")}</option>
                <option value={ProgramUnit.INCH}>{t("inch")}</option>
              </select>
            </label>
            <label>
              {t("maxCorrection")}
              <input name="limit" type="number" min="1" step="any" />
            </label>
            <label class="check">
              <input name="tablesOff" type="checkbox" /> {t("tablesOff")}
            </label>
            <p class="buttons">
              <button type="submit" disabled={job !== undefined && !hasEnded(job)}>
                {t("compensate")}
              </button>
            </p>
            {problem && <ProblemBox problem={problem} />}
          </form>
        )}
      </Show>
      <div role="status">
        {job && (
          <p>
            <a href={`#/jobs/${job.jobId}`}>{t("jobN", { n: job.jobId })}</a> <JobMark job={job} />
          </p>
        )}
        {job && !hasEnded(job) && <JobProgressBar job={job} />}
        {job?.error && <p>{t("putBack")}</p>}
      </div>
      {job?.error && <ProblemBox problem={{ text: job.error.message, reason: job.error.reason, isConnection: false }} />}
      {lost && !job && <ProblemBox problem={lost} />}
      {report && <Outcome report={report} programId={job?.result?.programIds[0]} />}
    </section>
  );
}

export function ProgramsPage() {
  const [chosen, setChosen] = useState<Chosen>();
  const [problem, setProblem] = useState<Problem>();
  const [most, setMost] = useState(20);
  const found = useLoad(`programs ${most}`, () => programs.listPrograms({ pageSize: most }));
  const mayRun = may(Role.TECHNICIAN);
  const take = async (files: File[]) => {
    if (files.length === 0) return;
    const answer = await putProgram(files[0]);
    if ("text" in answer) return setProblem(answer);
    setProblem(undefined);
    setChosen(answer);
    epoch.value++;
  };
  const row = (program: Program) => (
    <tr key={String(program.programId)}>
      <th scope="row" class="text">
        {program.name}
      </th>
      <td>{program.kind === "compensated-nc" ? t("corrected") : t("original")}</td>
      <td class="number">{bytesText(program.sizeBytes)}</td>
      <td>{timeText(program.createdUtcUs)}</td>
      <td>{program.createdBy}</td>
      <td>
        <a href={`v1/programs/${program.programId}`} download={program.name} aria-label={`${t("download")}: ${program.name}`}>
          {t("download")}
        </a>
      </td>
      {mayRun && (
        <td>
          {program.kind === "nc" && (
            <button
              type="button"
              class="quiet"
              aria-label={`${t("choose")}: ${program.name}`}
              onClick={() => setChosen({ id: program.programId, name: program.name })}
            >
              {t("choose")}
            </button>
          )}
        </td>
      )}
    </tr>
  );
  return (
    <>
      <Title text={t("programs")} />
      {mayRun ? <DropZone label={t("dropProgram")} onFiles={(files) => void take(files)} /> : <p class="muted">{t("technicianOnly")}</p>}
      {problem && <ProblemBox problem={problem} />}
      {chosen && <Compensate key={String(chosen.id)} chosen={chosen} />}
      {!chosen && mayRun && <p>{t("chooseProgramFirst")}</p>}
      <Show of={found} rows={6}>
        {(page) =>
          page.programs.length === 0 ? (
            <Empty text={t("programsEmpty")} />
          ) : (
            <>
              <Table
                label={t("programs")}
                head={[t("name"), t("kind"), t("size"), t("created"), t("by"), t("download"), ...(mayRun ? [t("choose")] : [])]}
                numbers={[2]}
              >
                {page.programs.map(row)}
              </Table>
              {page.nextPageToken !== "" && (
                <p class="buttons">
                  <button type="button" class="quiet" onClick={() => setMost(most + 50)}>
                    {t("more")}
                  </button>
                </p>
              )}
            </>
          )
        }
      </Show>
    </>
  );
}

