// SPDX-License-Identifier: BSD-3-Clause
// What is around the robots: the ground's grid, obstacles, and objects that move. World axes, z up, metres.
import * as THREE from "three";
import { makeGround } from "./forces.js";

function makeGrid(plane, color) {
  const grid = new THREE.GridHelper(10, 50, color, color);
  grid.material.transparent = true;
  grid.material.opacity = 0.55;
  grid.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...plane.normal));
  grid.position.set(...plane.point);
  return grid;
}

function makeBody({ name, shape, size, position, quaternion: [w, x, y, z], vertices, triangles, color = 0xb09a78 }) {
  const surface = () => {
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(vertices, 3));
    geometry.setIndex(triangles);
    return geometry;
  };
  const shapes = {
    mesh: surface,
    height_field: surface,
    box: () => new THREE.BoxGeometry(...size),
    sphere: () => new THREE.SphereGeometry(size[0], 24, 16),
    cylinder: () => new THREE.CylinderGeometry(size[0], size[0], size[1], 24).rotateX(Math.PI / 2),
  };
  const flat = vertices !== undefined;  // each triangle in one shade: slopes are seen
  const mesh = new THREE.Mesh(shapes[shape](), new THREE.MeshLambertMaterial({ color, flatShading: flat, side: flat ? THREE.DoubleSide : THREE.FrontSide }));
  mesh.name = name;
  mesh.position.set(...position);
  mesh.quaternion.set(x, y, z, w);
  return mesh;
}

export class Surroundings {
  constructor(world) {
    this.group = new THREE.Group();
    this.objects = [];
    world.add(this.group);
  }

  set(scene, gridColor) {
    this.scene = scene;
    this.group.clear();
    this.plane = makeGround(scene.ground);
    this.grid = null;
    this.setGridColor(gridColor);
    for (const obstacle of scene.obstacles) this.group.add(makeBody(obstacle));
    // Where they are stands in each state.
    const placed = { position: [0, 0, 0], quaternion: [1, 0, 0, 0] };
    this.objects = scene.objects.map((object) => makeBody({ ...object, ...placed, color: 0x7fa36b }));
    for (const object of this.objects) {
      object.visible = false;
      this.group.add(object);
    }
  }

  setGridColor(color) {
    if (!this.scene?.ground.present) return;
    if (this.grid) this.group.remove(this.grid);
    this.grid = makeGrid(this.plane, color);
    this.group.add(this.grid);
  }

  // Poses of a state's objects.
  move(states) {
    this.objects.forEach((object, i) => {
      const pose = states?.[i]?.X_WO;
      object.visible = Boolean(pose);
      if (!pose) return;
      const { w, x, y, z } = pose.rotation;
      object.position.set(pose.translation.x, pose.translation.y, pose.translation.z);
      object.quaternion.set(x, y, z, w);
    });
  }
}
