// SPDX-License-Identifier: BSD-3-Clause
// From the messages of contact forces to what is drawn and written: sums per foot, the zero-moment point, the support
// polygon. Pure functions; forces in N, points in m, world axes.

export const parts = ["total", "spring", "damper", "friction"];
const ground = -1;  // body_b of pairs with the ground; obstacles are below
const firstObject = 1000000;  // bodies that move freely begin here

// Numbers that JSON does not have come as words.
export const toNumber = (value) => (typeof value === "number" ? value : NaN);
export const toVector = (v) => [toNumber(v.x), toNumber(v.y), toNumber(v.z)];
const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const norm = (a) => Math.sqrt(dot(a, a));

// Force on each foot, all its pairs together: {link, total, spring, damper, friction, point, touching}. `point` is where
// the arrow starts: the middle of the contact points, weighed by their forces.
export function sumFeet(contactForces, feet) {
  return feet.map((foot) => {
    const sum = { name: foot.name, link: foot.link, point: null, touching: false };
    for (const part of parts) sum[part] = [0, 0, 0];
    let weight = 0;
    let middle = [0, 0, 0];
    for (const pair of contactForces.pairs) {
      if (pair.name_a !== foot.link) continue;
      sum.touching = true;
      for (const part of parts) sum[part] = add(sum[part], toVector(pair[part].force));
      for (const point of pair.points) {
        const share = norm(toVector(point.total));
        weight += share;
        middle = add(middle, toVector(point.p_WC).map((value) => value * share));
      }
    }
    if (weight > 0) sum.point = middle.map((value) => value / weight);
    return sum;
  });
}

// Unit normal and a point of the ground plane: turned by roll, then pitch about world axes.
export function makeGround(ground) {
  const [cr, sr, cp, sp] = [Math.cos(ground.roll), Math.sin(ground.roll), Math.cos(ground.pitch), Math.sin(ground.pitch)];
  // Ry(pitch) Rx(roll) e_z
  return { present: ground.present, normal: [sp * cr, -sr, cp * cr], point: [0, 0, ground.height] };
}

// Whether a pair presses on this robot; "" is the first one. Without a plane, robots stand on obstacles.
const isGround = (pair, plane, robot) =>
  (robot ? pair.name_a.startsWith(`${robot}/`) : pair.body_a < firstObject) && (plane.present ? pair.body_b === ground : pair.body_b < 0);

// A point of the plane; of the level one at the height of the contact points, weighed by their forces, where there is none.
function findPoint(contactForces, plane, robot) {
  if (plane.present) return plane.point;
  let [sum, weight] = [0, 0];
  for (const pair of contactForces.pairs.filter((each) => isGround(each, plane, robot))) {
    for (const point of pair.points) {
      const size = norm(toVector(point.total));
      sum += size * toNumber(point.p_WC.z);
      weight += size;
    }
  }
  return [0, 0, weight > 0 ? sum / weight : 0];
}

// Where the forces of the ground have no moment but about its normal; null when nothing presses.
export function calcZmp(contactForces, plane, robot = "") {
  const origin = findPoint(contactForces, plane, robot);
  let force = [0, 0, 0];
  let moment = [0, 0, 0];  // about it
  for (const pair of contactForces.pairs) {
    if (!isGround(pair, plane, robot)) continue;
    const f = toVector(pair.total.force);
    force = add(force, f);
    moment = add(moment, add(toVector(pair.total.moment), cross(sub(toVector(pair.reference), origin), f)));
  }
  const press = dot(plane.normal, force);
  if (!(press >= 1)) return null;  // [N] less is no contact to speak of
  return add(origin, cross(plane.normal, moment).map((value) => value / press));
}

// Convex hull, seen from above, of the points where the robot touches the ground (Andrew's monotone chain).
export function calcSupportPolygon(contactForces, plane, robot = "") {
  const points = [];
  for (const pair of contactForces.pairs) {
    if (!isGround(pair, plane, robot)) continue;
    for (const point of pair.points) points.push(toVector(point.p_WC));
  }
  points.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const turn = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const walk = (list) => {
    const chain = [];
    for (const p of list) {
      while (chain.length > 1 && turn(chain[chain.length - 2], chain[chain.length - 1], p) <= 0) chain.pop();
      chain.push(p);
    }
    chain.pop();
    return chain;
  };
  return points.length < 3 ? [] : walk(points).concat(walk(points.slice().reverse()));
}
