// A browser and servers for what runs in tests/browser/run.
import { spawn } from "node:child_process";
import net from "node:net";
import path from "node:path";
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);
const { chromium } = require("playwright-core");
const kChromium = process.env.AXISCAL_CHROMIUM ?? "/usr/lib/chromium/chromium";
export const kHere = path.dirname(new URL(import.meta.url).pathname);

export async function openBrowser() {
  return await chromium.launch({ executablePath: kChromium });
}

async function freePort() {
  return await new Promise((resolve) => {
    const probe = net.createServer().listen(0, "127.0.0.1", () => {
      const { port } = probe.address();
      probe.close(() => resolve(port));
    });
  });
}

// A server process on this database. `port` 0: any free one.
export async function startServer(database, port = 0, flags = ["--ask-identity"]) {
  const http = port || (await freePort());
  const child = spawn(path.join(kHere, "bin", "axiscald"), ["--db", database, "--listen", "127.0.0.1:0", "--http", `127.0.0.1:${http}`, ...flags]);
  let said = "";
  child.stderr.on("data", (text) => (said += text));
  await new Promise((resolve, reject) => {
    child.stdout.on("data", (text) => String(text).includes("serves HTTP") && resolve());
    child.on("exit", () => reject(new Error(`axiscald ended: ${said}`)));
  });
  child.removeAllListeners("exit");
  const stop = () =>
    new Promise((resolve) => {
      if (child.exitCode !== null) return resolve();
      child.on("exit", resolve);
      child.kill("SIGTERM");
    });
  return { port: http, url: `http://127.0.0.1:${http}`, stop };
}
