// SPDX-License-Identifier: BSD-3-Clause
// Recordings in the browser: play, scrub, step, compare, charts, experiment folders.
import { writeFileSync, mkdirSync, copyFileSync } from "node:fs";
import { join } from "node:path";
import { check, folder, openPage, readLog, readTable, root, run, startBrowser, startRun, startViewer, sumVertical, waitFor } from "./lib.mjs";

const feet = ["L_ANKLE_R_LINK", "R_ANKLE_R_LINK"];

async function makeLog(name, duration, scenario) {
  const simulation = await startRun(name, ["--duration", duration], scenario);
  check((await simulation.ended) === 0, `the run ${name} was recorded`);
  return simulation.log;
}

async function checkNumbers(page, log) {
  const table = await readTable(page);
  const forces = (await readLog(log, "hrp/contact_forces")).find((message) => Number(message.header.step) === table.step);
  for (const foot of feet) check(table.feet[foot][0] === sumVertical(forces, foot), `step ${table.step}: ${foot} ${table.feet[foot][0]} N as in the log`);
}

const shownTime = (page) => page.evaluate(() => window.hrpViewer.player.time);
const atRest = (page) => waitFor("an answer", () => page.evaluate(() => !window.hrpViewer.player.pending));

async function scrub(page, time) {
  await page.locator("#scrub").fill(String(time));
  await waitFor(`the picture of ${time} s`, async () => Math.abs((await shownTime(page)) - time) < 1e-9);
  await atRest(page);
}

async function checkTransport(page, log) {
  await waitFor("the robot", async () => (await page.describe()).robots[0]?.visible);
  await scrub(page, 0.5);
  await checkNumbers(page, log);
  await page.click("#forward");
  await waitFor("the next step", async () => Math.abs((await shownTime(page)) - 0.501) < 1e-9);
  await page.click("#back");
  await page.click("#back");
  await waitFor("two steps back", async () => Math.abs((await shownTime(page)) - 0.499) < 1e-9);
  check(true, "Step moves by one step of the run, forward and back");
  await atRest(page);
  await page.locator("#scene").focus();
  await page.keyboard.press("Space");
  await waitFor("time to go on", async () => (await shownTime(page)) > 0.52);
  check((await page.text("#play")) === "Pause", "the space bar plays");
  await page.click("#play");
  await waitFor("the button to say Play", async () => (await page.text("#play")) === "Play");  // on a busy machine, a frame later
  check(true, "Pause holds");
  await atRest(page);
  await checkNumbers(page, log);
}

async function checkCharts(page, log) {
  const chart = await waitFor("a chart with points", () => page.evaluate(() => {
    const first = window.hrpViewer.charts[0];
    const data = first?.plot?.data;
    return data && data[0].length > 10 && { times: [...data[0]], values: [...data[1]], axes: first.plot.axes.map((axis) => axis.label), signal: first.signals[0] };
  }));
  check(chart.axes[0] === "time [s]" && chart.axes[1] === "[N]", "axes have units");
  const forces = await readLog(log, "hrp/contact_forces");
  const link = chart.signal.match(/\[(.*?)\]/)[1];
  const byStep = new Map(forces.map((message) => [Number(message.header.step), message]));
  const wrong = chart.times.filter((time, i) => chart.values[i] !== null && chart.values[i] !== undefined &&
    Math.abs(chart.values[i] - Number(byStep.get(Math.round(time * 1000)).pairs.filter((pair) => pair.name_a === link).reduce((sum, pair) => sum + pair.total.force.z, 0))) > 1e-9);
  check(wrong.length === 0, `all ${chart.times.length} points of the force chart are those of the log`);
  await page.keyboard.press("c");
  await page.fill("#signals-filter", "zmp x");
  await page.check('[data-signal="hrp/contact_forces:zmp.x"]');
  await page.keyboard.press("Escape");
  await waitFor("the chart of the ZMP", () => page.evaluate(() => window.hrpViewer.charts.some((each) => each.signals[0] === "hrp/contact_forces:zmp.x" && each.plot?.data[0].length > 10)));
  check((await page.evaluate(() => window.hrpViewer.charts.at(-1).unit)) === "m", "any signal can be charted, with its unit");
}

async function checkComparison(browser, first, second) {
  const viewer = await startViewer([first, second]);
  const page = await openPage(browser, viewer.url);
  await waitFor("robot and ghost", async () => (await page.describe()).robots.every((robot) => robot?.visible));
  check(true, "two runs: the second robot is the ghost");
  const difference = await waitFor("the chart of the difference", () => page.evaluate(() => {
    const chart = window.hrpViewer.charts.find((each) => each.difference);
    return chart?.plot?.data[0].length > 10 && [...chart.plot.data[1]];
  }));
  check(difference.every((value) => value === 0 || value === null || value === undefined), "the difference of equal runs is zero, as a chart of its own");
  check((await page.evaluate(() => window.hrpViewer.charts[0].plot.series.length)) === 5, "the lines of both runs are in one chart");
  check(page.faults.length === 0, `no mistakes in the page ${page.faults.join("; ")}`);
  await viewer.end();
}

// A pendulum whose only joint follows a sine, with a hole in the velocity.
function makeExperiment() {
  const place = join(folder, "experiment");
  mkdirSync(place);
  copyFileSync(join(root, "models", "test_robots", "pendulum.urdf"), join(place, "robot.urdf"));
  writeFileSync(join(place, "experiment.yaml"), "robot: robot.urdf\nbase: fixed\ndrive: effort\nrecordings:\n- {file: swing.csv, role: train}\n- {file: again.csv, role: validate}\n");
  return place;
}

async function checkExperiment(browser, jointName) {
  const place = makeExperiment();
  const rows = Array.from({ length: 200 }, (_, i) => `${i / 100},${Math.sin(i / 20)},${i === 7 ? "" : Math.cos(i / 20)}`);
  for (const file of ["swing.csv", "again.csv"]) {
    writeFileSync(join(place, file), `time,/joint_states/${jointName}/position,/joint_states/${jointName}/velocity\n${rows.join("\n")}\n`);
  }
  const viewer = await startViewer([place]);
  const page = await openPage(browser, viewer.url);
  await waitFor("the robot of the experiment", async () => (await page.describe()).robots[0]?.visible);
  await scrub(page, 1.0);
  const angle = await page.evaluate((name) => window.hrpViewer.stage.robots[0].model.joints[name].angle, jointName);
  check(Math.abs(angle - Math.sin(5)) < 1e-12, "an experiment folder with CSV recordings opens, and its joint moves as recorded");
  await page.selectOption("#run-b", "1");
  await waitFor("the ghost", async () => (await page.describe()).robots[1]?.visible);
  check(page.faults.length === 0, `its recordings can be compared ${page.faults.join("; ")}`);
  await viewer.end();
}

async function checkTerrain(browser) {
  const viewer = await startViewer([await makeLog("terrain", "0.05", join(root, "models/scenarios/terrain.yaml"))]);
  const page = await openPage(browser, viewer.url);
  await waitFor("the robot on the terrain", async () => (await page.describe()).robots[0]?.visible);
  const [waves] = (await page.describe()).obstacles;
  check(waves.name === "waves" && waves.triangles === 2 * 160 * 80, `the height field is drawn from the log: ${waves.triangles} triangles`);
  await scrub(page, 0.04);
  const shown = await waitFor("the ZMP on the terrain", async () => { const seen = await page.describe(); return seen.zmp && seen.polygon.length > 2 && seen; });
  check(Math.abs(shown.zmp[0]) < 0.2 && Math.abs(shown.zmp[1]) < 0.2, `the ZMP lies between the feet: ${shown.zmp}`);
  check(page.faults.length === 0, `terrain makes no mistakes in the page ${page.faults.join("; ")}`);
  await viewer.end();
}

// Other robots of the scenario are drawn where their states say.
async function checkRobots(browser) {
  const log = await makeLog("several", "0.1", join(root, "models/scenarios/several_robots.yaml"));
  const viewer = await startViewer([log]);
  const page = await openPage(browser, viewer.url);
  const others = await waitFor("the other robots", async () => {
    const found = (await page.describe()).others;
    return found.length === 2 && found.every((robot) => robot.visible) && found;
  });
  const states = (await readLog(log, "hrp/robot_state"))[0].robots;
  others.forEach((robot, i) => {
    const { x, y, z } = states[i].X_WB.translation;
    check(robot.links > 20 && Math.hypot(robot.position[0] - x, robot.position[1] - y, robot.position[2] - z) < 1e-3, `${states[i].name} is drawn where it is`);
  });
  await scrub(page, 0.05);
  const marks = await waitFor("the ZMPs of all robots", async () => {
    const seen = await page.describe();
    return seen.otherZmps.length === 2 && seen.otherZmps.every((zmp) => zmp) && seen.otherPolygons.every((hull) => hull.length > 2) && seen;
  });
  marks.otherZmps.forEach((zmp, i) => {
    const { x, y } = states[i].X_WB.translation;
    check(Math.hypot(zmp[0] - x, zmp[1] - y) < 0.3, `the ZMP of ${states[i].name} is below it: ${zmp}`);
  });
  check(page.faults.length === 0, `and nothing went wrong ${page.faults.join("; ")}`);
  await viewer.end();
}

run(async () => {
  const log = await makeLog("first", "1");
  const browser = await startBrowser();
  const viewer = await startViewer([log]);
  const page = await openPage(browser, viewer.url);
  await checkTransport(page, log);
  await checkCharts(page, log);
  await page.click("#theme");
  check((await page.evaluate(() => window.hrpViewer.charts.length)) > 3, "light and dark change nothing else");
  await page.keyboard.press("Escape");
  await page.locator("#scene").focus();
  await page.keyboard.press("r");
  await waitFor("the begin", async () => (await shownTime(page)) === 0);
  await page.keyboard.press("ArrowRight");
  await waitFor("one step", async () => Math.abs((await shownTime(page)) - 0.001) < 1e-9);
  await page.keyboard.press("?");
  check(await page.locator("#help-dialog").isVisible(), "keys: R goes to the begin, the arrow steps, ? helps");
  await page.keyboard.press("Escape");
  const unnamed = await page.evaluate(() => [...document.querySelectorAll("button, input, select")].filter((each) =>
    !each.textContent.trim() && !each.getAttribute("aria-label") && !each.closest("label") && !each.title).length);
  check(unnamed === 0, "every control has a name");
  check(page.faults.length === 0, `no mistakes in the page, nothing fetched from elsewhere ${page.faults.join("; ")}`);
  await viewer.end();
  await checkComparison(browser, log, await makeLog("second", "1"));
  await checkExperiment(browser, "hinge");
  await checkTerrain(browser);
  await checkRobots(browser);
  await browser.close();
});
