// SPDX-License-Identifier: BSD-3-Clause
// Arrows that stay visible: a shaft and a head with a thickness that fits the robot.
import * as THREE from "three";

const up = new THREE.Vector3(0, 1, 0);
const shaftShape = new THREE.CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0);
const headShape = new THREE.ConeGeometry(1, 1, 16).translate(0, 0.5, 0);

export class Arrow {
  constructor() {
    this.group = new THREE.Group();
    // Seen through the robot: a force that starts under a foot would hide in its leg.
    this.material = new THREE.MeshLambertMaterial({ emissiveIntensity: 0.6, depthTest: false, transparent: true, opacity: 0.9 });
    this.shaft = new THREE.Mesh(shaftShape, this.material);
    this.head = new THREE.Mesh(headShape, this.material);
    this.shaft.renderOrder = this.head.renderOrder = 3;
    this.group.add(this.shaft, this.head);
    this.group.visible = false;
  }

  // `from` and `vector` [m] in world axes; `radius` [m] of the shaft.
  set(from, vector, radius, color) {
    const length = vector.length();
    const visible = length > radius * 0.5 && Number.isFinite(length);
    this.group.visible = visible;
    if (!visible) return;
    this.material.color.set(color);
    this.material.emissive.set(color);
    const head = Math.min(radius * 5, length * 0.5);
    this.group.position.copy(from);
    this.group.quaternion.setFromUnitVectors(up, vector.clone().divideScalar(length));
    this.shaft.scale.set(radius, length - head, radius);
    this.head.position.set(0, length - head, 0);
    this.head.scale.set(radius * 2.4, head, radius * 2.4);
  }

  hide() {
    this.group.visible = false;
  }
}

// As many arrows as are asked for; those that nobody asked for since begin() are hidden.
export class ArrowPool {
  constructor(parent) {
    this.parent = parent;
    this.arrows = [];
    this.used = 0;
  }

  begin() {
    this.used = 0;
  }

  next() {
    if (this.used === this.arrows.length) {
      const arrow = new Arrow();
      this.arrows.push(arrow);
      this.parent.add(arrow.group);
    }
    return this.arrows[this.used++];
  }

  end() {
    for (let i = this.used; i < this.arrows.length; ++i) this.arrows[i].hide();
  }
}
