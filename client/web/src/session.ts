// Who is there, and what is offered to him. What is refused is decided by the server alone.
import { computed, effect, signal } from "@preact/signals";
import { access, epoch, mustSignIn, refusalOf, signIns, watchedFetch, type Problem } from "./api";
import { Role, type Grant } from "./gen/axiscal/v1/access_service_pb";

export interface Identity {
  name: string;
  grants: Grant[];
  isLocal: boolean; // of a server that asks nobody
}
export const identity = signal<Identity | undefined>(undefined);

// A display on a wall: its token, for as long as the page is open, so that it signs in again when the sign-in ends or the server
// was started anew. Only a viewer's is taken, so what is left on an open display changes nothing.
const wallToken = signal("");
export const isWall = computed(() => wallToken.value !== "");

const kIncludes: Record<number, Role[]> = {
  [Role.VIEWER]: [Role.VIEWER, Role.TECHNICIAN, Role.APPROVER, Role.ADMIN],
  [Role.CELL]: [Role.CELL, Role.ADMIN],
  [Role.TECHNICIAN]: [Role.TECHNICIAN, Role.ADMIN],
  [Role.APPROVER]: [Role.APPROVER],
  [Role.ADMIN]: [Role.ADMIN],
};

// Whether to offer what needs the role, for this machine or for any. Of a role for a group it is not known which machines are
// in it, so it is offered.
export function may(role: Role, machineId?: string): boolean {
  const who = identity.value;
  if (who === undefined || (isWall.value && role !== Role.VIEWER)) return false;
  if (who.isLocal) return true;
  return who.grants.some((grant) => {
    if (!kIncludes[role].includes(grant.role)) return false;
    const of = grant.scope?.of;
    return of?.case !== "machine" || machineId === undefined || of.value === machineId;
  });
}
export function isAdminOfAll(): boolean {
  const who = identity.value;
  return (
    who !== undefined && (who.isLocal || who.grants.some((g) => g.role === Role.ADMIN && g.scope?.of.case === "all"))
  );
}

export async function whoAmI(): Promise<void> {
  const answer = await access.getIdentity({});
  mustSignIn.value = false;
  identity.value = { name: answer.name, grants: answer.grants, isLocal: answer.name.startsWith("local:") };
}

// Why the last sign-in was refused; a wall display may not have more than a viewer's token.
export const refusal = signal<Problem | undefined>(undefined);
export const isWallRefused = signal(false);

// Whether it is signed in now.
// `isOver` of a wall: whether its token is no good any more, and not the server that has too much to do or starts.
let isOver = false;
export async function signIn(token: string, asWall = false): Promise<boolean> {
  refusal.value = undefined;
  isWallRefused.value = false;
  const response = await watchedFetch("sign-in", {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ token }),
  });
  isOver = response.status === 401 || response.status === 403;
  if (!response.ok) {
    refusal.value = await refusalOf(response);
    return false;
  }
  signIns.value++;
  await whoAmI();
  if (asWall && !identity.value?.grants.every((g) => g.role === Role.VIEWER)) {
    await signOut();
    isWallRefused.value = isOver = true;
    return false;
  }
  wallToken.value = asWall ? token : "";
  epoch.value++;
  return true;
}

// The wall's sign-in is over: once more, at most every so often.
const kAgainMs = 10_000;
export function watchWall(): void {
  let timer: number | undefined;
  const again = async () => {
    timer = undefined;
    if (!mustSignIn.value || !isWall.value) return;
    try {
      if (await signIn(wallToken.value, true)) return;
      // A token that was revoked: nothing is left to show.
      if (isOver) wallToken.value = "";
      else timer ??= window.setTimeout(again, kAgainMs);
    } catch {
      timer ??= window.setTimeout(again, kAgainMs);
    }
  };
  effect(() => {
    if (mustSignIn.value && isWall.value) timer ??= window.setTimeout(again, 0);
  });
}

export async function signOut(): Promise<void> {
  await watchedFetch("sign-out", { method: "POST", headers: { "Content-Type": "application/json" }, body: "{}" });
  identity.value = undefined;
  wallToken.value = "";
  mustSignIn.value = true;
}

// Whoever may change something is signed out when nothing was touched for so long. A viewer is not: a display on a wall is one.
const kIdleMs = 30 * 60 * 1000;
export function watchIdle(): void {
  let last = Date.now();
  for (const event of ["pointerdown", "keydown", "wheel", "touchstart"])
    addEventListener(event, () => (last = Date.now()), { passive: true, capture: true });
  setInterval(() => {
    const who = identity.value;
    if (who === undefined || who.isLocal || who.grants.every((g) => g.role === Role.VIEWER)) return;
    if (Date.now() - last > kIdleMs) void signOut();
  }, 10_000);
}
