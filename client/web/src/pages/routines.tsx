// What runs by itself when sessions have come: the routines, what became of each time that they ran, and the stops of people.
import { clone, create } from "@bufbuild/protobuf";
import { useState } from "preact/hooks";
import { epoch, all, problemOf, useLoad, type Problem } from "../api";
import { countText, timeText } from "../format";
import { Role, ScopeSchema, type Scope } from "../gen/axiscal/v1/access_service_pb";
import { RoutineRunState, RoutineSchema, RoutineWork, type Routine, type RoutineRun } from "../gen/axiscal/v1/routines_service_pb";
import { Asking, Empty, Fact, FormDialog, ProblemBox, Server, Show, Table, Title, fieldOf } from "../parts";
import { machines, routines } from "../services";
import { isAdminOfAll, may } from "../session";
import { t, tMaybe } from "../text";

const kEveryMs = 5000;
const kPageSize = 50;
const kMostMachines = 5000;

const namesOf = (text: string) => text.split(/[,\n]/).map((one) => one.trim()).filter(Boolean);

export function scopeText(scope?: Scope): string {
  if (scope?.of.case === "machine") return `${t("machine")} ${scope.of.value}`;
  if (scope?.of.case === "group") return `${t("group")} ${scope.of.value}`;
  return t("allMachines");
}

function scopeOf(kind: string, name: string): Scope {
  return create(ScopeSchema, { of: kind === "machine" ? { case: "machine", value: name } : kind === "group" ? { case: "group", value: name } : { case: "all", value: true } });
}

// Of a form: machine, group, or all machines, and its name.
export function ScopeFields(props: { scope?: Scope; mayBeAll: boolean }) {
  const of = props.scope?.of;
  const [kind, setKind] = useState<string>(of?.case ?? (props.mayBeAll ? "all" : "machine"));
  return (
    <>
      <label>
        {t("forWhat")}
        <select name="scope-kind" value={kind} onChange={(event) => setKind(event.currentTarget.value)}>
          {props.mayBeAll && <option value="all">{t("allMachines")}</option>}
          <option value="machine">{t("machine")}</option>
          <option value="group">{t("group")}</option>
        </select>
      </label>
      {kind !== "all" && (
        <label>
          {t(kind === "machine" ? "machine" : "group")}
          <input name="scope-name" required autocomplete="off" defaultValue={of?.case === "machine" || of?.case === "group" ? of.value : ""} />
        </label>
      )}
    </>
  );
}
export function scopeFrom(form: FormData): Scope {
  return scopeOf(String(form.get("scope-kind")), String(form.get("scope-name") ?? "").trim());
}

function Edit(props: { routine?: Routine; onClose: () => void }) {
  const { routine } = props;
  const [work, setWork] = useState(routine?.work ?? RoutineWork.IDENTIFY);
  const save = async (form: FormData) => {
    const text = (name: string) => fieldOf(form, name);
    const number = (name: string) => (text(name) === "" ? undefined : Number(text(name)));
    const at = text("at").split(":").map(Number);
    await routines.putRoutine({
      etag: routine?.etag ?? 0n,
      // What this form does not show stays as it is.
      routine: Object.assign(routine ? clone(RoutineSchema, routine) : create(RoutineSchema), {
        name: routine?.name ?? text("name"),
        scope: scopeFrom(form),
        principal: text("principal"),
        sessions: namesOf(text("sessions")),
        checkSessions: work === RoutineWork.CLOSE_LOOP ? namesOf(text("checks")) : [],
        withinHours: number("within") ?? 0,
        atUtcMinute: at.length === 2 ? 60 * at[0] + at[1] : undefined,
        work,
        declaredErrors: work === RoutineWork.IDENTIFY ? namesOf(text("declared")) : [],
        approveWithinUm: number("approve"),
        disabled: form.get("disabled") !== null,
        note: text("note"),
      }),
    });
    epoch.value++;
  };
  const minute = routine?.atUtcMinute;
  const two = (n: number) => String(n).padStart(2, "0");
  return (
    <FormDialog
      title={routine ? t("routineChange", { name: routine.name }) : t("routineNew")}
      submit={t("save")}
      intro={<p>{t("routineHelp")}</p>}
      onSend={save}
      onClose={props.onClose}
    >
      {!routine && (
        <label>
          {t("name")}
          <input name="name" required autocomplete="off" />
        </label>
      )}
      <ScopeFields scope={routine?.scope} mayBeAll={false} />
      <label>
        {t("actsAs")}
        <input name="principal" required autocomplete="off" defaultValue={routine?.principal} />
      </label>
      <label>
        {t("routineWork")}
        <select name="work" value={work} onChange={(event) => setWork(Number(event.currentTarget.value) as RoutineWork)}>
          <option value={RoutineWork.IDENTIFY}>{t("identify")}</option>
          <option value={RoutineWork.CLOSE_LOOP}>{t("closeLoop")}</option>
        </select>
      </label>
      <label>
        {t("routineSessions")}
        <textarea name="sessions" required rows={3} defaultValue={routine?.sessions.join("\n")} />
      </label>
      {work === RoutineWork.CLOSE_LOOP ? (
        <label>
          {t("routineChecks")}
          <textarea name="checks" rows={2} defaultValue={routine?.checkSessions.join("\n")} />
        </label>
      ) : (
        <label>
          {t("routineDeclared")}
          <textarea name="declared" rows={2} defaultValue={routine?.declaredErrors.join("\n")} />
        </label>
      )}
      <label>
        {t("withinHours")}
        <input name="within" type="number" min="1" max="8760" defaultValue={String(routine?.withinHours || 24)} />
      </label>
      <label>
        {t("atUtc")}
        <input name="at" type="time" defaultValue={minute === undefined ? "" : `${two(Math.floor(minute / 60))}:${two(minute % 60)}`} />
      </label>
      <label>
        {t("approveWithin")}
        <input name="approve" type="number" min="0" step="any" defaultValue={routine?.approveWithinUm === undefined ? "" : String(routine.approveWithinUm)} />
      </label>
      <label>
        {t("note")}
        <input name="note" autocomplete="off" defaultValue={routine?.note} />
      </label>
      <label class="check">
        <input name="disabled" type="checkbox" defaultChecked={routine?.disabled} /> {t("routineDisabled")}
      </label>
    </FormDialog>
  );
}

function RoutineBox(props: { routine: Routine; machineIds: string[] }) {
  const { routine } = props;
  const [isEdited, setEdited] = useState(false);
  const [problem, setProblem] = useState<Problem>();
  const [machine, setMachine] = useState("");
  const act = async (what: () => Promise<unknown>) => {
    try {
      setProblem(undefined);
      await what();
      epoch.value++;
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  const its = routine.scope?.of.case === "machine" ? [routine.scope.of.value] : props.machineIds;
  const chosen = machine || its[0] || "";
  const isStopped = routine.stops.some((stop) => stop.machineId === chosen);
  const mayRetry = chosen !== "" && may(Role.TECHNICIAN, chosen);
  const mayStop = mayRetry || (chosen !== "" && may(Role.APPROVER, chosen));
  return (
    <article class="box">
      <h2>
        {routine.name} {routine.disabled && <span class="mark old">{t("isDisabled")}</span>}
        {routine.stops.length > 0 && <span class="mark wait">{t("isStopped", { n: countText(routine.stops.length) })}</span>}
      </h2>
      {routine.note && <p>{routine.note}</p>}
      <dl class="facts">
        <Fact name={t("forWhat")}>{scopeText(routine.scope)}</Fact>
        <Fact name={t("routineWork")}>{t(routine.work === RoutineWork.CLOSE_LOOP ? "kind_closeLoop" : "kind_identify")}</Fact>
        <Fact name={t("routineWhen")}>
          {routine.sessions.join(", ")} ({t("hours", { n: countText(routine.withinHours || 24) })})
        </Fact>
        {routine.checkSessions.length > 0 && <Fact name={t("checkSessions")}>{routine.checkSessions.join(", ")}</Fact>}
        <Fact name={t("then")}>
          {routine.approveWithinUm === undefined ? t("proposes") : t("approvesWithin", { n: countText(routine.approveWithinUm) })}
        </Fact>
        <Fact name={t("actsAs")}>{routine.principal}</Fact>
        <Fact name={t("changedBy")}>
          {routine.changedBy}, {timeText(routine.changedUtcUs)}
        </Fact>
      </dl>
      {routine.stops.length > 0 && (
        <ul class="findings">
          {routine.stops.map((stop) => (
            <li>
              {t("stoppedOn", { machine: stop.machineId })}: {stop.by}, {timeText(stop.atUtcUs)}
              {stop.note && <q>{stop.note}</q>}
            </li>
          ))}
        </ul>
      )}
      {problem && <ProblemBox problem={problem} />}
      <p class="buttons">
        {(mayStop || mayRetry) && (
          <>
            {its.length > 1 && (
              <select aria-label={`${t("machine")}: ${routine.name}`} value={chosen} onChange={(event) => setMachine(event.currentTarget.value)}>
                {its.map((id) => (
                  <option value={id}>{id}</option>
                ))}
              </select>
            )}
            {mayStop && (
              <Asking
                text={t(isStopped ? "goOn" : "stop")}
                of={`${routine.name}, ${chosen}`}
                effect={t(isStopped ? "goOnEffect" : "stopEffect")}
                note={t("wordOptional")}
                onSure={async (note) => {
                  await routines.stopRoutine({ name: routine.name, machineId: chosen, stopped: !isStopped, note });
                  epoch.value++;
                }}
              />
            )}
            {mayRetry && (
            <button
              type="button"
              class="quiet"
              aria-label={`${t("retry")}: ${routine.name}, ${chosen}`}
              onClick={() => void act(() => routines.retryRoutine({ name: routine.name, machineId: chosen }))}
            >
              {t("retry")}
            </button>
            )}
          </>
        )}
        {isAdminOfAll() && (
          <>
            <button type="button" class="quiet" aria-label={`${t("change")}: ${routine.name}`} onClick={() => setEdited(true)}>
              {t("change")}
            </button>
            <Asking
              text={t("remove")}
              of={routine.name}
              effect={t("routineRemoveEffect")}
              onSure={async () => {
                await routines.removeRoutine({ name: routine.name, etag: routine.etag });
                epoch.value++;
              }}
            />
          </>
        )}
      </p>
      {isEdited && <Edit routine={routine} onClose={() => setEdited(false)} />}
    </article>
  );
}
function RunMark(props: { run: RoutineRun }) {
  const { state } = props.run;
  const kind =
    state === RoutineRunState.FAILED
      ? "bad"
      : state === RoutineRunState.AGREES || state === RoutineRunState.APPROVED
        ? "good"
        : state === RoutineRunState.STOPPED
          ? "old"
          : "wait";
  return <span class={`mark ${kind}`}>{tMaybe(`run_${state}`) ?? state}</span>;
}

function Runs() {
  const [most, setMost] = useState(kPageSize);
  const found = useLoad(`runs ${most}`, () => routines.listRoutineRuns({ pageSize: most }), kEveryMs);
  return (
    <section>
      <h2>{t("runs")}</h2>
      <Show of={found} rows={4}>
        {(page) =>
          page.runs.length === 0 ? (
            <p>{t("runsNone")}</p>
          ) : (
            <>
              <Table label={t("runs")} head={[t("run"), t("machine"), t("state"), t("what"), t("created"), t("result")]}>
                {page.runs.map((run) => (
                  <tr key={String(run.runId)}>
                    <th scope="row">
                      {run.routine}, {t("runN", { n: run.runId })}
                    </th>
                    <td>
                      <a href={`#/machines/${encodeURIComponent(run.machineId)}`}>{run.machineId}</a>
                    </td>
                    <td>
                      <RunMark run={run} />
                    </td>
                    <td class="text">
                      <Server text={run.text} />
                    </td>
                    <td>{timeText(run.beganUtcUs)}</td>
                    <td>
                      {run.calibrationId !== undefined ? (
                        <a href={`#/calibrations/${run.calibrationId}`}>{t("calibrationN", { n: run.calibrationId })}</a>
                      ) : run.jobId !== undefined ? (
                        <a href={`#/jobs/${run.jobId}`}>{t("jobN", { n: run.jobId })}</a>
                      ) : (
                        "–"
                      )}
                    </td>
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
    </section>
  );
}

export function RoutinesPage() {
  const [isNew, setNew] = useState(false);
  const found = useLoad("routines", async () => {
    const [list, fleet] = await Promise.all([
      routines.listRoutines({}),
      all(kMostMachines, async (pageToken) => {
        const page = await machines.listMachines({ pageSize: 1000, pageToken });
        return { rows: page.machines.map((m) => m.machineId), nextPageToken: page.nextPageToken };
      }),
    ]);
    return { routines: list.routines, machineIds: fleet.rows };
  });
  return (
    <>
      <Title text={t("routinesTitle")} />
      <p>{t("routinesHelp")}</p>
      {isAdminOfAll() && (
        <p class="buttons">
          <button type="button" onClick={() => setNew(true)}>
            {t("routineNew")}
          </button>
        </p>
      )}
      <Show of={found} rows={5}>
        {(data) =>
          data.routines.length === 0 ? (
            <Empty text={t("routinesNone")} first={t("routinesFirst")} />
          ) : (
            <>
              {data.routines.map((one) => (
                <RoutineBox key={one.name} routine={one} machineIds={data.machineIds} />
              ))}
            </>
          )
        }
      </Show>
      {(found.data || found.problem) && <Runs />}
      {isNew && <Edit onClose={() => setNew(false)} />}
    </>
  );
}
