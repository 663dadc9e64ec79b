// NC programs: drop one, choose machine and calibration, see what was corrected and what was left, take it away.
import { create } from "@bufbuild/protobuf";
import { useEffect, useState } from "preact/hooks";
import { all, epoch, ingest, jsonOf, problemOf, refusalOf, useLoad, watchedFetch, type Problem } from "../api";
import { bytesText, dayText, numberText, timeText } from "../format";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { CalibrationState, EstimateUnit, type Calibration } from "../gen/axiscal/v1/calibration_pb";
import { CompensateParamsSchema, JobState, OnUnsupported, ProgramUnit, RewriteOptionsSchema } from "../gen/axiscal/v1/job_pb";
import type { Program } from "../gen/axiscal/v1/program_pb";
import { DropZone, Empty, ProblemBox, Show, Table, Title } from "../parts";
import type { LoopReport } from "../reports";
import { calibrations, createJob, machines, programs } from "../services";
import { may } from "../session";
import { t } from "../text";
import { lengthOf, tipOf } from "./calibration";
import { compensationOf, hasEnded, JobMark, JobProgressBar, useJob } from "./jobs";
import { residualText } from "./machine";
import { Doubts, Outcome } from "./outcome";

const kDialects = ["fanuc", "mazak", "haas", "linuxcnc", "sinumerik", "heidenhain"];
const kMostMachines = 5000;
// RewriteOptions.max_correction_mm where none is stated (docs/nc.md), in µm. It stands in the form, so that nobody meets it first in a refusal.
const kMaxCorrectionUm = 500;

// What the description of a machine says of all its programs (docs/formats.md), of which this form asks.
interface Profile {
  tool_tip?: string;
  dialect?: string;
  unit?: string;
}

interface Chosen {
  id: bigint;
  name: string; // as the person's file is called
  storedAs?: string; // the same content was stored before, under this other name
}

export async function putProgram(file: File): Promise<Chosen | Problem> {
  try {
    const response = await watchedFetch(`v1/programs/${encodeURIComponent(file.name)}`, { method: "POST", body: file });
    if (!response.ok) return await refusalOf(response);
    const program = (await response.json()) as { programId: string; name: string };
    return { id: BigInt(program.programId), name: file.name, storedAs: program.name === file.name ? undefined : program.name };
  } catch {
    return { text: t("notSent"), reason: "", isConnection: true, isOwn: true };
  }
}

// Of several of one day what they left of the readings tells which is which.
const nameOf = (c: Calibration) =>
  [t("calibrationN", { n: c.calibrationId }), c.provenance && t("measuredOn", { day: dayText(c.provenance.measuredUtcUs) }), residualText(c)].filter(Boolean).join(", ");

// The field of the form that a refusal is about, by its reason (proto/README.md).
const kFieldOf: Record<string, { label: "programUnit" | "maxCorrection" | "tip" | "tablesOff"; name: string }> = {
  UNIT_NOT_STATED: { label: "programUnit", name: "unit" },
  CORRECTION_TOO_LARGE: { label: "maxCorrection", name: "limit" },
  TOOL_TIP_INVALID: { label: "tip", name: "tip" },
  TABLE_HANDED_OUT: { label: "tablesOff", name: "tablesOff" },
};
// "D1=5 T5D1=6.25", to a German reader 6,25 too -> tool numbers and radii as ToolRadius has them; nothing where it cannot be read.
const kToolsOwn = 10_000; // D1 of tool 5 is 50001
function radiiOf(text: string): { number: number; radiusMm: number }[] | undefined {
  const radii: { number: number; radiusMm: number }[] = [];
  for (const word of text.trim().split(/[\s;]+/).filter(Boolean)) {
    const parts = /^(?:T(\d{1,4}))?D(\d{1,4})=(.+)$/i.exec(word);
    const radiusMm = parts === null ? undefined : lengthOf(parts[3]);
    if (parts === null || radiusMm === undefined || radiusMm < 0) return undefined;
    radii.push({ number: Number(parts[1] ?? 0) * kToolsOwn + Number(parts[2]), radiusMm });
  }
  return radii;
}
const goToField = (name: string) => document.querySelector<HTMLElement>(`main form [name=${name}]`)?.focus();

// Of about what size corrections will be; nobody is told to allow an error that is none of the machine.
function LargestError(props: { of: Calibration; isDoubtful: boolean }) {
  const lengths = props.of.estimates.filter((one) => one.unit === EstimateUnit.UM && one.value !== undefined);
  if (lengths.length === 0) return null;
  const most = lengths.reduce((a, b) => (Math.abs(b.value!) > Math.abs(a.value!) ? b : a));
  return <>{t(props.isDoubtful ? "largestErrorDoubtful" : "largestError", { name: most.symbol, n: numberText(most.value!, 4) })}</>;
}

const kMostSessions = 12; // whose tool points are named

// With which tool points its sessions were measured, as their heads say.
function MeasuredTips(props: { of: Calibration }) {
  const ids = props.of.provenance?.sessionIds ?? [];
  const found = useLoad(`tips ${props.of.calibrationId}`, async () => {
    const names = new Map<string, string[]>();
    for (const { session, schema } of await Promise.all(ids.slice(0, kMostSessions).map((sessionId) => ingest.getSession({ sessionId })))) {
      const tip = schema?.header.find((entry) => entry.key === "tool_tip_mm")?.value;
      if (tip !== undefined) names.set(tip, [...(names.get(tip) ?? []), session?.name ?? ""]);
    }
    return [...names];
  });
  if (!found.data || found.data.length === 0) return null;
  return <>{t("tipsMeasured", { list: found.data.map(([tip, names]) => `${tip} (${names.join(", ")})`).join("; ") })}</>;
}

// How the program is to be read. Nothing is taken for granted that a program need not say: it is asked, unless the machine's description says it.
function Reading(props: { profile?: Profile; basis?: Calibration; isTipWrong: boolean; onTip: () => void }) {
  const { profile, basis, isTipWrong } = props;
  return (
    <>
      {profile && <p class="muted">{t("fromProfile")}</p>}
      <label>
        {t("tip")}
        <input name="tip" required autocomplete="off" placeholder="0 0 -350" defaultValue={profile?.tool_tip ?? ""} aria-describedby={isTipWrong ? "tip-wrong tip-help" : "tip-help"} aria-invalid={isTipWrong} onInput={props.onTip} />
      </label>
      {isTipWrong && (
        <p id="tip-wrong" class="box bad" role="alert">
          {t("tipWrong")}
        </p>
      )}
      <p id="tip-help" class="muted help">
        {t("tipHelp")} {basis && <MeasuredTips of={basis} />}
      </p>
      <label>
        {t("dialect")}
        <select name="dialect" required>
          <option value="">{t("pleaseChoose")}</option>
          {kDialects.map((name) => (
            <option value={name} selected={profile?.dialect === name}>
              {name}
            </option>
          ))}
        </select>
      </label>
      <label>
        {t("programUnit")}
        <select name="unit" required aria-describedby="unit-help">
          <option value="">{t("pleaseChoose")}</option>
          <option value={ProgramUnit.UNSPECIFIED}>{t("unitStated")}</option>
          <option value={ProgramUnit.MILLIMETRE} selected={profile?.unit === "mm"}>
            {t("mm")}
          </option>
          <option value={ProgramUnit.INCH} selected={profile?.unit === "inch"}>
            {t("inch")}
          </option>
        </select>
      </label>
      <p id="unit-help" class="muted help">
        {t("unitHelp")}
      </p>
    </>
  );
}

function Compensate(props: { chosen: Chosen }) {
  const [machineId, setMachine] = useState("");
  const [calibration, setCalibration] = useState("");
  const [problem, setProblem] = useState<Problem>();
  const [isTipWrong, setTipWrong] = useState(false);
  const [isRadiiWrong, setRadiiWrong] = useState(false);
  const [jobId, setJob] = useState<bigint>();
  const { job, problem: lost } = useJob(jobId);
  // What was made of another machine or calibration is no answer to what the form asks now.
  const forget = () => {
    setJob(undefined);
    setProblem(undefined);
  };
  // What it made stands in the list below, too.
  const isDone = job?.state === JobState.SUCCEEDED;
  useEffect(() => {
    if (isDone) epoch.value++;
  }, [isDone]);
  const list = useLoad("machines", () =>
    all(kMostMachines, async (pageToken) => {
      const page = await machines.listMachines({ pageSize: 1000, pageToken });
      const rows = page.machines.map((m) => ({ id: m.machineId, profile: jsonOf<{ programs?: Profile }>(m.descriptionJson)?.programs }));
      return { rows, nextPageToken: page.nextPageToken };
    }),
  );
  // Which machine it is must be said: a program that is corrected for another one is scrap.
  const chosenMachine = machineId || (list.data?.rows.length === 1 ? list.data.rows[0].id : "");
  const profile = list.data?.rows.find((row) => row.id === chosenMachine)?.profile;
  const versions = useLoad(`versions ${chosenMachine}`, async () =>
    chosenMachine === "" ? [] : (await calibrations.listCalibrations({ machineId: chosenMachine, pageSize: 50 })).calibrations,
  );
  const inUse = versions.data?.find((c) => c.state === CalibrationState.APPROVED);
  const isNoneInUse = chosenMachine !== "" && versions.data !== undefined && inUse === undefined;
  const basis = calibration === "" ? inUse : versions.data?.find((c) => String(c.calibrationId) === calibration);
  const own = useLoad(`doubts ${basis?.calibrationId}`, async () =>
    basis === undefined ? undefined : jsonOf<Partial<LoopReport>>((await calibrations.getCalibration({ calibrationId: basis.calibrationId })).calibration?.reportJson ?? ""),
  ).data;
  const isBasisDoubtful = (own?.warnings ?? []).length + (own?.causes ?? []).length > 0;
  const run = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    const tip = tipOf(String(form.get("tip")));
    setProblem(undefined);
    setTipWrong(tip === undefined);
    if (tip === undefined) return goToField("tip");
    const radii = radiiOf(String(form.get("radii")));
    setRadiiWrong(radii === undefined);
    if (radii === undefined) return goToField("radii");
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
              toolRadii: radii,
              maxCorrectionMm: Number(limit) / 1000,
              onUnsupported: form.get("passes") === null ? OnUnsupported.REFUSE : OnUnsupported.PASS,
            }),
          }),
        }),
      );
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  const field = kFieldOf[(problem ?? job?.error)?.reason ?? ""];
  const report = isDone ? compensationOf(job) : undefined;
  const wasRefused = (problem ?? job?.error)?.reason === "PROGRAM_REFUSED";
  return (
    <section>
      <h2>{t("compensateTitle")}</h2>
      <Show of={list}>
        {(found) => (
          <form class="form" onSubmit={run}>
            <p>
              <strong>{t("chosenProgram", { n: props.chosen.id, name: props.chosen.name })}</strong>
              {props.chosen.storedAs && ` ${t("storedBefore", { name: props.chosen.storedAs })}`}
            </p>
            <label>
              {t("machine")}
              <select
                required
                value={chosenMachine}
                onChange={(event) => {
                  setMachine(event.currentTarget.value);
                  setCalibration("");
                  forget();
                }}
              >
                {found.rows.length !== 1 && <option value="">{t("pleaseChoose")}</option>}
                {found.rows.map(({ id }) => (
                  <option value={id}>{id}</option>
                ))}
              </select>
            </label>
            <label>
              {t("calibration")}
              <select required={isNoneInUse} value={calibration} onChange={(event) => (setCalibration(event.currentTarget.value), forget())}>
                <option value="">{inUse ? `${t("calibrationInUse")}: ${nameOf(inUse)}` : t(isNoneInUse ? "pleaseChoose" : "calibrationInUse")}</option>
                {(versions.data ?? [])
                  .filter((c) => c.state === CalibrationState.CANDIDATE)
                  .map((c) => (
                    <option value={String(c.calibrationId)}>
                      {nameOf(c)}, {t("candidate")}
                    </option>
                  ))}
              </select>
            </label>
            {isNoneInUse && (
              <p class="box">
                {t("noneInUse", { machine: chosenMachine })}{" "}
                <a href={`#/machines/${encodeURIComponent(chosenMachine)}`}>{t("toMachine", { machine: chosenMachine })}</a>
              </p>
            )}
            <Doubts warnings={own?.warnings} causes={own?.causes} />
            <Reading key={profile ? chosenMachine : ""} profile={profile} basis={basis} isTipWrong={isTipWrong} onTip={() => setTipWrong(false)} />
            <label>
              {t("maxCorrection")}
              <input name="limit" type="number" min="1" step="any" required defaultValue={String(kMaxCorrectionUm)} aria-describedby="limit-help" />
            </label>
            <p id="limit-help" class="muted help">
              {t("maxCorrectionHelp")} {basis && <LargestError of={basis} isDoubtful={isBasisDoubtful} />}
            </p>
            <label>
              {t("toolRadii")}
              <input name="radii" autocomplete="off" placeholder="D1=5" aria-describedby={isRadiiWrong ? "radii-wrong radii-help" : "radii-help"} aria-invalid={isRadiiWrong} onInput={() => setRadiiWrong(false)} />
            </label>
            {isRadiiWrong && (
              <p id="radii-wrong" class="box bad" role="alert">
                {t("radiiWrong")}
              </p>
            )}
            <p id="radii-help" class="muted help">
              {t("toolRadiiHelp")}
            </p>
            <label class="check">
              <input name="tablesOff" type="checkbox" aria-describedby="tables-help" /> {t("tablesOff")}
            </label>
            <p id="tables-help" class="muted help">
              {t("tablesOffHelp")}
            </p>
            <label class="check">
              <input name="passes" type="checkbox" aria-describedby="passes-help" /> {t("passes")}
            </label>
            <p id="passes-help" class="muted help">
              {t("passesHelp")}
            </p>
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
            <a href={`#/jobs/${job.jobId}`}>{t("jobN", { n: job.jobId })}</a> <JobMark job={job} report={report} />
          </p>
        )}
        {job && !hasEnded(job) && <JobProgressBar job={job} />}
        {(job?.error || field) && (
          <p>
            {t("putBack")}{" "}
            {field && (
              <button type="button" class="quiet" onClick={() => goToField(field.name)}>
                {t("lookAt", { field: t(field.label) })}
              </button>
            )}
            {wasRefused && (
              <>
                {t("refusedHint")}{" "}
                <button type="button" class="quiet" onClick={() => goToField("passes")}>
                  {t("passes")}
                </button>
              </>
            )}
          </p>
        )}
      </div>
      {job?.error && <ProblemBox problem={{ text: job.error.message, reason: job.error.reason, code: job.error.code, isConnection: false }} />}
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
      <td data-head={t("kind")}>{program.kind === "compensated-nc" ? t("corrected") : t("original")}</td>
      <td class="number" data-head={t("size")}>
        {bytesText(program.sizeBytes)}
      </td>
      <td data-head={t("created")}>{timeText(program.createdUtcUs)}</td>
      <td data-head={t("by")}>{program.createdBy}</td>
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
      {mayRun ? <DropZone label={t("dropProgram")} button={t("chooseFile")} onFiles={(files) => void take(files)} /> : <p class="muted">{t("technicianOnly")}</p>}
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
                cards
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

