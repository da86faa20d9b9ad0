// SPDX-License-Identifier: BSD-3-Clause
// Lets people choose what a chart shows, from all signals that there are.
const mostShown = 400;

export class SignalDialog {
  // `find` gives the signals, `peek` asks for a sample of a topic that is not read yet, `topics` names all topics.
  constructor(find, peek, topics) {
    Object.assign(this, { find, peek, topics, known: 0 });
    this.dialog = document.getElementById("signals-dialog");
    this.filter = document.getElementById("signals-filter");
    this.list = document.getElementById("signals-list");
    this.filter.oninput = () => this.show();
    this.filter.onkeydown = (event) => { if (event.key === "Enter") event.preventDefault(); };
  }

  open(chart, done) {
    this.chart = chart;
    this.done = done;
    this.filter.value = "";
    this.dialog.showModal();
    for (const topic of this.topics()) this.peek(topic);
    this.show();
  }

  // Samples of further topics may have come.
  refresh() {
    if (!this.dialog.open) return;
    if (this.find().length !== this.known) this.show();
  }

  show() {
    const all = this.find();
    this.known = all.length;
    const words = this.filter.value.toLowerCase().split(/\s+/).filter(Boolean);
    const fitting = all.filter((signal) => words.every((word) => `${signal.label} ${signal.id}`.toLowerCase().includes(word)));
    const rows = [];
    let topic = "";
    for (const signal of fitting.slice(0, mostShown)) {
      if (signal.topic !== topic) {
        topic = signal.topic;
        const head = document.createElement("h3");
        head.textContent = topic;
        rows.push(head);
      }
      rows.push(this.makeRow(signal));
    }
    this.list.replaceChildren(...rows);
    const more = fitting.length > mostShown ? `, the first ${mostShown} shown` : "";
    document.getElementById("signals-count").textContent = `${fitting.length} signals${more}; ${this.chart.signals.length} in this chart`;
  }

  makeRow(signal) {
    const row = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = this.chart.signals.includes(signal.id);
    box.dataset.signal = signal.id;
    box.onchange = () => {
      const others = this.chart.signals.filter((id) => id !== signal.id);
      this.chart.setSignals(box.checked ? [...others, signal.id] : others);
      this.done();
      this.show();
    };
    const text = document.createElement("span");
    text.textContent = signal.label;
    const unit = document.createElement("span");
    unit.className = "unit";
    unit.textContent = signal.unit;
    row.append(box, text, unit);
    return row;
  }
}
