// Jobs: the list, and one job that is followed to its end.
import { useEffect, useState } from "preact/hooks";
import { epoch, isConnected, isSeen, jsonOf, problemOf, useLoad, type Problem } from "../api";
import { numberText, save, secondsText, timeText } from "../format";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { JobState, ProgramUnit, type CompensateParams, type Job } from "../gen/axiscal/v1/job_pb";
import { Empty, Fact, ProblemBox, Quoted, Server, Show, Table, Title } from "../parts";
import { refusalSaid } from "../refusals";
import { isDoubtful, type CompensationReport } from "../reports";
import { jobs } from "../services";
import { may } from "../session";
import { t, tMaybe } from "../text";
import { Outcome } from "./outcome";

const kPageSize = 50;
const kEveryMs = 3000;

export function kindOf(job: Job): string {
  return tMaybe(`kind_${job.params?.kind.case}`) ?? "";
}
export function machineOf(job: Job): string {
  return job.params?.kind.value?.machineId ?? "";
}
export function hasEnded(job: Job): boolean {
  return job.state >= JobState.SUCCEEDED;
}

// What a job does now, by the server's name of it; a name that is not known here stands as it is.
function stageText(job: Job): string {
  const stage = job.progress?.stage ?? "";
  return tMaybe(`stage_${stage.replaceAll(" ", "-")}`) ?? stage;
}

// `report`: of a compensation, where the page has it.
export function JobMark(props: { job: Job; report?: CompensationReport }) {
  const { state } = props.job;
  if (state === JobState.SUCCEEDED && props.report && isDoubtful(props.report)) return <span class="mark wait">{t("jobDoubtful")}</span>;
  const kind = state === JobState.SUCCEEDED ? "good" : state === JobState.FAILED || state === JobState.DEAD ? "bad" : hasEnded(props.job) ? "old" : "wait";
  return <span class={`mark ${kind}`}>{tMaybe(`job_${state}`) ?? state}</span>;
}

// Waiting jobs of a higher one run first, whosever they are.
const kPriorities = [-5, 0, 5] as const;
const priorityText = (priority: number) =>
  t(priority < 0 ? "priorityLater" : priority > 0 ? "priorityFirst" : "priorityUsual") + (kPriorities.some((one) => one === priority) ? "" : ` (${priority})`);

export function Priority(props: { value: number; onChange: (priority: number) => void }) {
  return (
    <p class="filters">
      <label>
        {t("priority")}
        <select value={props.value} onChange={(event) => props.onChange(Number(event.currentTarget.value))}>
          {kPriorities.map((one) => (
            <option value={one}>{priorityText(one)}</option>
          ))}
        </select>
      </label>
    </p>
  );
}

export function JobsPage() {
  const [most, setMost] = useState(kPageSize);
  const found = useLoad(`jobs ${most}`, () => jobs.listJobs({ pageSize: most }), kEveryMs);
  return (
    <>
      <Title text={t("jobs")} />
      <Show of={found} rows={8}>
        {(page) =>
          page.jobs.length === 0 ? (
            <Empty text={t("jobsEmpty")} first={t("jobsFirst")} />
          ) : (
            <>
              <Table
                cards
                label={t("jobs")}
                head={[t("job"), t("state"), t("kind"), t("machine"), t("priority"), t("progress"), t("created"), t("by")]}
              >
                {page.jobs.map((job) => (
                  <tr key={String(job.jobId)}>
                    <th scope="row">
                      <a href={`#/jobs/${job.jobId}`}>{t("jobN", { n: job.jobId })}</a>
                    </th>
                    <td>
                      <JobMark job={job} />
                    </td>
                    <td data-head={t("kind")}>{kindOf(job)}</td>
                    <td data-head={t("machine")}>
                      <a href={`#/machines/${encodeURIComponent(machineOf(job))}`}>{machineOf(job)}</a>
                    </td>
                    <td data-head={t("priority")}>{priorityText(job.priority)}</td>
                    <td class={job.error ? "text" : "whole"}>
                      {job.error ? (
                        <Quoted said={refusalSaid(job.error)} text={job.error.message} />
                      ) : (
                        !hasEnded(job) && stageText(job)
                      )}
                    </td>
                    <td data-head={t("created")}>{timeText(job.createdUtcUs)}</td>
                    <td data-head={t("by")}>{job.createdBy}</td>
                  </tr>
                ))}
              </Table>
              {page.nextPageToken !== "" && (
                <p class="buttons">
                  <button type="button" class="quiet" onClick={() => setMost(most + kPageSize)}>
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

// The job as the server's stream tells it. A stream that breaks is begun again: with the connection, or a little later.
export function useJob(id: bigint | undefined): { job?: Job; problem?: Problem } {
  const [state, setState] = useState<{ id?: bigint; job?: Job; problem?: Problem }>({});
  const now = epoch.value, seen = isSeen.value;
  useEffect(() => {
    if (id === undefined || !seen) return;
    const end = new AbortController();
    let timer: number | undefined;
    const watch = async () => {
      let last: Job | undefined;
      try {
        for await (const message of jobs.watchJob({ jobId: id }, { signal: end.signal })) {
          last = message.job;
          setState({ id, job: last });
        }
      } catch (error) {
        if (end.signal.aborted) return;
        const problem = problemOf(error);
        // A call of its own says whether the server is there, which a broken stream does not.
        try {
          const { job } = await jobs.getJob({ jobId: id }, { signal: end.signal });
          setState({ id, job });
          if (!hasEnded(job!)) timer = window.setTimeout(watch, 1000);
        } catch {
          if (!end.signal.aborted && isConnected.value) setState((old) => ({ ...old, id, problem }));
        }
      }
    };
    void watch();
    return () => {
      end.abort();
      clearTimeout(timer);
    };
  }, [id, now, seen]);
  return state.id === id ? state : {};
}

export function JobProgressBar(props: { job: Job }) {
  const { job } = props;
  const fraction = job.progress?.fraction ?? 0, detail = job.progress?.detail ?? "";
  return (
    <p class="progress">
      <progress aria-label={t("progress")} max={1} value={fraction} />
      <span>
        {stageText(job)} {fraction > 0 && `${numberText(Math.floor(100 * fraction))} %`}
      </span>{" "}
      <small class="muted">
        <Server text={detail} />
      </small>
    </p>
  );
}

// Of a compensation that has ended well.
export const compensationOf = (job?: Job): CompensationReport | undefined =>
  job?.params?.kind.case === "compensate" ? jsonOf<CompensationReport>(job.result?.reportJson ?? "") : undefined;

// What a compensation was asked to do.
function Asked(props: { params: CompensateParams; report?: CompensationReport }) {
  const { params, report } = props;
  return (
    <>
      <Fact name={t("program")}>
        <a href={`v1/programs/${params.programId}`} download>
          {t("programN", { n: params.programId })}
        </a>
      </Fact>
      <Fact name={t("calibration")}>
        {params.calibrationId === undefined ? (report?.calibration ?? t("calibrationInUse")) : <a href={`#/calibrations/${params.calibrationId}`}>{t("calibrationN", { n: params.calibrationId })}</a>}
      </Fact>
      {params.toolTipMm.length > 0 && <Fact name={t("tipShort")}>{params.toolTipMm.map((mm) => numberText(mm, 9)).join("; ")} mm</Fact>}
      {params.options?.dialect && <Fact name={t("dialect")}>{params.options.dialect}</Fact>}
      {params.options && (
        <Fact name={t("programUnit")}>
          {t(params.options.unit === ProgramUnit.MILLIMETRE ? "mm" : params.options.unit === ProgramUnit.INCH ? "inch" : "unitOfProgram")}
        </Fact>
      )}
    </>
  );
}

export function JobPage(props: { id: bigint }) {
  const { job, problem } = useJob(props.id);
  const report = compensationOf(job);
  const [refused, setRefused] = useState<Problem>();
  const act = async (what: () => Promise<unknown>) => {
    setRefused(undefined);
    try {
      await what();
      epoch.value++;
    } catch (error) {
      setRefused(problemOf(error));
    }
  };
  return (
    <>
      <Title text={t("jobN", { n: props.id })}>{job && <JobMark job={job} report={report} />}</Title>
      <Show of={{ data: job, problem: job ? undefined : problem }} rows={5}>
        {(it) => {
          const mayRun = may(Role.TECHNICIAN, machineOf(it));
          return (
            <>
              <p class="lead">
                {kindOf(it)}, <a href={`#/machines/${encodeURIComponent(machineOf(it))}`}>{machineOf(it)}</a>
              </p>
              <div role="status">
                {!hasEnded(it) && (
                  <>
                    <JobProgressBar job={it} />
                    <p class="muted">{t("watching")}</p>
                  </>
                )}
              </div>
              {it.error && <ProblemBox problem={{ text: it.error.message, reason: it.error.reason, code: it.error.code, isConnection: false }} />}
              {refused && <ProblemBox problem={refused} />}
              {it.result?.calibrationId !== undefined && (
                <p class="lead">
                  {t("result")}: <a href={`#/calibrations/${it.result.calibrationId}`}>{t("calibrationN", { n: it.result.calibrationId })}</a>
                </p>
              )}
              {report && <Outcome report={report} programId={it.result?.programIds[0]} />}
              <dl class="facts">
                <Fact name={t("created")}>{timeText(it.createdUtcUs)}</Fact>
                <Fact name={t("by")}>{it.createdBy}</Fact>
                {it.params?.kind.case === "compensate" && <Asked params={it.params.kind.value} report={report} />}
                <Fact name={t("took")}>
                  {it.startedUtcUs !== undefined && it.finishedUtcUs !== undefined ? secondsText(it.finishedUtcUs - it.startedUtcUs) : "–"}
                </Fact>
                <Fact name={t("priority")}>{priorityText(it.priority)}</Fact>
                {it.deadlineUtcUs !== undefined && <Fact name={t("deadline")}>{timeText(it.deadlineUtcUs)}</Fact>}
                <Fact name={t("state")}>{t(it.attempt > it.maxAttempts ? "attemptAfterLosses" : "attempt", { n: it.attempt, all: it.maxAttempts })}</Fact>
              </dl>
              <p class="buttons">
                {mayRun && !hasEnded(it) && (
                  <button type="button" disabled={it.cancelRequested} onClick={() => void act(() => jobs.cancelJob({ jobId: it.jobId }))}>
                    {t("cancelJob")}
                  </button>
                )}
                {mayRun && hasEnded(it) && it.state !== JobState.SUCCEEDED && (
                  <button type="button" onClick={() => void act(() => jobs.requeueJob({ jobId: it.jobId }))}>
                    {t("requeue")}
                  </button>
                )}
                {it.result?.reportJson && (
                  <button type="button" class="quiet" onClick={() => save(`job-${it.jobId}.json`, "application/json", it.result!.reportJson)}>
                    {t("report")}
                  </button>
                )}
              </p>
            </>
          );
        }}
      </Show>
    </>
  );
}
