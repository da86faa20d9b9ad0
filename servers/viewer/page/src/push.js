// SPDX-License-Identifier: BSD-3-Clause
// Pushing what moves in a live run with the mouse: robots and objects. The force is as long as the drag, on the scale of the
// other arrows.
import * as THREE from "three";
import { isShown } from "./robot.js";

const repeatPeriod = 100;     // [ms] between messages while the button is held
const holdTime = 0.5;         // [s] of wall clock that a push lasts when no message follows

// The link that an object of the model belongs to.
function findLink(object) {
  for (let at = object; at; at = at.parent) if (at.isURDFLink) return at;
  return null;
}

export class Pusher {
  // `send` takes what the server is asked for; `pace` gives the steps of a second of wall clock.
  constructor(stage, send, pace) {
    Object.assign(this, { stage, send, pace, enabled: false, always: false, held: null });
    const listen = (name, handler) => stage.canvas.addEventListener(name, handler, { capture: true });
    listen("pointerdown", (event) => this.take(event));
    listen("pointermove", (event) => this.pull(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) listen(name, () => this.letGo());
  }

  // Where a ray through the pointer meets what moves: {name of the body, link, point in its axes}.
  pick(event) {
    const [hit] = this.aim(event).intersectObjects(this.stage.listMovers(), true).filter(({ object }) => isShown(object));
    const link = hit && (this.stage.surroundings.objects.includes(hit.object) ? hit.object : findLink(hit.object));
    return link ? { name: this.stage.nameBody(link), link, point: link.worldToLocal(hit.point.clone()) } : null;
  }

  aim({ clientX, clientY }) {
    const { left, top, width, height } = this.stage.canvas.getBoundingClientRect();
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2(((clientX - left) / width) * 2 - 1, 1 - ((clientY - top) / height) * 2), this.stage.camera);
    return ray;
  }

  take(event) {
    if (!this.enabled || event.button !== 0 || !(this.always || event.ctrlKey)) return;
    const picked = this.pick(event);
    if (!picked) return;
    event.stopImmediatePropagation();  // the view stays
    event.preventDefault();
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.held = { ...picked, force: new THREE.Vector3() };
    this.timer = setInterval(() => this.tell(), repeatPeriod);
  }

  // In the plane through the held point that faces the camera.
  pull(event) {
    if (!this.held) return;
    event.stopImmediatePropagation();
    const at = this.held.link.localToWorld(this.held.point.clone());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(this.stage.camera.getWorldDirection(new THREE.Vector3()), at);
    const target = this.aim(event).ray.intersectPlane(plane, new THREE.Vector3());
    if (target) this.held.force = target.sub(at).multiplyScalar(this.stage.findForceScale());
    this.stage.setDrag(this.held);
  }

  letGo() {
    if (!this.held) return;
    clearInterval(this.timer);
    this.held.force.set(0, 0, 0);
    this.tell(0);
    this.held = null;
    this.stage.setDrag(null);
  }

  tell(seconds = holdTime) {
    this.send({ op: "push", link: this.held.name, point: this.held.point.toArray(), force: this.held.force.toArray(),
                steps: Math.ceil(seconds * this.pace()) });
  }
}
