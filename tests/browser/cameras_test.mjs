// SPDX-License-Identifier: BSD-3-Clause
// Pictures of cameras: what the page's panel and Foxglove show, live and of the log, are the pixels of the log, and the run
// is the one that nobody has watched.
import { spawnSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { chooseRange, paintColor, paintDepth } from "../../servers/viewer/page/src/depth.js";
import { Reader } from "./foxglove_reader.mjs";
import { bin, check, folder, hashLog, openPage, readLog, root, run, startBrowser, startRun, startViewer, waitFor } from "./lib.mjs";

const color = "rt/eye/image_raw", depth = "rt/eye/depth/image_raw";
const scenario = `robot: ${root}/models/test_robots/box.urdf
feet: [box]
initial: {position: [1, 0, 0.6], rpy: [0.4, 0.3, 0.2]}
sensors:
  camera: {eye: {xyz: [-1, 0, 0.8], rpy: [0, 0.3, 0], width: 32, height: 24, rate: 20}}
  lidar: {scan: {link: box, xyz: [0, 0, 0.5], columns: 24, rows: 4, elevation: [-1, 0.2], rate: 20}}
controller: {type: hold}
steps: {duration: 2}
logging: {pictures: true}
`;

const stampOf = (message) => message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec;
const atTime = (messages, time) => messages.find((message) => Math.abs(stampOf(message) - time) < 1e-9);
const toDepths = (image) => new Float32Array(image.data.slice().buffer);

// { time, pixels, width } of each picture that is on the screen, by title.
const readViews = (page) => page.evaluate(() => Object.fromEntries([...document.querySelectorAll(".camera")].map((view) => {
  const canvas = view.querySelector(".picture");
  const title = view.querySelector("figcaption").textContent.split(/[,:]/)[0];
  const pixels = canvas.dataset.time === undefined ? [] : [...canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data];
  return [title, { time: Number(canvas.dataset.time), pixels, width: canvas.width, problem: view.querySelector(".problem").textContent,
                   ticks: view.querySelector(".ticks").textContent }];
})));

const showsTime = (views, time) => ["eye", "eye depth"].every((title) => Math.abs(views[title]?.time - time) < 1e-9);

// Pictures of a view as they must be, made from the log.
function paint(image) {
  const rgba = new Uint8ClampedArray(4 * image.width * image.height);
  if (image.encoding === "rgb8") paintColor(image.data, rgba);
  else paintDepth(toDepths(image), chooseRange(toDepths(image)), rgba);
  return [...rgba];
}

// Near is brighter than far, and what is not seen is not drawn.
function checkColors(image, pixels) {
  const seen = [...toDepths(image)].map((metres, i) => ({ metres, light: 0.2126 * pixels[4 * i] + 0.7152 * pixels[4 * i + 1] + 0.0722 * pixels[4 * i + 2], alpha: pixels[4 * i + 3] }));
  check(seen.every(({ metres, alpha }) => alpha === (Number.isFinite(metres) ? 255 : 0)), "nothing is drawn where nothing is seen");
  const near = seen.filter(({ alpha }) => alpha > 0).sort((a, b) => a.metres - b.metres);
  const steps = near.slice(1).map(({ light }, i) => light - near[i].light);
  check(near.length > 100 && steps.every((step) => step < 1.5), "near is bright, far is dark");  // colours are whole numbers
}

function checkPixels(views, logged, what) {
  for (const [title, topic] of [["eye", color], ["eye depth", depth]]) {
    const image = atTime(logged[topic], views[title].time);
    const expected = paint(image), wrong = views[title].pixels.filter((value, i) => value !== expected[i]).length;
    check(wrong === 0 && views[title].pixels.length === expected.length, `${what}: all ${image.width} x ${image.height} pixels of ${title} at ${views[title].time} s are those of the log`);
  }
}

// Points that the lidar saw, in its frame; the page has hung them on its link.
async function checkScan(page, log) {
  await page.check("#scan-box");
  const shown = await waitFor("the points of the lidar", () => page.evaluate(() => {
    const points = window.hrpViewer.stage.scans.shown.get("rt/scan/points");
    return points && { numbers: [...points.geometry.attributes.position.array], z: points.position.z, link: points.parent.name };
  }));
  const scan = atTime(await readLog(log, "rt/scan/points"), 0.05);
  const numbers = new Float32Array(scan.data.slice().buffer), expected = [];
  for (let i = 0; i < numbers.length; i += 4) if (Number.isFinite(numbers[i])) expected.push(...numbers.slice(i, i + 3));
  check(expected.length > 30 && shown.numbers.join() === expected.join(), `${expected.length / 3} points of the lidar are those of the log`);
  check(shown.link === "box" && shown.z === 0.5, "and they hang on its link");
}

// A log has no answers to the very last state, such as its pictures; whoever watches may see them.
function checkFoxglove(reader, logged) {
  for (const [topic, image] of [["/eye/image_raw", color], ["/eye/depth/image_raw", depth]]) {
    const last = Math.max(...logged[image].map(stampOf));
    const got = reader.of(topic).filter(({ message }) => stampOf(message) <= last);
    const wrong = got.filter(({ message, timestamp }) => {
      const expected = atTime(logged[image], stampOf(message));
      return !expected || Buffer.compare(Buffer.from(expected.data), Buffer.from(message.data)) !== 0 || Math.abs(Number(timestamp) - stampOf(message) * 1e9) > 1;
    });
    check(got.length > 0 && wrong.length === 0 && reader.channels.get(topic).schemaName === "sensor_msgs/msg/Image", `${got.length} pictures of ${topic} for Foxglove, all as in the log: not at ${wrong.map(({ message, timestamp }) => `${stampOf(message)} (${timestamp})`)}`);
  }
  check(reader.of("/eye/camera_info").some(({ message }) => message.width === 32 && message.k[0] > 0), "and the camera's calibration");
}

run(async () => {
  const path = join(folder, "eye.yaml");
  writeFileSync(path, scenario);
  const simulation = await startRun("eye", ["--paused"], path);
  const viewer = await startViewer(["--domain", String(simulation.domain), "--then", simulation.log]);
  const browser = await startBrowser();
  const page = await openPage(browser, viewer.url);
  await waitFor("the list of cameras", () => page.evaluate(() => !document.getElementById("cameras-box").hidden));
  check((await page.locator(".camera").count()) === 0, "nothing is shown, and so nothing is read, before the panel is open");
  await page.click("#cameras-box summary");
  await page.check(`[data-camera="${depth}"]`);
  const foxglove = new Reader(viewer.socket, "foxglove.sdk.v1");
  const topics = ["/eye/image_raw", "/eye/depth/image_raw", "/eye/camera_info"];
  await waitFor("channels of the camera", () => topics.every((topic) => foxglove.channels.has(topic)));
  for (const topic of topics) foxglove.subscribe(topic);
  await page.selectOption("#steps", "10");
  // Readers find their writers some time after they were made, so pictures of the first steps may be missed.
  const live = await waitFor("a picture of the live run", async () => {
    await page.click("#step");
    const views = await readViews(page);
    return views.eye?.time > 0 && showsTime(views, views.eye.time) && topics.every((topic) => foxglove.of(topic).length > 0) && views;
  });
  check(true, "the panel shows a live run that stands still after each step");
  await page.selectOption("#speed", "0");
  await page.click("#resume");
  check((await simulation.ended) === 0, "the run ends as planned");
  await waitFor("the recorded run", async () => (await page.text("#mode")) === "RECORDED");

  const logged = { [color]: await readLog(simulation.log, color), [depth]: await readLog(simulation.log, depth) };
  checkPixels(live, logged, "live");
  checkColors(atTime(logged[depth], live["eye depth"].time), live["eye depth"].pixels);
  check(/^0.* m$/.test(live["eye depth"].ticks), `the scale is in metres: ${live["eye depth"].ticks}`);
  checkFoxglove(foxglove, logged);
  for (const time of [0.32, 0.07]) {
    await page.evaluate((to) => window.hrpViewer.seek(to), time);
    await waitFor(`the picture of ${time} s`, async () => showsTime(await readViews(page), Math.floor(time * 20 + 1e-9) / 20));
    checkPixels(await readViews(page), logged, "recorded");
  }
  await checkScan(page, simulation.log);
  await page.evaluate((topic) => window.hrpViewer.takePicture({ source: 0, topic, error: "the picture's width is 0" }), color);
  const broken = (await readViews(page)).eye;
  check(broken.problem === "the picture's width is 0" && broken.pixels.length === 0, "what is wrong with a picture is said in its place");
  check(page.faults.length === 0, `the page made no mistake ${page.faults.join("; ")}`);
  await browser.close();
  check((await viewer.end()) === 0, "the viewer ends cleanly");

  const alone = join(folder, "alone.mcap");
  spawnSync(join(bin, "hrp-simulate"), [path, "--in-process", "--log", alone, "--no-plot", "--quiet"]);
  check(hashLog(alone) === hashLog(simulation.log), "the run is the same as one that nobody watches");
});
