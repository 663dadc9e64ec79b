// Events of one machine or of all, kept as they are now by the server's stream of changes.
import { useEffect, useState } from "preact/hooks";
import { all, epoch, events, isConnected, isSeen, problemOf, type Problem } from "./api";
import type { Event } from "./gen/axiscal/v1/events_service_pb";
import { dateOf } from "./format";

const kMostEvents = 2000;
const kAgainMs = 1000;

export const isOpen = (event: Event) => event.clearedUtcUs === undefined;
export const isShelved = (event: Event) => event.shelvedUntilUtcUs !== undefined && dateOf(event.shelvedUntilUtcUs).getTime() > Date.now();
// What somebody should hear of: it stands, nobody has said a word to it, and it is not on the shelf.
export const isNew = (event: Event) => isOpen(event) && !isShelved(event) && event.acknowledgedUtcUs === undefined;

export async function listEvents(machineId: string, openOnly: boolean): Promise<{ rows: Event[]; isWhole: boolean }> {
  return all(kMostEvents, async (pageToken) => {
    const page = await events.listEvents({ machineId, openOnly, pageSize: 1000, pageToken });
    return { rows: page.events, nextPageToken: page.nextPageToken };
  });
}

export interface EventList {
  events?: Event[]; // newest first
  isWhole: boolean;
  isLive: boolean; // the stream of changes is open
  problem?: Problem;
}

// The stream is asked first, then the list, so that nothing that happens between them is missed; a change that the list holds already does
// no harm. A stream that breaks goes on behind the last change that came. Of cleared events only those that are cleared while one looks
// stay, unless all are asked for.
export function useEvents(machineId: string, openOnly: boolean): EventList {
  const key = `${machineId} ${openOnly}`;
  const [state, setState] = useState<EventList & { key: string }>({ key, isWhole: true, isLive: false });
  const now = epoch.value, seen = isSeen.value;
  useEffect(() => {
    if (!seen) return;
    const end = new AbortController();
    let timer: number | undefined;
    let known: Map<bigint, Event> | undefined;
    let isWhole = true, after: bigint | undefined;
    const show = (isLive: boolean) => {
      if (end.signal.aborted || known === undefined) return;
      const rows = [...known.values()].sort((a, b) => (a.eventId < b.eventId ? 1 : -1));
      setState({ key, events: rows, isWhole, isLive });
    };
    const list = async () => {
      const found = await listEvents(machineId, openOnly);
      isWhole = found.isWhole;
      known = new Map(found.rows.map((event) => [event.eventId, event]));
    };
    const watch = async () => {
      try {
        for await (const { upToChangeId, change } of events.watchEvents({ machineId, afterChangeId: after }, { signal: end.signal })) {
          if (known === undefined) await list();
          after = upToChangeId;
          if (change?.event) known!.set(change.event.eventId, change.event);
          show(true);
        }
      } catch (error) {
        if (end.signal.aborted) return;
        const problem = problemOf(error);
        show(false);
        // The database is another one than before: begin anew.
        if (problem.reason === "CHANGE_UNKNOWN") known = after = undefined;
        try {
          // A call of its own says whether the server is there, which a broken stream does not.
          await events.listEvents({ machineId, openOnly, pageSize: 1 }, { signal: end.signal });
        } catch {
          // While the connection is lost what was there stays; the page loads again with it.
          if (!end.signal.aborted && isConnected.value) setState((old) => ({ ...old, key, problem }));
          return;
        }
        timer = window.setTimeout(watch, kAgainMs);
      }
    };
    void watch();
    return () => {
      end.abort();
      clearTimeout(timer);
    };
  }, [key, now, seen]);
  return state.key === key ? state : { isWhole: true, isLive: false };
}
