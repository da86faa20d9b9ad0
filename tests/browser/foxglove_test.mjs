// SPDX-License-Identifier: BSD-3-Clause
// Conformance with the protocol of Foxglove: its own client connects by both names of the protocol, reads live topics and
// recorded ones, and finds the numbers of the log.
import WebSocket from "ws";
import { Reader } from "./foxglove_reader.mjs";
import { check, readLog, run, startRun, startViewer, waitFor } from "./lib.mjs";

const topics = ["hrp/robot_state", "hrp/contact_forces", "hrp/sensor_data", "hrp/joint_commands"];
const scene = ["/transforms", "/transforms/fixed", "/scene/robot", "/scene/world", "/scene/contacts", "/scene/pushes"];
const text = (message) => JSON.stringify(message, (_, value) => (typeof value === "bigint" ? Number(value) : value));

// What the 3D panel is sent is the run: the base where it was, an arrow for each foot that was pressed.
async function checkScene(reader, log) {
  const byTime = async (topic) => new Map((await readLog(log, topic)).map((message) => [Math.round(message.header.time * 1e9), message]));
  const states = await byTime("hrp/robot_state");
  let largest = 0;
  for (const { timestamp, message } of reader.of("/transforms")) {
    const base = message.transforms[0];
    const p = states.get(Number(timestamp)).X_WB.translation;
    largest = Math.max(largest, ...["x", "y", "z"].map((axis) => Math.abs(base.translation[axis] - p[axis])));
    if (base.parent_frame_id !== "world") throw new Error("FAILED: the base hangs in " + base.parent_frame_id);
  }
  check(largest < 1e-8, `${reader.of("/transforms").length} pictures with the base where the log has it`);  // nine digits
  const forces = await byTime("hrp/contact_forces");
  const wrong = reader.of("/scene/contacts").filter(({ timestamp, message }) => {
    const pressed = new Set(forces.get(Number(timestamp)).pairs.filter((pair) => pair.points.length > 0).map((pair) => `force/${pair.name_a}`));
    const arrows = message.entities.filter((entity) => entity.arrows.length > 0).map((entity) => entity.id);
    return arrows.length !== pressed.size || arrows.some((id) => !pressed.has(id));
  });
  check(wrong.length === 0, `${reader.of("/scene/contacts").length} pictures with an arrow for each foot that is pressed`);
  for (const topic of ["/transforms/fixed", "/scene/robot", "/scene/world"]) check(reader.of(topic).length === 1, `${topic} comes once`);
}

async function checkLive(protocol) {
  // At the speed of the clock, and so long that a busy machine has subscribed long before the end.
  const simulation = await startRun(`live_${protocol.replaceAll(".", "_")}`, ["--speed", "1", "--duration", "4"]);
  const viewer = await startViewer(["--domain", String(simulation.domain), "--read-only"]);
  const reader = new Reader(viewer.socket, protocol);
  await waitFor("channels", () => topics.every((topic) => reader.channels.has(topic)));
  check(reader.info.name.length > 0 && reader.socket.protocol === protocol, `${protocol}: the server says who it is`);
  const channel = reader.channels.get("hrp/robot_state");
  check(channel.encoding === "cdr" && channel.schemaEncoding === "omgidl" && channel.schemaName === "hrp::msg::RobotState", "channels are CDR with omgidl schemas");
  await waitFor("channels of the scene", () => scene.every((topic) => reader.channels.has(topic)));
  check(scene.every((topic) => reader.channels.get(topic).schemaEncoding === "jsonschema" && /^foxglove\./.test(reader.channels.get(topic).schemaName)), "the scene is JSON of Foxglove's types");
  for (const topic of [...topics, ...scene]) reader.subscribe(topic);
  await waitFor("messages of every topic", () => topics.every((topic) => reader.of(topic).length > 20));
  await waitFor("pictures of the scene", () => ["/transforms", "/scene/contacts"].every((topic) => reader.of(topic).length > 5));
  reader.client.unsubscribe(reader.subscriptions.get("hrp/joint_commands"));
  check((await simulation.ended) === 0, "the run ends as planned");
  for (const topic of topics) {
    const logged = new Map((await readLog(simulation.log, topic)).map((message) => [text(message.header), text(message)]));
    // An answer to the last state is used by no step, and no log has it.
    const last = topic === "hrp/joint_commands" ? Math.max(...[...logged.keys()].map((header) => JSON.parse(header).step)) : Infinity;
    const got = reader.of(topic).filter(({ message }) => message.header.step <= last);
    const wrong = got.filter(({ message }) => logged.get(text(message.header)) !== text(message));
    const odd = wrong.map(({ message }) => `\n  got ${text(message)}\n  log ${logged.get(text(message.header))}`);
    check(wrong.length === 0, `${got.length} messages of ${topic}, all as in the log${odd.slice(0, 1)}`);
    const late = got.filter(({ timestamp, message }) => Math.abs(Number(timestamp) - message.header.time * 1e9) > 1);
    check(late.length === 0, "stamped with simulated time");
  }
  await checkScene(reader, simulation.log);
  check(!reader.error && !reader.closed, "no error, connection kept");
  reader.client.close();
  await viewer.end();
  return simulation.log;
}

async function checkRecorded(log) {
  const viewer = await startViewer([log]);
  const reader = new Reader(viewer.socket, "foxglove.sdk.v1");
  await waitFor("channels", () => topics.every((topic) => reader.channels.has(topic)));
  reader.subscribe("hrp/robot_description");
  reader.subscribe("hrp/robot_state");
  reader.subscribe("/transforms");
  reader.subscribe("/scene/robot");
  await waitFor("what the log holds", () => reader.of("hrp/robot_description").length > 0 && reader.of("hrp/robot_state").length > 0);
  check(reader.of("hrp/robot_description")[0].message.name.length > 0, "a recorded run has the same topics");
  // A page that moves along the time line takes Foxglove with it.
  const page = new WebSocket(`ws://127.0.0.1:${viewer.port}${viewer.with("/ws")}`);
  await waitFor("the page", () => page.readyState === WebSocket.OPEN);
  page.send(JSON.stringify({ op: "at", time: 0.25, sources: [0] }));
  await waitFor("the state of that time", () => reader.of("hrp/robot_state").some(({ message }) => Math.abs(message.header.time - 0.25) < 1e-9));
  await waitFor("the picture of that time", () => reader.of("/transforms").some(({ timestamp }) => Number(timestamp) === 250000000));
  check(reader.of("/scene/robot")[0].message.entities.length > 5, "the robot's shapes are there");
  check(true, "and follows the page's time");
  reader.client.subscribe(424242);
  await waitFor("a status", () => reader.statuses.some((status) => status.message.includes("424242")));
  check(!reader.closed, "a channel that does not exist is an error message, not an end");
  reader.socket.send("{ this is no JSON");
  await waitFor("the end", () => reader.closed);
  check(page.readyState === WebSocket.OPEN, "a malformed message ends that connection only");
  page.close();
  await viewer.end();
}

run(async () => {
  await checkLive("foxglove.websocket.v1");
  await checkRecorded(await checkLive("foxglove.sdk.v1"));
});
