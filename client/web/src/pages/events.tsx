// What people should hear of, as it happens: of one machine or of all; who has seen it, and what is on the shelf.
import { useState } from "preact/hooks";
import { events, problemOf, type Problem, Refusal } from "../api";
import { jumpWords, suspectWords } from "../certainty";
import { isNew, isOpen, isShelved, useEvents } from "../events";
import { certaintyText, dayText, sigmaText, timeText, unitText, valueText } from "../format";
import { Role } from "../gen/axiscal/v1/access_service_pb";
import { EventKind, type Event } from "../gen/axiscal/v1/events_service_pb";
import { adviceSaid, clearedSaid, eventSaid } from "../german";
import { Empty, ErrorWords, FormDialog, ProblemBox, Server, Show, Title, Worded, fieldOf, noteOf } from "../parts";
import { may } from "../session";
import { t, tMaybe } from "../text";

const kShownAtOnce = 50;
// As the server takes them.
const kLongestShelfDays = 365;
const kDayMs = 86_400_000;
const kKinds = Object.values(EventKind).filter((kind): kind is EventKind => typeof kind === "number" && kind !== EventKind.UNSPECIFIED);

export const kindText = (event: Event) => tMaybe(`event_${event.kind}`) ?? String(event.kind);

function StateOfEvent(props: { event: Event }) {
  const { event } = props;
  if (!isOpen(event)) return <span class="mark good">{t("eventCleared")}</span>;
  if (isShelved(event)) return <span class="mark old">{t("eventShelved")}</span>;
  if (event.acknowledgedUtcUs !== undefined) return <span class="mark wait">{t("eventSeen")}</span>;
  return <span class="mark bad">{t("eventNew")}</span>;
}

// Days of the calendar where the reader is, as an input of dates writes them.
function dayOf(ms: number): string {
  const date = new Date(ms);
  return new Date(ms - date.getTimezoneOffset() * 60_000).toISOString().slice(0, 10);
}

function Act(props: { event: Event; what: "acknowledge" | "shelve"; onClose: () => void }) {
  const { event, what, onClose } = props;
  const send = async (form: FormData) => {
    const note = noteOf(form, what === "acknowledge");
    if (what === "acknowledge") {
      await events.acknowledgeEvent({ eventId: event.eventId, note });
    } else {
      // From midnight of that day on, where the reader is.
      const until = Date.parse(`${fieldOf(form, "until")}T00:00`);
      if (Number.isNaN(until)) throw new Refusal(t("dayNeeded"));
      await events.shelveEvent({ eventId: event.eventId, untilUtcUs: BigInt(until) * 1000n, note });
    }
    // The page hears of it by the stream.
  };
  const effect = what === "shelve" ? "shelveEffect" : event.kind === EventKind.STEP ? "acknowledgeStep" : "acknowledgeEffect";
  return (
    <FormDialog
      title={t(what === "acknowledge" ? "acknowledgeTitle" : "shelveTitle", { n: event.eventId })}
      submit={t(what)}
      intro={
        <>
          <p>
            <Worded said={eventSaid(event)} text={event.text} /> <ErrorWords text={event.text} />
          </p>
          <p>{t(effect)}</p>
        </>
      }
      isPlain
      onSend={send}
      onClose={onClose}
    >
      {what === "shelve" && (
        <label>
          {t("shelveUntil")}
          <input
            name="until"
            type="date"
            min={dayOf(Date.now() + kDayMs)}
            max={dayOf(Date.now() + (kLongestShelfDays - 1) * kDayMs)}
            defaultValue={dayOf(Date.now() + 7 * kDayMs)}
          />
        </label>
      )}
      <label>
        {t(what === "acknowledge" ? "word" : "wordOptional")}
        <input name="note" autocomplete="off" />
      </label>
    </FormDialog>
  );
}

// "15 Jun 2026, 10:12, ann: service comes on Monday"
function Word(props: { name: string; us?: bigint; by: string; note: string }) {
  return (
    <li>
      {props.name}: {[props.us === undefined ? "" : timeText(props.us), props.by].filter(Boolean).join(", ")}
      {props.note && <q>{props.note}</q>}
    </li>
  );
}

export function EventItem(props: { event: Event; isOfOneMachine?: boolean }) {
  const { event } = props;
  const [asked, setAsked] = useState<"acknowledge" | "shelve">();
  const [problem, setProblem] = useState<Problem>();
  const id = `event-${event.eventId}`;
  const mayAct = may(Role.TECHNICIAN, event.machineId) || may(Role.APPROVER, event.machineId);
  const takeBack = async () => {
    try {
      setProblem(undefined);
      await events.shelveEvent({ eventId: event.eventId, note: "" });
    } catch (error) {
      setProblem(problemOf(error));
    }
  };
  return (
    <li class={`box event ${isNew(event) ? "new" : ""}`}>
      <p class="event-head">
        <StateOfEvent event={event} /> <strong>{kindText(event)}</strong>{" "}
        {!props.isOfOneMachine && <a href={`#/machines/${encodeURIComponent(event.machineId)}`}>{event.machineId}</a>}{" "}
        <span class="muted">{t("eventRaised", { n: event.eventId, time: timeText(event.raisedUtcUs) })}</span>
      </p>
      <p id={id}>
        <Worded said={eventSaid(event)} text={event.text} /> <ErrorWords text={event.text} />
      </p>
      {isOpen(event) && event.advice && (
        <p>
          {t("todo")}: {adviceSaid(event) ?? <Server text={event.advice} />}{" "}
          {event.kind === EventKind.STEP && mayAct && <a href={`#/machines/${encodeURIComponent(event.machineId)}`}>{t("sayItThere")}</a>}
        </p>
      )}
      <ul class="plain">
        {event.amounts.map((a) => (
          <li>
            {a.symbol}: {valueText(a.size, a.sigma)} {a.sigma > 0 && `± ${sigmaText(a.sigma)} (1 σ) `}
            {unitText(a.unit)}
          </li>
        ))}
        {event.certainty !== undefined && (
          <li>
            {t("certainty", { n: certaintyText(event.certainty) })}
            {event.kind === EventKind.STEP && ` ${jumpWords(event.amounts, event.certainty)}`}
            {event.kind === EventKind.SUSPECT && ` ${suspectWords(event.certainty)}`}
          </li>
        )}
        {event.calibrationId !== undefined && (
          <li>
            <a href={`#/calibrations/${event.calibrationId}`}>{t("calibrationN", { n: event.calibrationId })}</a>
          </li>
        )}
        {event.acknowledgedUtcUs !== undefined && (
          <Word name={t("eventSeen")} us={event.acknowledgedUtcUs} by={event.acknowledgedBy} note={event.acknowledgedNote} />
        )}
        {isOpen(event) && isShelved(event) && (
          <Word name={t("shelvedUntil", { day: dayText(event.shelvedUntilUtcUs!) })} by={event.shelvedBy} note={event.shelvedNote} />
        )}
        {event.clearedUtcUs !== undefined && (
          <li>
            {t("eventCleared")}: {timeText(event.clearedUtcUs)} {clearedSaid(event) ?? <Server text={event.clearedWhy} />}
          </li>
        )}
      </ul>
      {mayAct && (isOpen(event) || event.acknowledgedUtcUs === undefined) && (
        <p class="buttons">
          {event.acknowledgedUtcUs === undefined && (
            <button type="button" aria-describedby={id} onClick={() => setAsked("acknowledge")}>
              {t("acknowledge")}
            </button>
          )}
          {isOpen(event) && (
            <button type="button" class="quiet" aria-describedby={id} onClick={() => (isShelved(event) ? void takeBack() : setAsked("shelve"))}>
              {t(isShelved(event) ? "takeBack" : "shelve")}
            </button>
          )}
        </p>
      )}
      {problem && <ProblemBox problem={problem} />}
      {asked && <Act event={event} what={asked} onClose={() => setAsked(undefined)} />}
    </li>
  );
}

type Which = "heard" | "open" | "all";

export function EventsPage(props: { machineId?: string }) {
  const { machineId = "" } = props;
  const [which, setWhich] = useState<Which>("heard");
  const [kind, setKind] = useState(0);
  const [filter, setFilter] = useState("");
  const [most, setMost] = useState(kShownAtOnce);
  const list = useEvents(machineId, which !== "all");
  const words = filter.toLowerCase();
  const fits = (list.events ?? []).filter(
    (event) =>
      (which === "all" || (isOpen(event) && (which === "open" || !isShelved(event)))) &&
      (kind === 0 || event.kind === kind) &&
      event.machineId.toLowerCase().includes(words),
  );
  return (
    <>
      <Title text={machineId ? t("eventsOf", { machine: machineId }) : t("eventsTitle")}>
        {/* Its place is kept. */}
        <span class={list.isLive ? "mark good" : "mark good placeholder"}>{t("live")}</span>
      </Title>
      {machineId && (
        <p class="lead">
          <a href={`#/machines/${encodeURIComponent(machineId)}`}>{t("toMachine", { machine: machineId })}</a>,{" "}
          <a href="#/events">{t("eventsOfAll")}</a>
        </p>
      )}
      <div class="filters">
        <label>
          {t("show")}
          <select value={which} onChange={(event) => setWhich(event.currentTarget.value as Which)}>
            <option value="heard">{t("showHeard")}</option>
            <option value="open">{t("showOpen")}</option>
            <option value="all">{t("showAll")}</option>
          </select>
        </label>
        <label>
          {t("kind")}
          <select value={kind} onChange={(event) => setKind(Number(event.currentTarget.value))}>
            <option value={0}>{t("allKinds")}</option>
            {kKinds.map((one) => (
              <option value={one}>{tMaybe(`event_${one}`) ?? one}</option>
            ))}
          </select>
        </label>
        {!machineId && (
          <label>
            {t("filterMachine")}
            <input type="search" value={filter} onInput={(event) => setFilter(event.currentTarget.value)} />
          </label>
        )}
      </div>
      <Show of={{ data: list.events, problem: list.problem }} rows={8}>
        {() => (
          <>
            <p class="lead" role="status">
              {t("eventCounts", { n: fits.length, new: fits.filter(isNew).length })}
              {!list.isWhole && ` ${t("notAll", { n: list.events!.length })}`}
            </p>
            {fits.length === 0 ? (
              <Empty text={t(list.events!.length === 0 ? "eventsNone" : "eventsNoFit")} first={list.events!.length === 0 ? t("eventsFirst") : undefined} />
            ) : (
              <ul class="events">
                {fits.slice(0, most).map((event) => (
                  <EventItem key={String(event.eventId)} event={event} isOfOneMachine={machineId !== ""} />
                ))}
              </ul>
            )}
            {fits.length > most && (
              <p class="buttons">
                {t("shownOf", { n: most, all: fits.length })}{" "}
                <button type="button" class="quiet" onClick={() => setMost(most + kShownAtOnce)}>
                  {t("more")}
                </button>
              </p>
            )}
          </>
        )}
      </Show>
    </>
  );
}
