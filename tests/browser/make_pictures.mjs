// SPDX-License-Identifier: BSD-3-Clause
// Makes the pictures of the viewer in docs/images: the default run live and recorded, and beside a run with softer arms; what
// cameras see; a push. With the word "cameras" or "push" only that.
// HRP_BIN=build/bin HRP_CHROMIUM=$(command -v chromium) HRP_TEST_FOLDER=$(mktemp -d) node tests/browser/make_pictures.mjs
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { folder, openPage, root, run, startBrowser, startRun, startViewer, waitFor } from "./lib.mjs";

const scenario = join(root, "models", "scenarios", "default.yaml");
const images = join(root, "docs", "images");
const midStep = 6.35;  // [s] one foot in the air

const shoot = (page, name) => page.screenshot({ path: join(images, name) });

async function seek(page, time) {
  await page.evaluate((to) => window.hrpViewer.seek(to), time);
  await waitFor("the time", async () => Math.abs(Number(await page.text("#time")) - time) < 0.01);
  await page.evaluate(() => window.hrpViewer.stage.lookAtRobot());
  await new Promise((done) => setTimeout(done, 1500));
}

// The panel alone: it is in two documents.
async function makeCameras(browser) {
  const walk = await startRun("cameras", ["--duration", "6"], join(root, "models", "scenarios", "cameras.yaml"));
  await walk.ended;
  const player = await startViewer([walk.log]);
  const shown = await openPage(browser, player.url);
  await waitFor("a robot", async () => (await shown.describe()).robots[0]?.visible);
  await shown.click("#cameras-box summary");
  await shown.check("[data-camera='rt/head/image_raw']");
  await shown.check("[data-camera='rt/head/depth/image_raw']");
  await shown.uncheck("[data-camera='rt/beside/image_raw']");
  await shown.check("#scan-box");
  await seek(shown, 5);
  await shown.evaluate(() => {
    const { stage } = window.hrpViewer;
    stage.camera.position.set(-1.6, -3.6, 2.6);
    stage.controls.target.set(2, 0, 0.5);
    stage.controls.update();
  });
  await waitFor("the points", () => shown.evaluate(() => window.hrpViewer.stage.scans.shown.size > 0));
  await new Promise((done) => setTimeout(done, 1500));
  await shoot(shown, "viewer_cameras.png");
  await player.end();
}

// The picture alone, while the mouse pulls at the chest.
async function makePush(browser) {
  const standing = await startRun("pushed", ["--speed", "0.1", "--duration", "0"], scenario);
  const viewer = await startViewer(["--domain", String(standing.domain)]);
  const page = await openPage(browser, viewer.url);
  await waitFor("a robot", async () => (await page.describe()).robots[0]?.visible);
  await page.click("#push");
  const { x, y, width, height } = await page.locator("#scene").boundingBox();
  const spot = [x + 0.47 * width, y + 0.35 * height];
  await page.mouse.move(...spot);
  await page.mouse.down();
  await page.mouse.move(spot[0] - 50, spot[1] + 6);
  await waitFor("the push", async () => (await page.describe()).arrows.some(({ part }) => part === "push"));
  await new Promise((done) => setTimeout(done, 300));
  await page.locator("#stage").screenshot({ path: join(images, "viewer_push.png") });
  await page.mouse.up();
  await viewer.end();
  standing.kill("SIGINT");
  await standing.ended;
}

run(async () => {
  const makers = { cameras: makeCameras, push: makePush, runs: makeRuns };
  const wanted = Object.keys(makers).filter((name) => process.argv.includes(name));
  const browser = await startBrowser();
  for (const name of wanted.length > 0 ? wanted : Object.keys(makers)) await makers[name](browser);
  await browser.close();
});

async function makeRuns(browser) {
  const live = await startRun("walk", ["--paused", "--duration", "0"], scenario);
  const viewer = await startViewer(["--domain", String(live.domain)]);
  const page = await openPage(browser, viewer.url);
  await waitFor("the scheduler", () => page.evaluate(() => window.hrpViewer.run?.phase === "RUN_PAUSED" && window.hrpViewer.charts.length > 0));
  await page.selectOption("#speed", "0.5");
  // Within the page: a click from here comes seconds late where the picture is drawn without a graphics card.
  await page.evaluate((time) => new Promise((done) => {
    document.getElementById("resume").click();
    const timer = setInterval(() => {
      if (window.hrpViewer.time < time) return;
      clearInterval(timer);
      document.getElementById("pause").click();
      done();
    }, 10);
  }), midStep);
  await waitFor("the pause", () => page.evaluate(() => window.hrpViewer.run?.phase === "RUN_PAUSED"));
  await page.evaluate(() => window.hrpViewer.stage.lookAtRobot());
  await new Promise((done) => setTimeout(done, 1500));
  await shoot(page, "viewer_live.png");
  await viewer.end();
  live.kill("SIGINT");
  await live.ended;

  // The same walk with arms that give more.
  const text = readFileSync(scenario, "utf8").replace(/robot: +(\S+)/, (_, path) => `robot: ${join(root, "models", "scenarios", path)}`);
  const softer = join(folder, "softer.yaml");
  writeFileSync(softer, text.replace(/kp: *([\d.]+)/, (_, kp) => `kp: ${Number(kp) / 4}`));
  const walks = [];
  for (const [name, path] of [["default", scenario], ["softer", softer]]) {
    const walk = await startRun(name, [], path);
    await walk.ended;
    walks.push(walk);
  }
  for (const [logs, name] of [[[walks[0].log], "viewer_log.png"], [walks.map((walk) => walk.log), "viewer_compare.png"]]) {
    const player = await startViewer(logs);
    const shown = await openPage(browser, player.url);
    await waitFor("a robot", async () => (await shown.describe()).robots[0]?.visible);
    for (const part of name === "viewer_log.png" ? ["spring", "friction"] : []) await shown.check(`[data-layer=${part}]`);
    await seek(shown, midStep);
    await shoot(shown, name);
    await player.end();
  }
}
