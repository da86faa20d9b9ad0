// SPDX-License-Identifier: BSD-3-Clause
// Points of lidars in the picture of the robot. A scan is drawn where its lidar is now: between two scans it moves with it.
import * as THREE from "three";

const pointSize = 3;  // [pixels]

export const isScan = (type) => /\bPointCloud2_?$/.test(type);

export class Scans {
  // `world` holds lidars that are fixed to no link.
  constructor(world) {
    Object.assign(this, { world, shown: new Map() });
  }

  // { topic, bytes } of the server, or { error }; `find` gives the object of a link.
  take({ topic, bytes, error }, lidars, find, color) {
    const lidar = lidars.find(({ name }) => topic.replace(/^(rt)?\//, "") === `${name}/points`);
    this.remove(topic);
    if (error !== undefined || !lidar) return;
    const numbers = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(numbers, 3));
    const points = new THREE.Points(geometry, new THREE.PointsMaterial({ color, size: pointSize, sizeAttenuation: false }));
    const { position, quaternion: [w, x, y, z], link } = lidar;
    points.position.set(...position);
    points.quaternion.set(x, y, z, w);
    points.frustumCulled = false;
    ((link && find(link)) || this.world).add(points);
    this.shown.set(topic, points);
  }

  remove(topic) {
    const points = this.shown.get(topic);
    points?.removeFromParent();
    points?.geometry.dispose();
    points?.material.dispose();
    this.shown.delete(topic);
  }

  clear() {
    for (const topic of [...this.shown.keys()]) this.remove(topic);
  }
}
