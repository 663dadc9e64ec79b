// The frame of all pages: who is there, where one can go, whether the server is there.
import { render } from "preact";
import { effect, signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { isConnected, mustSignIn, problemOf, watchedFetch, type Problem } from "./api";
import { Role } from "./gen/axiscal/v1/access_service_pb";
import { identity, isAdminOfAll, isWall, isWallRefused, may, refusal, signIn, signOut, watchIdle, watchWall, whoAmI } from "./session";
import { language, setLanguage, t, type Language } from "./text";
import { ProblemBox, Title } from "./parts";
import { FleetPage } from "./pages/fleet";

type Theme = "auto" | "light" | "dark";
const theme = signal<Theme>((localStorage.getItem("theme") as Theme | null) ?? "auto");
effect(() => {
  localStorage.setItem("theme", theme.value);
  document.documentElement.dataset.theme = theme.value;
});

// "#/machines/mill-7" -> ["machines", "mill-7"]
function placeOf(hash: string): string[] {
  try {
    return hash.replace(/^#\/?/, "").split("?")[0].split("/").map(decodeURIComponent);
  } catch {
    return ["?"];
  }
}
const place = signal(placeOf(location.hash));
addEventListener("hashchange", () => {
  place.value = placeOf(location.hash);
  scrollTo(0, 0);
  // Readers of the screen begin at the new page.
  document.getElementById("main")?.focus();
});

// All pages but the fleet's are a script of their own, so that the fleet is there early. index.html names it, so that it is fetched when nothing else
// is to be done.
type Others = typeof import("./pages/others");
const others = signal<Others | undefined>(undefined);
// A script that did not come once does not come later: the browser remembers that. The page is then loaded anew: when the connection is back, or
// where something answered (a proxy whose server is away, a new version that has other scripts) after a wait that grows.
const othersLost = signal<"no" | "by the connection" | "at the server">("no");
const kReloads = "reloads", kFirstReloadMs = 5000, kMostDoublings = 4;
async function openOthers() {
  try {
    others.value = await import("./pages/others");
    sessionStorage.removeItem(kReloads);
  } catch {
    const isAnswered = await watchedFetch("app.css", { cache: "no-store" }).then(() => true, () => false);
    othersLost.value = isAnswered ? "at the server" : "by the connection";
    if (!isAnswered) return;
    const reloads = Number(sessionStorage.getItem(kReloads) ?? 0);
    sessionStorage.setItem(kReloads, String(reloads + 1));
    setTimeout(() => location.reload(), kFirstReloadMs * 2 ** Math.min(reloads, kMostDoublings));
  }
}

function OtherPage(props: { room: string; word?: string }) {
  useEffect(() => {
    if (othersLost.value === "by the connection" && isConnected.value) location.reload();
  }, [othersLost.value, isConnected.value]);
  useEffect(() => {
    if (others.value === undefined) void openOthers();
  }, []);
  if (others.value !== undefined) return <others.value.OtherPage {...props} />;
  if (othersLost.value === "at the server")
    return <ProblemBox problem={{ text: t("scriptMissing"), reason: "", isConnection: false, isOwn: true }} />;
  return (
    <p class="waiting who-first" role="status">
      {t("loading")}
    </p>
  );
}

function Page() {
  const [room, word] = place.value;
  return room === "" ? <FleetPage /> : <OtherPage room={room} word={word} />;
}

function SignInPage() {
  const [lost, setLost] = useState<Problem>();
  const [isBusy, setBusy] = useState(false);
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const elements = (event.currentTarget as HTMLFormElement).elements;
    const asWall = (elements.namedItem("wall") as HTMLInputElement).checked;
    setBusy(true);
    try {
      setLost(undefined);
      const isIn = await signIn((elements.namedItem("token") as HTMLInputElement).value.trim(), asWall);
      if (asWall && isIn) location.hash = "#/wall";
    } catch (error) {
      setLost(problemOf(error));
    }
    setBusy(false);
  };
  const problem = lost ?? refusal.value;
  return (
    <>
      <Title text={t("signIn")} />
      <form class="box form narrow" onSubmit={submit}>
        <p id="sign-in-help">{t("signInHelp")}</p>
        <label>
          {t("token")}
          <input name="token" type="password" autocomplete="off" required aria-describedby="sign-in-help" />
        </label>
        <label class="check">
          <input name="wall" type="checkbox" defaultChecked={place.value[0] === "wall"} aria-describedby="wall-help" /> {t("wall")}
        </label>
        <p id="wall-help" class="muted">
          {t("wallHelp")}
        </p>
        {problem && <ProblemBox problem={problem} />}
        {isWallRefused.value && (
          <p class="bad-text" role="alert">
            {t("wallViewerOnly")}
          </p>
        )}
        <button type="submit" disabled={isBusy}>
          {t("signIn")}
        </button>
      </form>
    </>
  );
}

function Menu() {
  const room = place.value[0];
  const items: [string, string, boolean][] = [
    ["", t("fleet"), true],
    ["events", t("events"), true],
    ["jobs", t("jobs"), true],
    ["programs", t("programs"), true],
    ["upload", t("upload"), may(Role.CELL)],
    ["routines", t("routines"), true],
    ["cells", t("cells"), true],
    ["webhooks", t("webhooks"), isAdminOfAll()],
    ["audit", t("audit"), isAdminOfAll()],
  ];
  return (
    <nav aria-label={t("mainMenu")}>
      {items
        .filter(([, , isOffered]) => isOffered)
        .map(([name, text]) => (
          <a
            href={`#/${name}`}
            aria-current={room === name || (name === "" && ["machines", "calibrations", "loops"].includes(room)) ? "page" : undefined}
          >
            {text}
          </a>
        ))}
    </nav>
  );
}

function App() {
  const [failed, setFailed] = useState<Problem>();
  useEffect(() => {
    const ask = () => whoAmI().catch((error) => setFailed(mustSignIn.value || !isConnected.value ? undefined : problemOf(error)));
    // At once; and after a restart the server does not know the cookie, so again when it is back.
    return isConnected.subscribe((is) => {
      if (is) void ask();
    });
  }, []);
  const who = identity.value;
  return (
    <>
      <a class="skip" href="#main" onClick={(event) => (event.preventDefault(), document.getElementById("main")?.focus())}>
        {t("skip")}
      </a>
      <header class="top">
        <a class="brand" href="#/">
          Axiscal
        </a>
        {who && !mustSignIn.value && !isWall.value ? <Menu /> : <span class="grow" />}
        {/* A box of its own in front of the settings: when it comes they stay where they are. */}
        {who && !mustSignIn.value && (
          <div class="account">
            <span class="who">{who.name}</span>
            {!who.isLocal && (
              <button type="button" class="quiet" onClick={() => void signOut()}>
                {t("signOut")}
              </button>
            )}
          </div>
        )}
        <div class="settings">
          <select
            aria-label={t("language")}
            value={language.value}
            onChange={(event) => setLanguage(event.currentTarget.value as Language)}
          >
            <option value="en">English</option>
            <option value="de">Deutsch</option>
          </select>
          <select aria-label={t("theme")} value={theme.value} onChange={(event) => (theme.value = event.currentTarget.value as Theme)}>
            <option value="auto">{t("themeAuto")}</option>
            <option value="light">{t("themeLight")}</option>
            <option value="dark">{t("themeDark")}</option>
          </select>
        </div>
      </header>
      <div aria-live="assertive">{!isConnected.value && <div class="lost">{t("lost")}</div>}</div>
      {/* Another one once it is known who is there: the menu that comes above it moves nothing that was seen. */}
      <main key={who ? "known" : "first"} id="main" tabIndex={-1}>
        {mustSignIn.value && !isWall.value ? (
          <SignInPage />
        ) : who ? (
          <Page />
        ) : failed ? (
          <ProblemBox problem={failed} />
        ) : (
          <p class="waiting who-first" role="status">
            {t("loading")}
          </p>
        )}
      </main>
    </>
  );
}

watchIdle();
watchWall();
render(<App />, document.getElementById("app")!);
