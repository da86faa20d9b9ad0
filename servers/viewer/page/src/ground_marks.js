// SPDX-License-Identifier: BSD-3-Clause
// Support polygon and zero-moment point of one robot, on the ground. World axes, z up, metres.
import * as THREE from "three";

export class GroundMarks {
  constructor(world) {
    this.fill = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.3, side: THREE.DoubleSide, depthWrite: false }));
    this.edge = new THREE.LineLoop(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({}));
    this.zmp = new THREE.Mesh(new THREE.SphereGeometry(1, 20, 12), new THREE.MeshBasicMaterial({}));
    // Marks on the ground are seen through feet: they are what one looks for.
    for (const mark of [this.edge, this.zmp]) {
      mark.material.depthTest = false;
      mark.renderOrder = 2;
    }
    world.add(this.fill, this.edge, this.zmp);
  }

  // `hull`: corners, fewer than three for no polygon; `zmp`: a point or null; `look`: {radius, polygon, zmp}, the sphere's radius
  // and the colours.
  show(hull, zmp, look) {
    this.fill.visible = this.edge.visible = hull.length >= 3;
    if (hull.length >= 3) this.showPolygon(hull, look.polygon);
    this.zmp.visible = zmp !== null;
    if (zmp) this.zmp.position.set(...zmp);
    this.zmp.scale.setScalar(look.radius);
    this.zmp.material.color.set(look.zmp);
  }

  showPolygon(hull, color) {
    // A little above the floor, so that the two do not flicker.
    const points = hull.map(([x, y, z]) => new THREE.Vector3(x, y, z + 0.002));
    const corners = [];
    for (let i = 1; i + 1 < points.length; ++i) corners.push(points[0], points[i], points[i + 1]);
    for (const [mark, list] of [[this.fill, corners], [this.edge, points]]) {
      mark.geometry.dispose();
      mark.geometry = new THREE.BufferGeometry().setFromPoints(list);
      mark.material.color.set(color);
    }
  }
}
