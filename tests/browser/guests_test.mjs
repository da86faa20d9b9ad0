// SPDX-License-Identifier: BSD-3-Clause
// Guests that behave badly, and many of them: the run does not notice. Ten pages at once, one that never reads, one that
// leaves in mid-frame, malformed and huge frames, strangers: the payloads of the run are those of a run without a viewer.
import { createConnection } from "node:net";
import { randomBytes } from "node:crypto";
import { get } from "node:http";
import WebSocket from "ws";
import { check, hashLog, openPage, run, startBrowser, startRun, startViewer, waitFor } from "./lib.mjs";

const signals = ["hrp/contact_forces:pairs[L_ANKLE_R_LINK].total.force.z", "hrp/sensor_data:positions[L_KNEE]", "hrp/robot_state:X_WB.translation.z"];

function upgrade(viewer, headers = {}) {
  const lines = { Host: `127.0.0.1:${viewer.port}`, Upgrade: "websocket", Connection: "Upgrade", "Sec-WebSocket-Version": "13",
                  "Sec-WebSocket-Key": randomBytes(16).toString("base64"), ...headers };
  return `GET ${viewer.with("/ws")} HTTP/1.1\r\n${Object.entries(lines).map(([key, value]) => `${key}: ${value}\r\n`).join("")}\r\n`;
}

// A raw connection: sends the upgrade, then whatever is given, and tells what comes back.
function connectRaw(viewer, headers) {
  const socket = createConnection(viewer.port, "127.0.0.1");
  socket.answer = "";
  socket.on("data", (data) => { socket.answer += data.toString("latin1").slice(0, 2000 - socket.answer.length); });
  socket.on("close", () => { socket.gone = true; });
  socket.on("error", () => { socket.gone = true; });
  socket.write(upgrade(viewer, headers));
  return socket;
}

const switched = (socket) => waitFor("the upgrade", () => socket.answer.includes("101 Switching"));

function fetchStatus(port, path, headers = {}) {
  return new Promise((done) => get({ port, host: "127.0.0.1", path, headers }, (response) => {
    response.resume();
    done(response.statusCode);
  }));
}

const openSocket = (viewer) => new WebSocket(`ws://127.0.0.1:${viewer.port}${viewer.with("/ws")}`);

function openPlainPage(viewer) {
  const page = openSocket(viewer);
  page.frames = 0;
  page.samples = 0;
  page.on("error", () => {});
  page.on("open", () => page.send(JSON.stringify({ op: "subscribe", signals })));
  page.on("message", (data) => {
    const text = data.toString();
    if (text.startsWith('{"op":"frame"')) ++page.frames;
    if (text.includes('"samples"')) ++page.samples;
  });
  return page;
}

// A client frame with the given first byte and length, masked with zero.
function makeFrame(first, length, payload) {
  const head = Buffer.alloc(14);
  head[0] = first;
  head[1] = 0x80 | 127;
  head.writeBigUInt64BE(BigInt(length), 2);
  return Buffer.concat([head, payload]);
}

async function checkStrangers(viewer) {
  const ask = (path, headers) => fetchStatus(viewer.port, viewer.with(path), headers);
  check((await ask("/", { Host: "evil.example" })) === 403, "a foreign host name (DNS rebinding) is refused");
  check((await ask("/../../../etc/passwd")) === 404, "files outside of the page's folder are not served");
  check((await ask("/%2e%2e/viewer.js")) === 404, "nor by their codes");
  check((await ask(`/mesh?source=0&file=${encodeURIComponent("/etc/passwd")}`)) === 404, "nor as meshes");
  check((await fetchStatus(viewer.port, "/")) === 403, "on this machine, too, nobody looks who does not know the token");
  const stranger = connectRaw(viewer, { Origin: "http://evil.example" });
  await waitFor("a refusal", () => stranger.answer.includes("403"));
  check(true, "a page of another site may not connect");
  stranger.destroy();
}

async function checkBadFrames(viewer) {
  const huge = connectRaw(viewer);
  await switched(huge);
  huge.write(makeFrame(0x81, 2 ** 40, Buffer.alloc(1000)));
  await waitFor("the end of the huge one", () => huge.gone);
  const malformed = connectRaw(viewer);
  await switched(malformed);
  malformed.write(makeFrame(0xff, 10, Buffer.alloc(10)));  // reserved bits and an operation that does not exist
  await waitFor("the end of the malformed one", () => malformed.gone);
  const nonsense = openSocket(viewer);
  nonsense.on("error", () => {});
  nonsense.on("open", () => nonsense.send('{"op":"series","id":1}{'));
  await waitFor("the end of the nonsense", () => nonsense.readyState === WebSocket.CLOSED);
  const large = openSocket(viewer);
  let largeEnd = 0;
  large.on("error", () => {});
  large.on("close", (code) => { largeEnd = code; });
  large.on("open", () => large.send(JSON.stringify({ op: "subscribe", signals: ["x".repeat(100000)] })));
  await waitFor("the end of the large one", () => largeEnd);
  check(largeEnd === 1009, "a message over 64 kB is refused by name (1009, too big)");
  const odd = openSocket(viewer);
  odd.on("open", () => {
    odd.send(JSON.stringify({ op: "subscribe", signals: ["no_colon", "hrp/robot_state:positions[NO_SUCH_JOINT]", "a:b", "hrp/robot_state:[", ...signals] }));
    odd.send(JSON.stringify({ op: "series", id: 1, source: -5, signal: "x" }));
  });
  let told = "";
  odd.on("message", (data) => { told += String(data).includes("NO_SUCH_JOINT") ? "told" : ""; });
  await waitFor("a word about the wrong signal", () => told.includes("told"));
  odd.close();
  check(true, "malformed and huge frames end their connection, wrong names are said");
}

async function runAlone() {
  const simulation = await startRun("alone", ["--duration", "3"]);
  check((await simulation.ended) === 0, "a run without a viewer");
  return simulation;
}

const speedOf = (simulation) => Number(simulation.text.match(/\(([\d.]+) x real time\)/)?.[1]);

run(async () => {
  const alone = await runAlone();
  // Waits for its guests before the first step, then runs as fast as it goes.
  const watched = await startRun("watched", ["--duration", "3", "--paused"]);
  const viewer = await startViewer(["--domain", String(watched.domain)]);
  const browser = await startBrowser();
  const pages = await Promise.all([1, 2].map(() => openPage(browser, viewer.url)));
  const plain = Array.from({ length: 8 }, () => openPlainPage(viewer));
  const stalled = connectRaw(viewer);
  await switched(stalled);
  stalled.pause();
  const leaver = connectRaw(viewer);
  await switched(leaver);
  await checkStrangers(viewer);
  await checkBadFrames(viewer);
  await waitFor("the scheduler", () => pages[0].evaluate(() => window.hrpViewer.run?.phase === "RUN_PAUSED" && window.hrpViewer.topics["hrp/sensor_data"] !== undefined));
  // Slow at first, so that everybody has something to see, and one leaves in the middle of a message of its own.
  await pages[0].selectOption("#speed", "0.5");
  await pages[0].click("#resume");
  await waitFor("frames for all", () => plain.every((page) => page.frames > 3 && page.samples > 1));
  check(true, "ten pages are shown the same run");
  leaver.write(makeFrame(0x81, 5000, Buffer.from('{"op":"subscr')));
  leaver.destroy();
  plain[0].terminate();
  await waitFor("robots", async () => (await Promise.all(pages.map((page) => page.describe()))).every((shown) => shown.robots[0]?.visible));
  await pages[1].selectOption("#speed", "0");
  check((await watched.ended) === 0, "the run with its guests ends as planned");
  check(hashLog(watched.log) === hashLog(alone.log), "its payloads are those of the run without a viewer");
  check(viewer.code === undefined, "the viewer is still there");
  check(plain.slice(1).every((page) => page.readyState === WebSocket.OPEN), "and so are the pages that behaved");
  check(pages.every((page) => page.faults.length === 0), `without mistakes ${pages.map((page) => page.faults.join()).join()}`);
  stalled.destroy();
  await viewer.end();
  await browser.close();

  // Read-only: a page that asks all the same is told, and the run goes on.
  const free = await startRun("read_only", ["--duration", "1", "--speed", "1"]);
  const reader = await startViewer(["--domain", String(free.domain), "--read-only", "--token", "sesame"]);
  check((await fetchStatus(reader.port, "/")) === 403 && (await fetchStatus(reader.port, "/?token=sesam")) === 403, "without the token there is nothing to see");
  check((await fetchStatus(reader.port, "/?token=sesame")) === 200, "with it there is");
  const asker = new WebSocket(`ws://127.0.0.1:${reader.port}/ws?token=sesame`);
  let answer = "";
  asker.on("open", () => asker.send(JSON.stringify({ op: "control", request: "pause" })));
  asker.on("message", (data) => { answer += String(data).includes("read-only") ? "refused" : ""; });
  await waitFor("the refusal", () => answer);
  check((await free.ended) === 0, "run control can be switched off");
  await reader.end();
  console.log(`speed alone ${speedOf(alone)} x real time (reported, not judged)`);
});
