// SPDX-License-Identifier: BSD-3-Clause
// The page: puts stage, charts and controls together.
import { CameraPanel } from "./cameras.js";
import { Chart } from "./charts.js";
import { ServerConnection } from "./connection.js";
import { listenTo } from "./controls.js";
import { showFall, showNumbers, showRun, showServers } from "./numbers.js";
import { Player } from "./player.js";
import { PoseEditor } from "./pose.js";
import { Pusher } from "./push.js";
import { Recorder, saveAs } from "./recorder.js";
import { chooseCharts, chooseUnit, listSignals } from "./signals.js";
import { SignalDialog } from "./signal_dialog.js";
import { isScan } from "./scans.js";
import { Stage } from "./stage.js";

const $ = (id) => document.getElementById(id);
const drawPeriod = 66;  // [ms] between drawings of the charts

class Page {
  constructor() {
    this.live = false;
    this.control = false;
    this.types = {};
    this.topics = {};
    this.recordings = [];
    this.chosen = [0, -1];
    this.scenes = [null, null];
    this.latest = {};
    this.units = new Map();
    this.charts = [];
    this.epoch = null;
    this.run = null;
    this.stage = new Stage($("scene"), $("scene-note"));
    this.recorder = new Recorder(this.stage);
    this.pose = new PoseEditor(this.stage, () => this.findPose());
    this.pusher = new Pusher(this.stage, (message) => this.connection.send(message), () => this.stepsPerSecond());
    this.player = new Player((time, steps) => this.connection.send({ op: "at", time, steps, sources: this.sources() }));
    this.dialog = new SignalDialog(() => this.findSignals(), (topic) => this.connection.send({ op: "peek", topic }), () => Object.keys(this.topics));
    this.cameras = new CameraPanel(() => this.askPictures());
    listenTo(this);
    this.connection = new ServerConnection((message) => this.take(message), () => this.lose());
    this.lastDraw = 0;
    this.pictures = 0;  // that came
    this.pace = { since: performance.now(), frames: 0 };
    this.lastTick = performance.now();
    requestAnimationFrame((now) => this.tick(now));
  }

  // What charts ask of the page.
  isLive() { return this.live; }
  theme() { return document.documentElement.dataset.theme; }
  compares() { return !this.live && this.chosen[1] >= 0; }
  window() { return Number($("window").value); }
  now() { return this.live ? this.time ?? 0 : this.player.time; }
  span() { return [0, this.player.end]; }
  unit(id) { return this.units.get(id) ?? ""; }
  seek(time) { this.player.playing = false; this.player.seek(time); this.showTransport(); }
  edit(chart) { this.dialog.open(chart, () => this.subscribe()); }

  // The difference of two runs is a chart of its own, below the one it belongs to.
  addDifference(chart) {
    const [added] = this.makeCharts([{ title: chart.title, signals: chart.signals, unit: chart.unit, difference: true }]);
    chart.element.after(added.element);
  }

  remove(chart) {
    chart.element.remove();
    this.charts = this.charts.filter((each) => each !== chart);
    this.subscribe();
  }

  async askSeries(line, range) {
    const source = this.chosen[line.slot];
    const request = { op: "series", source, signal: line.id, points: 2000 };
    if (line.minus) request.minus = this.chosen[1];
    // A little more than is shown, so that lines go on to the edges.
    if (range) Object.assign(request, { begin: range[0] - 0.1 * (range[1] - range[0]), end: range[1] + 0.1 * (range[1] - range[0]) });
    const answer = await this.connection.ask(request);
    if (answer.unit && !this.units.has(line.id)) this.units.set(line.id, this.chooseUnitOf(line.id, answer.unit));
    return answer;
  }

  chooseUnitOf(id, unit) {
    const name = id.match(/\[([^\]]+)\]$/)?.[1];
    return chooseUnit(unit, this.scenes[0]?.joints.find((joint) => joint.name === name));
  }

  sources() { return this.chosen.filter((source) => source >= 0); }

  take(message) {
    const handler = { hello: "takeHello", scene: "takeScene", frame: "takeFrame", frames: "takeFrames", status: "takeStatus",
                      samples: "takeSamples", topics: "takeTopics", picture: "takePicture", error: "takeError" }[message.op];
    if (handler) this[handler](message);
  }

  lose() {
    $("mode").textContent = "connection lost";
    $("mode").dataset.mode = "lost";
  }

  takeHello(message) {
    Object.assign(this, { live: message.live, control: message.control, types: message.types, topics: message.topics, recordings: message.recordings });
    $("mode").textContent = this.live ? "LIVE" : "RECORDED";
    $("mode").dataset.mode = this.live ? "live" : "log";
    $("message").textContent = "";
    $("live-bar").hidden = !this.live;
    $("log-bar").hidden = this.live;
    $("factor-box").hidden = !this.live;
    $("window-box").hidden = !this.live;
    $("servers-box").hidden = !this.live;
    for (const id of ["pause", "resume", "step", "steps", "reset", "speed"]) $(id).disabled = !this.control;
    $("push").hidden = !this.control;
    this.pusher.enabled = this.live && this.control;
    $("read-only").hidden = this.control || !this.live;
    $("late").hidden = true;
    this.latest = {};
    for (const chart of this.charts.splice(0)) chart.element.remove();
    this.scenes = [null, null];
    this.stage.setScene(1, null);
    this.showTopics();
    this.cameras.setSources([{ source: 0, name: "" }]);
    if (!this.live) this.openRecordings();
  }

  // Tells the server which pictures are on the screen.
  askPictures() {
    const scans = $("scan-box").checked && !document.hidden ? Object.keys(this.topics).filter((topic) => isScan(this.topics[topic])) : [];
    this.connection.send({ op: "pictures", topics: [...this.cameras.asked, ...scans.slice(0, 4)] });
  }

  takePicture(message) {
    if (!isScan(this.topics[message.topic] ?? "")) this.cameras.take(message);
    else if (message.source === (this.live ? 0 : this.chosen[0]) && $("scan-box").checked) this.stage.setScan(message);
  }

  showScans() {
    this.stage.clearScans();
    this.askPictures();
  }

  openRecordings() {
    const options = this.recordings.map((recording, i) => new Option(recording.name, i));
    $("run-a").replaceChildren(...options);
    $("run-b").replaceChildren(new Option("nothing", -1), ...options.map((option) => option.cloneNode(true)));
    // Two logs were named to be compared; the recordings of an experiment are many runs of one robot.
    const two = this.recordings.length === 2 && this.recordings.every((recording) => recording.name.endsWith(".mcap"));
    this.choose(0, two ? 1 : -1);
  }

  choose(first, second) {
    this.chosen = [first, second === first ? -1 : second];
    $("run-a").value = this.chosen[0];
    $("run-b").value = this.chosen[1];
    $("ghost-layer").hidden = this.chosen[1] < 0;
    const shown = this.sources().map((source) => this.recordings[source]);
    this.player.reset(Math.max(...shown.map((recording) => recording.end - recording.begin), 0));
    $("scrub").max = this.player.end;
    $("scrub-end").textContent = this.player.end.toFixed(3);
    $("run-name").textContent = shown.map((recording) => recording.name).join("  and, as a ghost, ");
    $("notes").replaceChildren(...shown.flatMap((recording) => recording.notes.map((note) => {
      const item = document.createElement("li");
      item.textContent = `${recording.name}: ${note}`;
      return item;
    })));
    this.cameras.setSources(this.sources().map((source) => ({ source, name: shown.length > 1 ? this.recordings[source].name : "" })));
    this.scenes = [null, null];
    this.stage.setScene(1, null);
    for (const source of this.sources()) this.connection.send({ op: "open", source });
  }

  takeScene({ source, scene }) {
    const slot = this.live ? 0 : this.chosen.indexOf(source);
    if (slot < 0) return;
    this.scenes[slot] = scene;
    this.stage.setScene(slot, scene, source);
    if (slot === 0) {
      this.showLayers();
      if (this.live) $("run-name").textContent = `${scene.name}, ${scene.scenario}`;
      $("feet").hidden = scene.feet.length === 0 && scene.wrenches.length === 0;
      if (this.charts.length === 0) this.makeCharts(chooseCharts(scene, this.topics));
      else for (const chart of this.charts) chart.reset();
    }
    if (!this.live && this.sources().every((_, i) => this.scenes[i])) {
      for (const chart of this.charts.filter((each) => each.difference && !this.compares())) this.remove(chart);
      if (this.compares() && this.charts.length > 0 && !this.charts.some((chart) => chart.difference)) this.addDifference(this.charts[0]);
      for (const chart of this.charts) chart.reset();
      this.player.seek(0);
    }
  }

  // Recordings of real robots have no contact forces: nothing is offered that could not be shown.
  showLayers() {
    const forces = this.live || this.topics["hrp/contact_forces"] !== undefined;
    for (const box of document.querySelectorAll("[data-layer]")) {
      if (box.dataset.layer !== "total" && box.dataset.layer !== "ghost") box.closest("label").hidden = !forces;
    }
    $("zmp-line").hidden = !forces;
    $("feet").classList.toggle("totals", !forces);
  }

  makeCharts(specs) {
    const before = this.charts.length;
    for (const spec of specs) {
      const chart = new Chart(this, $("charts"), spec);
      this.charts.push(chart);
      for (const id of spec.signals) if (!this.units.has(id)) this.units.set(id, spec.unit);
      chart.reset();
    }
    this.subscribe();
    return this.charts.slice(before);
  }

  subscribe() {
    if (this.live) this.connection.send({ op: "subscribe", signals: [...new Set(this.charts.flatMap((chart) => chart.signals))].slice(0, 64) });
  }

  takeTopics({ topics }) {
    this.topics = topics;
    this.showTopics();
    // Foot forces may be offered a moment after the robot.
    if (this.live && this.scenes[0] && !this.charts.some((chart) => chart.title === "Vertical foot forces") && topics["hrp/contact_forces"] && !this.sawForces) {
      this.sawForces = true;
      for (const chart of this.charts.splice(0)) chart.element.remove();
      this.makeCharts(chooseCharts(this.scenes[0], topics));
    }
  }

  showTopics() {
    $("scan-layer").hidden = !Object.values(this.topics).some(isScan);
    this.cameras.setTopics(this.topics);
  }

  takeFrame({ topics }) {
    ++this.pictures;
    this.latest = topics;
    const header = topics["hrp/robot_state"]?.header;
    if (header) {
      if (this.epoch !== null && header.epoch !== this.epoch) for (const chart of this.charts) chart.clear();
      this.epoch = header.epoch;
      this.time = header.time;
    }
    this.stage.setFrame(0, topics);
    showNumbers(topics, this.stage);
    this.dialog.refresh();
  }

  takeFrames({ time, frames }) {
    this.player.took(time);
    frames.forEach((frame, slot) => this.stage.setFrame(slot, frame.topics));
    if (frames[0]) {
      this.latest = frames[0].topics;
      showNumbers(this.latest, this.stage);
      showFall(this.latest["hrp/events"]);
    }
    for (const chart of this.charts) chart.redrawNow();
    this.showTransport();
  }

  takeSamples({ signals }) {
    for (const [id, points] of Object.entries(signals)) {
      if (points.unit && !this.units.has(id)) this.units.set(id, this.chooseUnitOf(id, points.unit));
      for (const chart of this.charts) chart.append(id, points);
    }
    this.samplesCame = true;
  }

  takeStatus({ run, servers, servers_now: current }) {
    if (run) {
      this.run = run;
      showRun(run, this.control);
    }
    showServers(servers, current);
  }

  takeError({ message }) {
    this.say(message);
  }

  say(text) {
    $("message").textContent = text;
    clearTimeout(this.sayTimer);
    this.sayTimer = setTimeout(() => { $("message").textContent = ""; }, 6000);
  }

  showTransport() {
    $("scrub").value = this.player.time;
    $("scrub-time").textContent = this.player.time.toFixed(3);
    $("play").textContent = this.player.playing ? "Pause" : "Play";
    $("play").classList.add("primary");
  }

  // All signals that there are, of all topics of which a sample is known.
  findSignals() {
    const joints = this.scenes[0]?.joints ?? [];
    const robots = (this.scenes[0]?.robots ?? []).map((robot) => robot.name);
    const found = [];
    for (const [topic, sample] of Object.entries(this.latest)) found.push(...listSignals(topic, this.topics[topic] ?? "", sample, this.types, joints, robots));
    for (const signal of found) this.units.set(signal.id, signal.unit);
    return found;
  }

  findPose() {
    const joints = this.scenes[0]?.joints, positions = this.latest["hrp/robot_state"]?.positions;
    return joints && positions ? { joints, positions } : null;
  }

  request(request, more = {}) {
    this.connection.send({ op: "control", request, speed: Number($("speed").value), ...more });
  }

  // Steps of the run in a second of wall clock, at least those of a tenth of real time.
  stepsPerSecond() {
    const { step, time } = this.latest["hrp/robot_state"]?.header ?? {};
    return step > 0 ? (step / time) * Math.max(this.run?.real_time_factor ?? 1, 0.1) : 1000;
  }

  togglePush() {
    this.pusher.always = !this.pusher.always;
    $("push").classList.toggle("primary", this.pusher.always);
    $("push").setAttribute("aria-pressed", this.pusher.always);
  }

  async toggleVideo() {
    if (!this.recorder.isOn) {
      this.recorder.start();
    } else {
      $("record").disabled = true;
      const name = ($("run-name").textContent.match(/[\w-]+/)?.[0] ?? "run") + (this.recorder.kind.includes("mp4") ? ".mp4" : ".webm");
      try {
        saveAs(await this.recorder.stop(), name);
      } catch (error) {
        this.say(`no video: ${error}`);
      }
      $("record").disabled = false;
    }
    $("record").textContent = this.recorder.isOn ? "Stop and save" : "Record video";
    $("record").classList.toggle("primary", this.recorder.isOn);
  }

  addChart() {
    this.makeCharts([{ title: "Chart", signals: [], unit: "" }]);
    const chart = this.charts[this.charts.length - 1];
    chart.element.scrollIntoView({ block: "nearest" });
    this.edit(chart);
  }

  // Pictures drawn per second of wall clock, on the canvas for tests and for those who wonder: data-fps.
  notePace(now) {
    const elapsed = now - this.pace.since;
    if (elapsed < 1000) return;
    const frames = this.stage.frameCount;
    $("scene").dataset.fps = (((frames - this.pace.frames) * 1000) / elapsed).toFixed(1);
    this.pace = { since: now, frames };
  }

  tick(now) {
    if (!this.live) {
      const playing = this.player.playing;
      this.player.advance(Math.min((now - this.lastTick) / 1000, 0.25));
      if (playing !== this.player.playing) this.showTransport();
    }
    this.lastTick = now;
    this.notePace(now);
    if (this.stage.render()) $("arrow-scale").textContent = this.stage.forceScale > 0 ? `1 m of arrow = ${this.stage.forceScale} N` : "";
    if (this.live && this.samplesCame && now - this.lastDraw > drawPeriod) {
      this.lastDraw = now;
      this.samplesCame = false;
      for (const chart of this.charts) chart.draw();
    }
    requestAnimationFrame((next) => this.tick(next));
  }
}

window.hrpViewer = new Page();
