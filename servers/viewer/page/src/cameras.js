// SPDX-License-Identifier: BSD-3-Clause
// The panel with the pictures of cameras. Only what is on the screen is asked for: a closed panel and a page in the background
// cost nothing.
import { chooseRange, paintColor, paintDepth } from "./depth.js";

const $ = (id) => document.getElementById(id);
const mostShown = 8;                      // the server takes no more
const ranges = [1, 2, 5, 10, 20, 50];     // [m]
const isImage = (type) => /\bImage_?$/.test(type);

// "rt/head/depth/image_raw" -> "head depth".
const makeName = (topic) => topic.replace(/^(rt)?\//, "").replace(/\/image(_raw)?$/, "").replaceAll("/", " ");

// One picture with its time, and a scale where it shows depth.
class CameraView {
  constructor(topic, run) {
    this.title = makeName(topic) + (run ? `, ${run}` : "");
    this.element = document.createElement("figure");
    this.element.className = "camera";
    this.element.innerHTML = `<figcaption></figcaption><canvas class="picture" role="img" hidden></canvas>
      <div class="depth" hidden><canvas class="scale" width="256" height="1"></canvas><div class="ticks"></div>
      <label>up to <select class="range"><option value="0">automatic</option></select></label> <span class="reading"></span></div>
      <p class="problem" role="alert"></p>`;
    const find = (selector) => this.element.querySelector(selector);
    Object.assign(this, { caption: find("figcaption"), canvas: find(".picture"), depth: find(".depth"), scale: find(".scale"),
                          ticks: find(".ticks"), range: find(".range"), reading: find(".reading"), problem: find(".problem") });
    this.range.append(...ranges.map((range) => new Option(`${range} m`, range)));
    this.range.onchange = () => this.draw();
    this.canvas.onmousemove = (event) => this.read(event);
    this.canvas.onmouseleave = () => { this.pointed = null; this.showReading(); };
    this.canvas.setAttribute("aria-label", `picture of ${this.title}`);
    this.caption.textContent = `${this.title}: waiting for a picture`;
  }

  take(message) {
    this.message = message;
    this.problem.textContent = message.error ?? "";
    this.canvas.hidden = message.error !== undefined;
    if (message.error === undefined) return this.draw();
    this.caption.textContent = this.title;
    this.depth.hidden = true;
    delete this.canvas.dataset.time;
  }

  draw() {
    const { width, height, kind, time, bytes, stride } = this.message;
    Object.assign(this.canvas, { width, height });
    const context = this.canvas.getContext("2d", { willReadFrequently: true });
    const image = context.createImageData(width, height);
    this.depths = kind === "depth" ? new Float32Array(bytes.buffer, bytes.byteOffset, width * height) : null;
    this.depth.hidden = !this.depths;
    if (this.depths) this.paintDepth(image);
    else paintColor(bytes, image.data);
    context.putImageData(image, 0, 0);
    this.caption.textContent = `${this.title}, ${time.toFixed(3)} s` + (stride > 1 ? `, 1 pixel of ${stride * stride}` : "");
    this.canvas.dataset.time = time;
  }

  paintDepth(image) {
    const range = Number(this.range.value) || chooseRange(this.depths);
    paintDepth(this.depths, range, image.data);
    this.showReading();
    if (range === this.shownRange) return;
    this.shownRange = range;
    this.canvas.dataset.range = range;
    this.ticks.replaceChildren(...[0, 0.25, 0.5, 0.75, 1].map((share) => {
      const tick = document.createElement("span");
      tick.textContent = `${+(share * range).toPrecision(3)}${share === 1 ? " m" : ""}`;
      return tick;
    }));
    const scale = this.scale.getContext("2d").createImageData(256, 1);
    paintDepth(Float32Array.from({ length: 256 }, (_, i) => i), 255, scale.data);
    this.scale.getContext("2d").putImageData(scale, 0, 0);
  }

  read(event) {
    const x = Math.floor((event.offsetX / this.canvas.clientWidth) * this.canvas.width);
    const y = Math.floor((event.offsetY / this.canvas.clientHeight) * this.canvas.height);
    this.pointed = { x: Math.min(Math.max(x, 0), this.canvas.width - 1), y: Math.min(Math.max(y, 0), this.canvas.height - 1) };
    this.showReading();
  }

  showReading() {
    if (!this.depths || !this.pointed) {
      this.reading.textContent = "";
      return;
    }
    const depth = this.depths[this.pointed.y * this.canvas.width + this.pointed.x];
    this.reading.textContent = Number.isFinite(depth) ? `${depth.toFixed(3)} m under the pointer` : "out of range";
  }
}

export class CameraPanel {
  // `ask` tells the server that other topics are on the screen: those in `asked`.
  constructor(ask) {
    Object.assign(this, { ask, topics: [], chosen: new Set(), views: new Map(), sources: [], asked: [] });
    this.box = $("cameras-box");
    this.box.ontoggle = () => this.update();
    document.addEventListener("visibilitychange", () => this.update(true));
  }

  // Topics by name with their types. The first camera is chosen, others by people.
  setTopics(topics) {
    const found = Object.keys(topics).filter((topic) => isImage(topics[topic])).sort((a, b) => makeName(a).localeCompare(makeName(b)));
    if (found.join() === this.topics.join()) return;
    this.topics = found;
    this.box.hidden = found.length === 0;
    if (found.length > 0 && !found.some((topic) => this.chosen.has(topic))) this.chosen.add(found.find((topic) => !topic.includes("depth")) ?? found[0]);
    this.showList();
    this.update();
  }

  // [{ source, name }]: what is shown side by side. Begins anew.
  setSources(sources) {
    this.sources = sources;
    for (const view of this.views.values()) view.element.remove();
    this.views.clear();
    this.update(true);
  }

  showList() {
    $("cameras-list").replaceChildren(...this.topics.map((topic) => {
      const label = document.createElement("label");
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: this.chosen.has(topic) });
      box.dataset.camera = topic;
      box.disabled = !box.checked && this.findShown().length >= mostShown;
      box.onchange = () => {
        if (box.checked) this.chosen.add(topic);
        else this.chosen.delete(topic);
        this.showList();
        this.update();
      };
      label.append(box, ` ${makeName(topic)}`);
      return label;
    }));
  }

  findShown() { return this.topics.filter((topic) => this.chosen.has(topic)).slice(0, mostShown); }

  update(anew = false) {
    const shown = this.box.open && !this.box.hidden && !document.hidden ? this.findShown() : [];
    if (this.box.open && !document.hidden) this.arrange(shown);
    if (!anew && this.asked.join() === shown.join()) return;
    this.asked = shown;
    this.ask();
  }

  arrange(shown) {
    const views = new Map();
    for (const topic of shown) {
      for (const { source, name } of this.sources) {
        const key = `${source} ${topic}`;
        views.set(key, this.views.get(key) ?? new CameraView(topic, name));
      }
    }
    this.views = views;
    $("cameras-views").replaceChildren(...[...views.values()].map((view) => view.element));
  }

  take(message) { this.views.get(`${message.source} ${message.topic}`)?.take(message); }
}
