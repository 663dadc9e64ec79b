// The API, as generated from the protos, and what all pages do with it: know whether the server is there, say errors.
import { createClient, ConnectError, Code } from "@connectrpc/connect";
import { createConnectTransport } from "@connectrpc/connect-web";
import { signal } from "@preact/signals";
import { useLayoutEffect, useState } from "preact/hooks";
import { ErrorInfoSchema } from "./gen/google/rpc/error_details_pb";
import { Access } from "./gen/axiscal/v1/access_service_pb";
import { Events } from "./gen/axiscal/v1/events_service_pb";
import { History } from "./gen/axiscal/v1/history_service_pb";
import { Ingest } from "./gen/axiscal/v1/ingest_service_pb";

// Whether the last request reached the server. While it does not, it is asked again every two seconds.
export const isConnected = signal(true);
// Grows when the connection is back and when data was changed: pages that show it load again.
export const epoch = signal(0);
// The server wants to know who this is.
export const mustSignIn = signal(false);

const kRetryMs = 2000;
// A page that nobody sees follows nothing: all pages of a browser share six connections to a host.
export const isSeen = signal(document.visibilityState === "visible");
document.addEventListener("visibilitychange", () => (isSeen.value = document.visibilityState === "visible"));
let retry: number | undefined;

function lost() {
  isConnected.value = false;
  retry ??= window.setTimeout(async () => {
    retry = undefined;
    try {
      await fetch("app.css", { method: "GET", cache: "no-store" });
      found();
    } catch {
      lost();
    }
  }, kRetryMs);
}

function found() {
  if (isConnected.value) return;
  isConnected.value = true;
  epoch.value++;
}

// Grows with each sign-in. What was asked before one and is refused after it says nothing of who is there now.
export const signIns = signal(0);

// Like fetch; tells the signals above what it finds.
export async function watchedFetch(input: RequestInfo | URL, init?: RequestInit): Promise<Response> {
  const asked = signIns.peek();
  try {
    const response = await fetch(input, init);
    found();
    if (response.status === 401) {
      if (asked !== signIns.peek()) throw new DOMException("asked before the sign-in", "AbortError");
      mustSignIn.value = true;
    }
    return response;
  } catch (error) {
    if (!(error instanceof DOMException && error.name === "AbortError")) lost();
    throw error;
  }
}

// In protobuf's own bytes: the lists of a large fleet are a third as long as in JSON, and read in a fraction of the time.
export const transport = createConnectTransport({ baseUrl: location.origin, fetch: watchedFetch, useBinaryFormat: true });
// Services that the first page needs; the others come with the other pages (services.ts).
export const access = createClient(Access, transport);
export const events = createClient(Events, transport);
export const history = createClient(History, transport);
export const ingest = createClient(Ingest, transport);

// What went wrong, in the server's words, and the reason's name (proto/README.md).
export interface Problem {
  text: string;
  reason: string;
  isConnection: boolean;
  code?: Code;
  facts?: Record<string, string>; // which the reason has (proto/README.md)
  isOwn?: boolean; // the page says it, in the reader's language, not the server
}

// What the page itself refuses to send, in the reader's language.
export class Refusal extends Error {}

export function problemOf(error: unknown): Problem {
  if (error instanceof Refusal) return { text: error.message, reason: "", isConnection: false, isOwn: true };
  const e = ConnectError.from(error);
  const reason = e.findDetails(ErrorInfoSchema)[0]?.reason ?? "";
  if (e.code === Code.Unauthenticated) mustSignIn.value = true;
  return { text: e.rawMessage, reason, code: e.code, isConnection: !isConnected.value };
}

// The body of an answer that is no success (docs/http.md).
export async function refusalOf(response: Response): Promise<Problem> {
  const body = jsonOf<{ message?: string; details?: { debug?: { reason?: string; metadata?: Record<string, string> } }[] }>(await response.text());
  return {
    text: body?.message ?? `HTTP ${response.status}`,
    reason: body?.details?.[0]?.debug?.reason ?? "",
    facts: body?.details?.[0]?.debug?.metadata,
    isConnection: false,
  };
}

// All pages of a list; `most` rows at most, so that a page of the browser does not grow without end.
export async function all<Row>(
  most: number,
  page: (pageToken: string) => Promise<{ rows: Row[]; nextPageToken: string }>,
): Promise<{ rows: Row[]; isWhole: boolean }> {
  const rows: Row[] = [];
  let token = "";
  do {
    const got = await page(token);
    rows.push(...got.rows);
    token = got.nextPageToken;
  } while (token !== "" && rows.length < most);
  return { rows, isWhole: token === "" };
}

export interface Loaded<Data> {
  data?: Data;
  problem?: Problem;
}

// Loads when `key` changes, when the connection is back and, with `everyMs`, again and again while the page is seen: it may depend
// on what was found last. What was there stays until the new is there.
export function useLoad<Data>(key: string, load: () => Promise<Data>, everyMs: number | ((found?: Data) => number) = 0): Loaded<Data> {
  const [state, setState] = useState<Loaded<Data> & { key: string }>({ key });
  const now = epoch.value;
  // At once, and not after the frame that says that it loads.
  useLayoutEffect(() => {
    let isOver = false;
    let timer: number | undefined;
    let data: Data | undefined;
    const run = async () => {
      try {
        data = await load();
        if (!isOver) setState({ key, data });
      } catch (error) {
        const problem = problemOf(error);
        // While the connection is lost what was there stays; the banner says so.
        if (!isOver) setState((old) => (problem.isConnection && old.key === key ? old : { key, problem }));
      }
      later();
    };
    const later = () => {
      const ms = typeof everyMs === "number" ? everyMs : everyMs(data);
      if (!isOver && ms > 0) timer = window.setTimeout(again, ms);
    };
    const again = () => (document.visibilityState === "visible" ? void run() : later());
    void run();
    return () => {
      isOver = true;
      clearTimeout(timer);
    };
  }, [key, now]);
  return state.key === key ? state : {};
}

// A text of the server that is JSON of its own writing (report_json).
export function jsonOf<Type>(text: string): Type | undefined {
  try {
    return JSON.parse(text) as Type;
  } catch {
    return undefined;
  }
}
