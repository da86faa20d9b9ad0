// SPDX-License-Identifier: BSD-3-Clause
// Charts of signals over simulated time: of a live run they scroll, of recordings they show the whole and zoom.
import uPlot from "uplot";
import { makeLabel } from "./signals.js";

const palettes = {
  light: ["#0b5cad", "#c2410c", "#15803d", "#9333ea", "#b91c61", "#0f766e", "#854d0e", "#475569"],
  dark: ["#6db3ff", "#ff9f6b", "#7ddc9a", "#c9a5ff", "#ff8fbd", "#5fd6cb", "#ffd166", "#b6c2d2"],
};
const chartHeight = 150;
const mostLivePoints = 20000;  // of one signal, as a bound of memory
const widestLive = 60;         // [s] that live charts remember

// Numbers of axes, without a tail of nines.
const formatTick = (value) => String(+value.toPrecision(6));
export const formatValue = (value) => (value === null || value === undefined || Number.isNaN(value) ? "–" : value.toPrecision(5));

// What stands still shall look so: a chart shows no less than a thousandth of its values, whose ticks six digits can tell
// apart.
function findHeight(low, high) {
  if (low === null || high === null) return [0, 1];
  const least = 1e-3 * Math.max(Math.abs(low), Math.abs(high)) || 1e-6;
  const more = Math.max(0, least - (high - low)) / 2;
  return uPlot.rangeNum(low - more, high + more, 0.1, true);
}

// Lines have points at different times: the one before counts until the next, at the very begin the first one.
function findBefore(values, index) {
  for (let i = index ?? -1; i >= 0 && i > index - 100; --i) if (Number.isFinite(values[i])) return values[i];
  for (let i = 0; i < 10; ++i) if ((index ?? -1) >= 0 && index < 10 && Number.isFinite(values[i])) return values[i];
  return null;
}

// Points of one signal of a live run.
class LiveTrace {
  constructor() {
    this.times = [];
    this.values = [];
  }

  append(times, values) {
    // Time that goes back is a reset that came without a word.
    if (this.times.length > 0 && times[0] < this.times[this.times.length - 1]) this.clear();
    for (let i = 0; i < times.length; ++i) {
      this.times.push(times[i]);
      this.values.push(values[i]);
    }
    const end = this.times[this.times.length - 1];
    let drop = Math.max(0, this.times.length - mostLivePoints);
    while (this.times[drop] < end - widestLive) ++drop;
    // In large bites: cutting an array at its front costs its length.
    if (drop > 500) {
      this.times.splice(0, drop);
      this.values.splice(0, drop);
    }
  }

  clear() {
    this.times = [];
    this.values = [];
  }

  // From `begin` on, one point before it included.
  since(begin) {
    let at = this.times.length;
    while (at > 0 && this.times[at - 1] >= begin) --at;
    at = Math.max(0, at - 1);
    return [this.times.slice(at), this.values.slice(at)];
  }
}

// `host` is what a chart needs of the page: isLive(), theme(), now(), window(), units(id), askSeries(...), seek(t), edit(chart),
// remove(chart), compares().
export class Chart {
  constructor(host, parent, spec) {
    Object.assign(this, { host, title: spec.title, unit: spec.unit, signals: spec.signals.slice(), difference: spec.difference ?? false });
    this.traces = new Map();
    this.range = null;    // zoom of a recording
    this.tables = [];     // of recordings: one [times, values] per line
    this.problem = "";
    this.request = 0;
    this.build(parent);
  }

  build(parent) {
    this.element = document.createElement("section");
    this.element.className = "chart";
    this.element.setAttribute("aria-label", this.title);
    this.element.innerHTML = `<div class="title"><span class="name"></span>
      <button class="difference" title="a chart of its own: first run minus second" hidden>+ difference</button>
      <button class="edit" title="choose what this chart shows">signals</button>
      <button class="remove" title="take this chart away" aria-label="remove chart">✕</button></div>
      <div class="plot"></div><p class="problem" role="alert"></p>`;
    parent.append(this.element);
    if (this.difference) this.element.dataset.difference = "yes";
    this.plotElement = this.element.querySelector(".plot");
    this.element.querySelector(".edit").onclick = () => this.host.edit(this);
    this.element.querySelector(".remove").onclick = () => this.host.remove(this);
    this.element.querySelector(".difference").onclick = () => this.host.addDifference(this);
  }

  setSignals(signals) {
    this.signals = signals;
    this.title = "Chart";
    this.reset();
  }

  // After a change of signals, theme, recordings: begins anew.
  reset() {
    this.plot?.destroy();
    this.plot = null;
    this.tables = [];
    this.problem = "";
    for (const id of [...this.traces.keys()]) if (!this.signals.includes(id)) this.traces.delete(id);
    this.element.querySelector(".difference").hidden = !this.host.compares() || this.difference;
    this.showTitle();
    if (this.host.isLive()) this.draw();
    else this.load();
  }

  units() {
    return [...new Set(this.signals.map((id) => this.host.unit(id)).filter(Boolean))];
  }

  showTitle() {
    const units = this.units();
    this.unit = units.length > 0 ? units.join(", ") : this.unit ?? "";
    const names = this.signals.map(makeLabel).join(", ");
    const what = this.title === "Chart" ? names || "nothing chosen yet" : this.title;
    const title = this.difference ? `Difference, first − second: ${what}` : what;
    this.element.querySelector(".name").textContent = `${title}${this.unit ? ` [${this.unit}]` : ""}`;
    this.element.querySelector(".name").title = names;
    this.element.querySelector(".problem").textContent = this.problem;
  }

  // Lines of the plot: label, colour, dashes.
  lines() {
    const colors = palettes[this.host.theme()];
    const lines = [];
    this.signals.forEach((id, i) => {
      const color = colors[i % colors.length];
      const label = makeLabel(id);
      if (this.difference) {
        lines.push({ id, label: `Δ ${label}`, color, minus: 1, slot: 0 });
        return;
      }
      lines.push({ id, label, color, slot: 0 });
      if (this.host.compares()) lines.push({ id, label: `${label} (2nd)`, color, dash: [6, 4], slot: 1 });
    });
    return lines;
  }

  makePlot() {
    const style = getComputedStyle(document.documentElement);
    const text = style.getPropertyValue("--muted").trim();
    const grid = { stroke: style.getPropertyValue("--line").trim(), width: 1 };
    const axis = { stroke: text, grid, ticks: grid, font: "11px system-ui, sans-serif", labelFont: "11px system-ui, sans-serif", labelSize: 16, labelGap: 0 };
    const series = this.lines().map((line) => ({
      label: line.label, stroke: line.color, width: 1.5, dash: line.dash, spanGaps: this.host.isLive() === false,
      points: { show: false }, value: (plot, value, line, index) => formatValue(value ?? findBefore(plot.data[line], index)),
    }));
    const options = {
      width: this.plotElement.clientWidth || 400,
      height: chartHeight,
      scales: { x: { time: false, range: (plot, low, high) => this.findRange(low, high) }, y: { range: (plot, low, high) => findHeight(low, high) } },
      axes: [{ ...axis, label: "time [s]", size: 30, values: (_, ticks) => ticks.map(formatTick) },
             { ...axis, label: this.unit ? `[${this.unit}]` : "value", size: 58, values: (_, ticks) => ticks.map(formatTick) }],
      series: [{ label: "t", value: (_, value) => (value === null || value === undefined ? "–" : `${value.toFixed(3)} s`) }, ...series],
      legend: { live: true },
      cursor: { drag: { x: !this.host.isLive(), y: false, setScale: false } },
      hooks: {
        draw: [(plot) => this.drawNow(plot)],
        setSelect: [(plot) => this.zoom(plot)],
      },
    };
    this.plot = new uPlot(options, this.emptyData(), this.plotElement);
    this.plot.over.addEventListener("dblclick", () => this.zoomOut());
    this.plot.over.addEventListener("click", (event) => {
      // A click without a drag goes to that time.
      if (!this.host.isLive() && event.detail === 1 && !this.selecting) this.host.seek(this.plot.posToVal(event.offsetX, "x"));
      this.selecting = false;
    });
    new ResizeObserver(() => this.plot?.setSize({ width: this.plotElement.clientWidth, height: chartHeight })).observe(this.plotElement);
  }

  emptyData() {
    return [[], ...this.lines().map(() => [])];
  }

  findRange(low, high) {
    if (this.host.isLive()) {
      const end = Math.max(this.host.now(), 0);
      return [Math.max(0, end - this.host.window()), Math.max(end, this.host.window())];
    }
    const [begin, end] = this.range ?? this.host.span();
    return end > begin ? [begin, end] : [begin, begin + 1];
  }

  // A line at the time that the picture shows.
  drawNow(plot) {
    if (this.host.isLive()) return;
    const x = Math.round(plot.valToPos(this.host.now(), "x", true));
    const { left, top, width, height } = plot.bbox;
    if (x < left || x > left + width) return;
    plot.ctx.save();
    plot.ctx.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--accent").trim();
    plot.ctx.lineWidth = 2;
    plot.ctx.setLineDash([]);
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  zoom(plot) {
    if (plot.select.width < 3 || this.host.isLive()) return;
    this.selecting = true;
    this.range = [plot.posToVal(plot.select.left, "x"), plot.posToVal(plot.select.left + plot.select.width, "x")];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.load();
  }

  zoomOut() {
    if (!this.range) return;
    this.range = null;
    this.load();
  }

  // Asks for the lines of recordings, as many points as the chart is wide.
  async load() {
    const request = ++this.request;
    const answers = await Promise.all(this.lines().map((line) => this.host.askSeries(line, this.range)));
    if (request !== this.request) return;
    this.problem = [...new Set(answers.map((answer) => answer.error).filter(Boolean))].join("; ");
    this.tables = answers.map((answer) => [answer.times ?? [], answer.values ?? []]);
    this.showTitle();
    this.draw();
  }

  append(id, { times, values, error }) {
    if (!this.signals.includes(id)) return;
    if (error) {
      this.problem = error;
      this.showTitle();
      return;
    }
    if (!this.traces.has(id)) this.traces.set(id, new LiveTrace());
    this.traces.get(id).append(times, values);
  }

  clear() {
    this.traces.clear();
  }

  draw() {
    if (!this.plot) this.makePlot();
    if (this.signals.length === 0) return;
    const begin = this.host.now() - this.host.window();
    const tables = this.host.isLive() ? this.signals.map((id) => this.traces.get(id)?.since(begin) ?? [[], []]) : this.tables;
    if (tables.length === 0 || tables.every(([times]) => times.length === 0)) {
      this.plot.setData(this.emptyData());
      return;
    }
    // Lines of one topic share their times; joining is for those that do not.
    const same = tables.every(([times]) => times.length === tables[0][0].length && times[0] === tables[0][0][0] && times[times.length - 1] === tables[0][0][tables[0][0].length - 1]);
    this.plot.setData(same && this.host.isLive() ? [tables[0][0], ...tables.map(([, values]) => values)] : uPlot.join(tables));
    this.showValues();
  }

  // Only the line of the present time has moved.
  redrawNow() {
    this.plot?.redraw(false, false);
    this.showValues();
  }

  // The legend has the values of the present time, as long as no cursor asks for another one.
  showValues() {
    const times = this.plot?.data[0];
    if (!times || times.length === 0 || this.plot.cursor.left >= 0) return;
    this.plot.setLegend({ idx: this.host.isLive() ? times.length - 1 : this.plot.valToIdx(this.host.now()) });
  }
}
