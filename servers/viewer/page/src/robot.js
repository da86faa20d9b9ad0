// SPDX-License-Identifier: BSD-3-Clause
// A robot from its URDF: meshes where they can be had, else the primitives of its collision geometry, else rods from
// joint to joint.
import * as THREE from "three";
import URDFLoader from "urdf-loader";
import { ColladaLoader } from "three/examples/jsm/loaders/ColladaLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { toNumber } from "./forces.js";

function readMesh(name, data) {
  if (/\.stl$/i.test(name)) return new THREE.Mesh(new STLLoader().parse(data));
  const text = new TextDecoder().decode(data);
  if (/\.obj$/i.test(name)) return new OBJLoader().parse(text);
  return new ColladaLoader().parse(text, "").scene;
}

// Exporters that put all colour into textures, which are not fetched, leave black behind.
const visibleColor = (color) => (color.r + color.g + color.b < 0.1 ? new THREE.Color(0x9fb0c4) : color);

// Neither it nor what it is part of is hidden.
export function isShown(object) {
  for (let at = object; at; at = at.parent) if (!at.visible) return false;
  return true;
}

function hasGeometry(object) {
  let found = false;
  object.traverse((child) => { found = found || child.isMesh === true; });
  return found;
}

export class Robot {
  // `onChange` is called when a mesh has come.
  constructor(scene, source, ghostColor, onChange) {
    this.joints = scene.joints.map((joint) => joint.name);
    this.ghostColor = ghostColor;
    this.meshes = new Set(scene.meshes);  // that the server has
    this.onChange = onChange;
    this.missing = new Set();  // names of meshes that cannot be had
    const loader = new URDFLoader();
    loader.parseCollision = true;
    loader.packages = (name) => `package://${name}`;
    loader.loadMeshCb = (path, _manager, _material, done) => this.loadMesh(source, path, done);
    this.model = loader.parse(scene.urdf, "");
    // What was simulated or measured is shown, beyond limits, too.
    for (const joint of Object.values(this.model.joints)) joint.ignoreLimits = true;
    this.wire();
  }

  async loadMesh(source, path, done) {
    if (!this.meshes.has(path)) {
      this.missing.add(path);
      return done(null);
    }
    try {
      const answer = await fetch(`mesh?source=${source}&file=${encodeURIComponent(path)}`);
      if (!answer.ok) throw new Error(`no mesh ${path}`);
      done(readMesh(path, await answer.arrayBuffer()));
    } catch (error) {
      this.missing.add(path);
      done(null, error);
    }
    // The loader puts the mesh in its place after this call.
    setTimeout(() => this.wire(), 0);
  }

  // Decides for each link what is shown of it, and gives materials.
  wire() {
    for (const link of Object.values(this.model.links)) {
      const visuals = link.children.filter((child) => child.isURDFVisual);
      const colliders = link.children.filter((child) => child.isURDFCollider);
      const drawn = visuals.some(hasGeometry);
      for (const collider of colliders) collider.visible = !drawn;
    }
    this.model.traverse((child) => {
      if (!child.isMesh || child.userData.wired) return;
      child.userData.wired = true;
      if (!child.geometry.attributes.normal) child.geometry.computeVertexNormals();
      if (this.ghostColor !== null) {
        child.material = new THREE.MeshLambertMaterial({ color: this.ghostColor, transparent: true, opacity: 0.4, depthWrite: false,
          polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
      } else if (!child.material || !child.material.color || this.isInCollider(child)) {
        child.material = new THREE.MeshLambertMaterial({ color: 0x9fb0c4 });
      } else if (Array.isArray(child.material) === false && child.material.type !== "MeshLambertMaterial") {
        // One kind of material for all: URDFs of other people mix what their exporters wrote.
        child.material = new THREE.MeshLambertMaterial({ color: visibleColor(child.material.color) });
      }
    });
    this.addBones();
    this.onChange();
  }

  isInCollider(object) {
    for (let at = object; at; at = at.parent) if (at.isURDFCollider) return true;
    return false;
  }

  // Rods from joint to joint for robots that have neither meshes nor primitives.
  addBones() {
    for (const rod of this.bones ?? []) rod.removeFromParent();
    this.bones = [];
    const size = this.findFrameBox().getSize(new THREE.Vector3()).length();
    for (const joint of Object.values(this.model.joints)) {
      const parent = joint.parent;
      const bare = parent?.isURDFLink && !parent.children.some((child) => (child.isURDFVisual || child.isURDFCollider) && hasGeometry(child));
      const length = joint.position.length();
      if (!bare || length < 1e-3 * size) continue;
      const radius = Math.min(0.018 * size, 0.3 * length);
      const rod = new THREE.Mesh(new THREE.CapsuleGeometry(radius, length, 4, 12).translate(0, length / 2, 0),
        new THREE.MeshLambertMaterial({ color: this.ghostColor ?? 0x9fb0c4, transparent: this.ghostColor !== null, opacity: this.ghostColor === null ? 1 : 0.35 }));
      rod.userData.wired = true;
      rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), joint.position.clone().divideScalar(length));
      parent.add(rod);
      this.bones.push(rod);
    }
  }

  // Around the frames of all links.
  findFrameBox() {
    this.model.updateMatrixWorld(true);
    const box = new THREE.Box3();
    for (const link of Object.values(this.model.links)) box.expandByPoint(link.getWorldPosition(new THREE.Vector3()));
    return box;
  }

  // From a hrp::msg::RobotState.
  show(state) {
    const { rotation: q, translation: p } = state.X_WB;
    if ([q.w, q.x, q.y, q.z, p.x, p.y, p.z].every(Number.isFinite)) {
      this.model.quaternion.set(q.x, q.y, q.z, q.w);
      this.model.position.set(p.x, p.y, p.z);
    }
    state.positions.forEach((value, i) => {
      // Joints that follow others have values of their own in the message, so each is set for itself.
      const joint = this.model.joints[this.joints[i]];
      if (joint && Number.isFinite(toNumber(value))) joint.setJointValue(value);
    });
    this.model.updateMatrixWorld(true);
  }

  find(link) {
    return this.model.links[link] ?? null;
  }

  // Smallest box around what is shown.
  findBox() {
    const box = this.findFrameBox();
    this.model.traverse((child) => {
      if (child.isMesh && isShown(child)) box.expandByObject(child);
    });
    return box;
  }

  dispose() {
    this.model.removeFromParent();
    this.model.traverse((child) => child.geometry?.dispose());
  }
}
