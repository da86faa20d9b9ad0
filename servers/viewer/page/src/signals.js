// SPDX-License-Identifier: BSD-3-Clause
// Which signals there are: every number of every message, found in a sample and in its type. Names as the server reads
// them: "hrp/robot_state:positions[L_KNEE]".

// "rad or m" is the one or the other by the kind of joint.
export function chooseUnit(unit, joint) {
  const choices = unit.split(" or ");
  return choices.length === 2 && joint ? choices[joint.unit === "m" ? 1 : 0] : unit;
}

const nameOf = (element) => element?.name ?? element?.name_a;

// Types whose lists of numbers have one per joint.
const jointTypes = ["hrp::msg::RobotState", "hrp::msg::SensorData", "hrp::msg::JointCommands"];

class Lister {
  constructor(topic, typeName, types, joints) {
    Object.assign(this, { topic, types, joints: jointTypes.includes(typeName) ? joints : [], found: [] });
  }

  add(path, label, unit) {
    this.found.push({ id: `${this.topic}:${path}`, topic: this.topic, label, unit });
  }

  list(typeName, value, path, label) {
    for (const field of this.types[typeName] ?? []) {
      const at = path ? `${path}.${field.name}` : field.name;
      const said = label ? `${label} ${field.name}` : field.name;
      const inner = value?.[field.name];
      if (inner === undefined || field.type === "string" || field.name === "header") continue;
      if (field.list) this.listElements(field, inner, at, said);
      else if (this.types[field.type]) this.list(field.type, inner, at, said);
      else this.add(at, said, field.unit);
    }
  }

  listElements(field, elements, path, label) {
    if (!this.types[field.type]) {
      const byJoint = elements.length > 0 && elements.length === this.joints.length;
      elements.forEach((_, i) => {
        const joint = byJoint ? this.joints[i] : null;
        const what = label.replace(/s$/, "");
        this.add(`${path}[${joint ? joint.name : i}]`, joint ? `${joint.name} ${what}` : `${label} ${i}`, chooseUnit(field.unit, joint));
      });
      return;
    }
    const seen = new Set();
    elements.forEach((element, i) => {
      const name = nameOf(element);
      const key = name && !/^\d+$/.test(name) ? name : i;
      if (seen.has(key)) return;
      seen.add(key);
      this.list(field.type, element, `${path}[${key}]`, name ? name : `${label} ${i}`);
    });
  }
}

export function listSignals(topic, typeName, sample, types, joints, robots = []) {
  const lister = new Lister(topic, typeName, types, joints);
  if (typeName === "hrp::msg::ContactForces") {
    for (const robot of ["", ...robots]) {
      lister.add(robot ? `${robot}/zmp.x` : "zmp.x", robot ? `${robot} ZMP x` : "ZMP x", "m");
      lister.add(robot ? `${robot}/zmp.y` : "zmp.y", robot ? `${robot} ZMP y` : "ZMP y", "m");
    }
  }
  lister.list(typeName, sample, "", "");
  return lister.found;
}

// The name of a signal for legends: "R_KNEE position", "L_FOOT total force z".
export function makeLabel(id) {
  const path = id.slice(id.indexOf(":") + 1);
  const named = path.match(/^(\w+)\[([^\]]+)\]\.?(.*)$/);
  if (!named) return path.replace(/[._/]/g, " ").replace("zmp", "ZMP");
  const [, field, name, rest] = named;
  return rest ? `${name} ${rest.replace(/[._]/g, " ")}` : `${name} ${field.replace(/s$/, "")}`;
}

// The charts that a run opens with: foot forces, and positions and efforts of some joints.
export function chooseCharts(scene, topics) {
  const charts = [];
  if (topics["hrp/contact_forces"] && scene.feet.length > 0) {
    charts.push({ title: "Vertical foot forces", signals: scene.feet.map((foot) => `hrp/contact_forces:pairs[${foot.link}].total.force.z`), unit: "N" });
  } else if (topics["hrp/sensor_data"] && scene.wrenches.length > 0) {
    charts.push({ title: "Force sensors, z", signals: scene.wrenches.map((sensor) => `hrp/sensor_data:wrenches[${sensor.name}].force.z`), unit: "N" });
  }
  const knees = scene.joints.filter((joint) => /knee/i.test(joint.name));
  const chosen = (knees.length > 0 ? knees : scene.joints).slice(0, 4);
  const sources = topics["hrp/robot_state"] ? "hrp/robot_state" : "hrp/sensor_data";
  if (chosen.length > 0) {
    charts.push({ title: "Joint positions", signals: chosen.map((joint) => `${sources}:positions[${joint.name}]`), unit: chosen[0].unit });
    charts.push({ title: "Joint efforts", signals: chosen.map((joint) => `${sources}:efforts[${joint.name}]`), unit: chosen[0].effortUnit });
  }
  if (charts.length === 0) {
    for (const axis of ["x", "y", "z"]) charts.push({ title: `Base position ${axis}`, signals: [`${sources}:X_WB.translation.${axis}`], unit: "m" });
  }
  return charts;
}
