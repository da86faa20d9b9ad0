// SPDX-License-Identifier: BSD-3-Clause
// A pose to start from: people move the joints of the robot that is drawn and take the keys for a scenario. No run is touched.
const decimals = 4;

export class PoseEditor {
  // `stage` draws the pose; `find` gives the joints of the robot and their positions in the picture, null without a robot.
  constructor(stage, find) {
    Object.assign(this, { stage, find });
    this.box = document.getElementById("pose-box");
    this.rows = document.getElementById("pose-joints");
    this.text = document.getElementById("pose-text");
    this.box.ontoggle = () => (this.box.open ? this.open() : this.close());
    document.getElementById("pose-take").onclick = () => this.open();
    document.getElementById("pose-zero").onclick = () => this.open(() => 0);
  }

  // From the picture, or from what `choose` says of each joint.
  open(choose) {
    const shown = this.find();
    if (!shown) return;
    this.joints = shown.joints;
    this.positions = shown.joints.map((joint, i) => clamp(joint, choose ? choose(joint) : shown.positions[i]));
    this.rows.replaceChildren(...this.joints.map((joint, i) => this.makeRow(joint, i)));
    this.show();
  }

  close() {
    this.rows.replaceChildren();
    this.stage.setPose(null);
  }

  makeRow(joint, i) {
    const row = document.createElement("label");
    row.className = "row";
    const [lower, upper] = findRange(joint);
    const slider = Object.assign(document.createElement("input"), { type: "range", min: lower, max: upper, step: "any", value: this.positions[i] });
    const number = Object.assign(document.createElement("b"), { textContent: this.positions[i].toFixed(decimals) });
    slider.setAttribute("aria-label", `${joint.name} [${joint.unit}]`);
    slider.dataset.joint = joint.name;
    slider.oninput = () => {
      this.positions[i] = Number(slider.value);
      number.textContent = this.positions[i].toFixed(decimals);
      this.show();
    };
    row.append(Object.assign(document.createElement("span"), { textContent: joint.name }), slider, number, joint.unit);
    return row;
  }

  show() {
    this.stage.setPose(this.positions);
    const lines = this.joints.map((joint, i) => [joint.name, Number(this.positions[i].toFixed(decimals))]).filter(([, position]) => position !== 0);
    this.text.value = `initial:\n  joints:${lines.length ? "" : " {}"}\n` + lines.map(([name, position]) => `    ${name}: ${position}\n`).join("");
  }
}

// Joints without limits turn once, or slide by a metre.
function findRange(joint) {
  const most = joint.unit === "m" ? 1 : Math.PI;
  return [Number.isFinite(joint.lower) ? joint.lower : -most, Number.isFinite(joint.upper) ? joint.upper : most];
}

function clamp(joint, position) {
  const [lower, upper] = findRange(joint);
  return Math.min(Math.max(Number.isFinite(position) ? position : 0, lower), upper);
}
