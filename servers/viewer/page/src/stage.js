// SPDX-License-Identifier: BSD-3-Clause
// The picture on the left: ground, robots, force arrows, support polygon, ZMP. World axes, z up, metres.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { ArrowPool } from "./arrow.js";
import { calcSupportPolygon, calcZmp, norm, parts, sumFeet, toVector } from "./forces.js";
import { GroundMarks } from "./ground_marks.js";
import { Robot } from "./robot.js";
import { Scans } from "./scans.js";
import { Surroundings } from "./surroundings.js";

// 1, 2 or 5 times a power of ten, not below `value`.
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((factor) => factor * power).find((candidate) => candidate >= value * 0.999);
}

const usualScale = 200;  // [N] for 1 m of arrow, as long as no contact force has set a scale

// A browser without a graphics card draws with the processor: 22.7 pictures a second in the place of 19.0 without smooth
// edges, on two busy cores.
function drawsInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software/i.test(name);
}

export class Stage {
  constructor(canvas, note) {
    this.canvas = canvas;
    this.note = note;
    this.layers = { total: true, spring: false, damper: false, friction: false, points: false, push: true, polygon: true, zmp: true, ghost: true };
    this.robots = [null, null];
    this.others = [];  // other robots of the scenario
    this.scenes = [null, null];
    this.frames = [null, null];
    this.largestForce = 0;  // [N] seen so far: scales the arrows
    this.forceScale = 0;    // [N] that one metre of arrow stands for
    this.feet = [];
    this.zmps = [];   // one a robot, null where nothing presses
    this.marks = [];  // likewise
    this.dirty = true;
    this.frameCount = 0;
    this.world = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 200);
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(2.4, -2.2, 1.5);
    this.addLights();
    this.surroundings = new Surroundings(this.world);
    this.arrows = new ArrowPool(this.world);
    this.scans = new Scans(this.world);
    try {
      this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !drawsInSoftware(), alpha: true });
    } catch (error) {
      note.textContent = "This browser gives no WebGL, so the robot cannot be drawn; charts and numbers work.";
      return;
    }
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 1.5));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.target.set(0, 0, 0.7);
    this.controls.addEventListener("change", () => { this.dirty = true; });
    this.controls.update();
    new ResizeObserver(() => { this.dirty = true; }).observe(canvas.parentElement);
  }

  addLights() {
    this.world.add(new THREE.HemisphereLight(0xffffff, 0x8090a0, 2.2));
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(3, -4, 6);
    this.world.add(sun);
  }

  color(name) {
    return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  }

  // `slot` 0: the robot, 1: the ghost; scene null takes it away.
  setScene(slot, scene, source) {
    this.robots[slot]?.dispose();
    this.robots[slot] = null;
    if (slot === 0) this.setOthers(scene?.robots ?? [], source);
    this.scenes[slot] = scene;
    this.frames[slot] = null;
    this.dirty = true;
    if (slot === 0) {
      this.largestForce = 0;
      this.scans.clear();
    }
    if (!scene) return;
    try {
      const robot = new Robot(scene, source, slot === 1 ? this.color("ghost") : null, () => { this.dirty = true; });
      this.robots[slot] = robot;
      this.world.add(robot.model);
      robot.model.visible = false;  // until its pose is known
    } catch (error) {
      this.note.textContent = `The robot's URDF cannot be drawn: ${error.message}`;
      return;
    }
    if (slot === 0) this.surroundings.set(scene, this.color("grid"));
  }

  setOthers(models, source) {
    this.others.forEach((robot) => robot.dispose());
    this.others = models.map((model) => {
      const robot = new Robot(model, `${source}&robot=${encodeURIComponent(model.name)}`, null, () => { this.dirty = true; });
      robot.model.visible = false;
      this.world.add(robot.model);
      return robot;
    });
  }

  // Messages by topic.
  setFrame(slot, topics) {
    const robot = this.robots[slot];
    const state = topics["hrp/robot_state"];
    if (!robot || !state) return;
    const first = !this.frames[slot];
    this.frames[slot] = topics;
    robot.show(slot === 0 && this.pose ? { ...state, positions: this.pose } : state);
    robot.model.visible = slot === 0 || this.layers.ghost;
    this.dirty = true;
    if (slot === 1) return;
    this.note.textContent = "";
    this.surroundings.move(state.objects);
    this.others.forEach((other, i) => {
      other.model.visible = Boolean(state.robots?.[i]);
      if (state.robots?.[i]) other.show(state.robots[i]);
    });
    this.calcForces(topics);
    if (first) this.lookAtRobot();
  }

  // Points of a lidar.
  setScan(message) {
    this.scans.take(message, this.scenes[0]?.lidars ?? [], (link) => this.robots[0]?.find(link), this.color("scan"));
    this.dirty = true;
  }

  clearScans() {
    this.scans.clear();
    this.dirty = true;
  }

  // Joint positions to draw in the place of those that come; null: no longer.
  setPose(positions) {
    this.pose = positions;
    if (this.frames[0]) this.setFrame(0, this.frames[0]);
  }

  calcForces(topics) {
    const scene = this.scenes[0];
    const contacts = topics["hrp/contact_forces"];
    this.zmps = [];
    if (contacts) {
      this.feet = sumFeet(contacts, [...scene.feet, ...(scene.robots ?? []).flatMap((robot) => robot.feet)]);
      this.zmps = this.listRobots().map((robot) => calcZmp(contacts, this.surroundings.plane, robot));
    } else {
      this.feet = this.readWrenches(topics["hrp/sensor_data"]);
    }
    for (const foot of this.feet) this.largestForce = Math.max(this.largestForce, norm(foot.total) || 0);
  }

  // Recordings without contact forces: what the force sensors felt, turned into world axes, at the sensor.
  readWrenches(sensors) {
    const feet = [];
    for (const wrench of sensors?.wrenches ?? []) {
      const spec = this.scenes[0].wrenches.find((each) => each.name === wrench.name);
      const link = spec && this.robots[0].find(spec.link);
      if (!link) continue;
      const force = new THREE.Vector3(...toVector(wrench.force));
      if (spec.frame !== "world") force.applyQuaternion(link.getWorldQuaternion(new THREE.Quaternion()));
      feet.push({ name: wrench.name, link: spec.link, touching: true, sensor: true, total: force.toArray(),
                  point: link.getWorldPosition(new THREE.Vector3()).toArray() });
    }
    return feet;
  }

  lookAtRobot() {
    if (!this.robots[0] || !this.controls) return;
    const box = this.robots[0].findBox();
    if (box.isEmpty()) return;
    const middle = box.getCenter(new THREE.Vector3());
    const reach = Math.max(box.getSize(new THREE.Vector3()).length() / 2, 0.05);
    const away = new THREE.Vector3(1, -0.75, 0.32).normalize().multiplyScalar(reach * 3.3);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).add(away);
    this.camera.near = reach / 50;
    this.camera.far = reach * 100 + 30;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.reach = reach;
    this.followed = middle.clone();
    this.dirty = true;
  }

  // A robot that walks stays in the picture; the view that people chose stays theirs.
  follow() {
    const base = this.robots[0]?.model.position;
    if (!base || !this.controls) return;
    this.lastBase ??= base.clone();
    const moved = base.clone().sub(this.lastBase);
    moved.z = 0;
    if (moved.length() < (this.reach ?? 1) * 0.25) return;
    this.lastBase.copy(base);
    this.controls.target.add(moved);
    this.camera.position.add(moved);
    this.controls.update();
  }

  drawForces() {
    const reach = this.reach ?? 1;
    const radius = reach * 0.012;
    this.forceScale = this.largestForce > 0 ? roundUp(this.largestForce / (reach * 0.8)) : 0;
    this.arrows.begin();
    this.drawn = [];
    for (const foot of this.forceScale > 0 ? this.feet : []) {
      for (const part of parts) {
        if (!this.layers[part] || !foot.point || !foot[part]) continue;
        this.drawArrow(foot.name, part, foot.point, foot[part], radius, part);
      }
    }
    if (this.layers.points && this.forceScale > 0) this.drawPoints(radius * 0.5);
    if (this.layers.push) this.drawPushes(radius);
    this.arrows.end();
  }

  // [N] that one metre of arrow, or of a drag, stands for.
  findForceScale() {
    return this.forceScale || usualScale;
  }

  drawPoints(radius) {
    const some = parts.some((part) => part !== "total" && this.layers[part]);
    for (const pair of this.frames[0]?.["hrp/contact_forces"]?.pairs ?? []) {
      for (const point of pair.points) {
        const from = toVector(point.p_WC);
        for (const part of some ? parts.filter((each) => this.layers[each]) : ["total"]) {
          this.drawArrow(pair.name_a, `point ${part}`, from, toVector(point[part]), radius, part === "total" ? "point" : part);
        }
      }
    }
  }

  // From outside: of the scenario's pushes and hands, and of people. What is dragged here is shown before it acts.
  drawPushes(radius) {
    const dragged = this.drag ? [{ link: this.drag.name, p_LQ: this.drag.point, force: this.drag.force }] : [];
    const others = (this.frames[0]?.["hrp/robot_state"]?.pushes ?? []).filter(({ link }) => link !== this.drag?.name);
    for (const { link, p_LQ, force } of [...dragged, ...others]) {
      const body = this.findBody(link);
      if (!body) continue;
      const from = body.localToWorld(new THREE.Vector3(...toVector(p_LQ)));
      this.drawArrow(link, "push", from.toArray(), toVector(force), radius, "push");
    }
  }

  // What can be pushed: models of robots, and objects.
  listMovers() {
    return [...[this.robots[0], ...this.others].filter(Boolean).map(({ model }) => model), ...this.surroundings.objects];
  }

  // An object or a link as the run calls it: "crate", "partner/L_ANKLE" of another robot.
  nameBody(body) {
    const i = this.others.findIndex((robot) => robot.find(body.name) === body);
    return i < 0 ? body.name : `${this.scenes[0].robots[i].name}/${body.name}`;
  }

  // The other way round; undefined for a name that nobody has.
  findBody(name) {
    const object = this.surroundings.objects.find((each) => each.name === name);
    if (object) return object;
    const [robot, link] = name.split("/");
    const i = (this.scenes[0]?.robots ?? []).findIndex((other) => link && other.name === robot);
    return i < 0 ? this.robots[0]?.find(name) : this.others[i]?.find(link);
  }

  // What somebody drags: {name, link, point, force}, or null.
  setDrag(drag) {
    this.drag = drag;
    this.dirty = true;
  }

  drawArrow(foot, part, from, force, radius, color) {
    const arrow = this.arrows.next();
    const vector = new THREE.Vector3(...force).divideScalar(this.findForceScale());
    arrow.set(new THREE.Vector3(...from), vector, radius, this.color(color));
    this.drawn.push({ foot, part, force, length: vector.length(), visible: arrow.group.visible });
  }

  drawGroundMarks() {
    const contacts = this.frames[0]?.["hrp/contact_forces"];
    const robots = this.listRobots();
    this.hulls = robots.map((robot) => (this.layers.polygon && contacts ? calcSupportPolygon(contacts, this.surroundings.plane, robot) : []));
    while (this.marks.length < robots.length) this.marks.push(new GroundMarks(this.world));
    const look = { radius: (this.reach ?? 1) * 0.016, polygon: this.color("polygon"), zmp: this.color("zmp") };
    this.marks.forEach((marks, i) => marks.show(this.hulls[i] ?? [], this.layers.zmp ? this.zmps[i] ?? null : null, look));
  }

  // Names of the robots of the scene; the first one has none.
  listRobots() {
    return ["", ...(this.scenes[0]?.robots ?? []).map((robot) => robot.name)];
  }

  // Draws when something has changed.
  render() {
    if (!this.dirty || !this.renderer) return false;
    this.dirty = false;
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement;
    const size = this.renderer.getSize(new THREE.Vector2());
    if (size.x !== width || size.y !== height) {
      this.renderer.setSize(width, height, false);
      this.camera.aspect = width / Math.max(height, 1);
      // The table of numbers covers the lower edge: the middle of the picture is a little above.
      this.camera.setViewOffset(width, height, 0, 55, width, height);
      this.camera.updateProjectionMatrix();
    }
    this.follow();
    if (this.robots[1]) this.robots[1].model.visible = this.frames[1] !== null && this.layers.ghost;
    this.drawForces();
    this.drawGroundMarks();
    this.renderer.render(this.world, this.camera);
    ++this.frameCount;
    return true;
  }

  // The page's colours lie behind the canvas, which is clear; a video has only the canvas.
  setBackdrop(on) {
    const style = getComputedStyle(document.documentElement);
    this.world.background = on ? new THREE.Color(style.getPropertyValue("--stage-top").trim()) : null;
    this.dirty = true;
  }

  setTheme() {
    if (this.world.background) this.setBackdrop(true);
    this.surroundings.setGridColor(this.color("grid"));
    this.dirty = true;
  }

  // For tests and for people with a console: what is in the picture.
  describe() {
    return {
      robots: this.robots.map((robot) => robot && { visible: robot.model.visible, links: Object.keys(robot.model.links).length,
                                                     joints: Object.keys(robot.model.joints).length, position: robot.model.position.toArray(),
                                                     missing: [...robot.missing] }),
      others: this.others.map((robot) => ({ visible: robot.model.visible, links: Object.keys(robot.model.links).length,
                                            position: robot.model.position.toArray() })),
      arrows: this.drawn ?? [],
      forceScale: this.forceScale,
      obstacles: (this.surroundings.scene?.obstacles ?? []).map(({ name, shape, triangles }) => ({ name, shape, triangles: (triangles?.length ?? 0) / 3 })),
      polygon: this.hulls?.[0] ?? [],
      zmp: this.zmps[0] ?? null,
      otherPolygons: (this.hulls ?? []).slice(1),
      otherZmps: this.zmps.slice(1),
      frames: this.frameCount,
    };
  }
}
