// SPDX-License-Identifier: BSD-3-Clause
// What the tests of the viewer share: runs, viewers, browsers, logs read by other people's reader.
import { parseIDL } from "@foxglove/omgidl-parser";
import { MessageReader } from "@foxglove/omgidl-serialization";
import lz4 from "@foxglove/wasm-lz4";
import { McapIndexedReader } from "@mcap/core";
import { decompress as unzstd } from "fzstd";
import { spawn, spawnSync } from "node:child_process";
import { existsSync, rmSync } from "node:fs";
import { open } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const bin = process.env.HRP_BIN;
export const folder = process.env.HRP_TEST_FOLDER;
export const root = join(dirname(fileURLToPath(import.meta.url)), "..", "..");
export const scenario = join(root, "models", "scenarios", "squat.yaml");

// Long enough for a loaded machine; it only bounds how long a failing test hangs.
const patience = 60000;

const children = new Set();
process.on("exit", () => children.forEach((child) => child.kill("SIGKILL")));

export function check(condition, text) {
  if (!condition) throw new Error(`FAILED: ${text}`);
  console.log(`ok: ${text}`);
}

export const pause = (ms) => new Promise((done) => setTimeout(done, ms));

// Until `find` gives something; what it gave.
export async function waitFor(what, find) {
  const end = Date.now() + patience;
  while (Date.now() < end) {
    const found = await find();
    if (found) return found;
    await pause(30);
  }
  throw new Error(`FAILED: waited in vain for ${what}`);
}

function start(program, args) {
  const child = spawn(join(bin, program), args, { stdio: ["ignore", "pipe", "pipe"] });
  children.add(child);
  child.text = "";
  child.stdout.on("data", (data) => { child.text += data; });
  child.stderr.on("data", (data) => { child.text += data; });
  child.ended = new Promise((done) => child.on("exit", (code, signal) => {
    children.delete(child);
    child.code = code ?? -1;
    if (signal) child.text += `ended by ${signal}`;
    done(child.code);
  }));
  return child;
}

// How many domains were tried: a second run of a test does not begin with that of the first, which a busy machine refuses late.
let tried = 0;

// A run on a domain of its own; `domain` and `log` are set.
export async function startRun(name, args = [], path = scenario) {
  for (let i = 0; i < 20; ++i) {
    const domain = 40 + ((process.pid * 7 + tried++ * 13) % 60);
    const log = join(folder, `${name}.mcap`);
    rmSync(log, { force: true });
    const run = start("hrp-simulate", [path, "--domain", String(domain), "--log", log, "--no-plot", "--quiet", ...args]);
    // A run that found its domain free has a log; one that did not ends, however late on a busy machine.
    await waitFor(`the log of ${name}`, () => run.code !== undefined || existsSync(log));
    if (run.code !== undefined && run.code !== 0) continue;
    return Object.assign(run, { domain, log });
  }
  throw new Error("FAILED: no free DDS domain");
}

export async function startViewer(args) {
  const viewer = start("hrp-viewer", args);
  await waitFor("the viewer's address", () => viewer.text.includes("http://") || viewer.code !== undefined);
  viewer.url = viewer.text.match(/http:\/\/\S+/)?.[0];
  if (!viewer.url) throw new Error(`FAILED: the viewer did not start: ${viewer.text}`);
  viewer.port = Number(new URL(viewer.url).port);
  viewer.socket = viewer.url.replace("http", "ws");
  // A path as somebody asks for it who knows the token.
  viewer.with = (path) => `${path}${path.includes("?") ? "&" : "?"}${new URL(viewer.url).searchParams}`;
  viewer.end = async () => {
    viewer.kill("SIGTERM");
    return viewer.ended;
  };
  return viewer;
}

export function startBrowser() {
  return chromium.launch({
    executablePath: process.env.HRP_CHROMIUM,
    // No GPU: WebGL in software. Nothing of the browser's own on the network.
    args: ["--headless", "--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run",
           "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  });
}

// A page whose mistakes are the test's, and that may fetch from nowhere else.
export async function openPage(browser, url) {
  const page = await browser.newPage({ viewport: { width: 1366, height: 768 } });
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(String(error.stack)));
  page.on("request", (request) => {
    const target = new URL(request.url());
    if (!["data:", "blob:"].includes(target.protocol) && target.host !== new URL(url).host) page.faults.push(`fetched ${request.url()}`);
  });
  page.setDefaultTimeout(patience);
  await page.goto(url);
  page.describe = () => page.evaluate(() => window.hrpViewer.stage.describe());
  page.text = (selector) => page.locator(selector).textContent();
  return page;
}

// Hash of all payloads by topic, as hrp-log gives it.
export function hashLog(path) {
  const result = spawnSync(join(bin, "hrp-log"), ["hash", path], { encoding: "utf8" });
  if (result.status !== 0) throw new Error(`FAILED: hrp-log hash: ${result.stderr}`);
  return result.stdout;
}

// All messages of a topic, decoded by other people's code from the log alone.
export async function readLog(path, topic) {
  await lz4.isLoaded;
  const file = await open(path);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, size) => {
      const buffer = new Uint8Array(Number(size));
      await file.read(buffer, 0, Number(size), Number(offset));
      return buffer;
    },
  };
  const decompressHandlers = { zstd: (bytes, size) => unzstd(bytes, new Uint8Array(Number(size))), lz4: (bytes, size) => lz4(bytes, Number(size)) };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const messages = [];
  const decoders = new Map();
  for await (const message of reader.readMessages({ topics: [topic] })) {
    const channel = reader.channelsById.get(message.channelId);
    if (!decoders.has(channel.schemaId)) {
      const schema = reader.schemasById.get(channel.schemaId);
      decoders.set(channel.schemaId, new MessageReader(schema.name, parseIDL(new TextDecoder().decode(schema.data))));
    }
    messages.push(decoders.get(channel.schemaId).readMessage(message.data));
  }
  await file.close();
  return messages;
}

// Vertical force on each foot of a ContactForces message, as the page writes it.
export function sumVertical(contactForces, foot, part = "total") {
  return contactForces.pairs.filter((pair) => pair.name_a === foot).reduce((sum, pair) => sum + pair[part].force.z, 0).toFixed(1);
}

// {"L_ANKLE_R_LINK": ["284.4", "284.3", "0.1", "15.3"], ...} from the page, with the step of the forces.
export function readTable(page) {
  return page.evaluate(() => ({
    step: Number(document.getElementById("forces-step").dataset.step),
    feet: Object.fromEntries([...document.querySelectorAll("#feet tbody tr")].map((row) => [row.dataset.foot, [...row.cells].slice(1).map((cell) => cell.textContent)])),
  }));
}

export async function run(test) {
  try {
    await test();
  } catch (error) {
    console.error(error.stack ?? error);
    for (const child of children) console.error(`${child.spawnargs.join(" ")}, which still ran, said: ${child.text.trim() || "nothing"}`);
    process.exit(1);
  }
  process.exit(0);
}
