// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "diagnosis/generator/robot_parts.h"

namespace hrp::cases {
namespace {

enum class ArmKind { serial, planar, scara };

ArmKind draw_kind(Prng& random) {
  const double d = random.uniform(0, 1);
  return d < 0.6 ? ArmKind::serial : d < 0.8 ? ArmKind::planar : ArmKind::scara;
}

// Serial: any of the three axes, sometimes a slanted one. Planar: all horizontal and parallel. SCARA: all upright, but
// for the last, which may bend.
Vec3 draw_axis(ArmKind kind, int i, int count, Prng& random) {
  static const std::vector<Vec3> axes{{0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  if (kind == ArmKind::planar) return axes[1];
  if (kind == ArmKind::scara) return i == count && i > 2 && random.chance(0.5) ? axes[1] : axes[0];
  if (i == 1) return random.chance(0.5) ? axes[0] : axes[1];
  if (random.chance(0.12)) return {0.0, 0.6, random.sign() * 0.8};
  return random.chance(0.6) ? axes[1] : random.pick(axes);
}

// Joint names as people give them; numbers from 1, or words where there are few joints.
std::string make_joint_name(int scheme, int i, int count) {
  static const std::vector<std::string> prefixes{"joint_", "axis", "a", "q", "seg_", "J", "arm_joint_"};
  static const std::vector<std::string> words{"base_yaw", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3", "tool"};
  if (scheme >= static_cast<int>(prefixes.size())) {
    return words[static_cast<std::size_t>(count <= 3 ? i : i - 1)];
  }
  return prefixes[static_cast<std::size_t>(scheme)] + std::to_string(i);
}

// A body whose principal axes are not the link's: turns its box by `angle` [rad] about one of the link's axes.
void turn_inertia(LinkPlan& link, std::size_t axis, double angle) {
  const std::size_t a = (axis + 1) % 3, b = (axis + 2) % 3;
  const double ia = link.inertia[a], ib = link.inertia[b], c = std::cos(angle), s = std::sin(angle);
  link.inertia[a] = c * c * ia + s * s * ib;
  link.inertia[b] = s * s * ia + c * c * ib;
  link.inertia[5 - axis] = c * s * (ia - ib);  // ixy, ixz, iyz stand at 3, 4, 5: opposite their axis
}

// Extends along z (serial, planar) or along x (SCARA, whose axes are upright).
void draw_arm_link(RobotPlan& robot, ArmKind kind, int i, double mass, double length, Prng& random) {
  LinkPlan& link = robot.links.back();
  if (i == 1 && random.chance(0.4)) link.joint.rpy = {random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2), 0};
  if (kind == ArmKind::serial && i > 1 && random.chance(0.3))
    link.joint.rpy[2] = random.pick(std::vector<double>{M_PI / 2, -M_PI / 2, 0.3});
  const double w = random.uniform(0.22, 0.4) * length, h = w * random.uniform(0.8, 1.2);
  const double a = random.uniform(-0.03, 0.03), b = random.uniform(-0.02, 0.02), c = length * random.uniform(0.35, 0.6);
  if (kind == ArmKind::scara)
    set_box(link, mass, {c, b, a}, {length, w, h});
  else
    set_box(link, mass, {a, b, c}, {w, h, length});
  if (random.chance(0.4)) turn_inertia(link, static_cast<std::size_t>(random.below(3)), random.uniform(-0.4, 0.4));
  if (random.chance(0.5)) link.joint.start = round_to(random.uniform(-0.7, 0.7), 4);
}

}  // namespace

RobotPlan make_arm(Prng& random) {
  const ArmKind kind = draw_kind(random);
  const int count = kind == ArmKind::serial ? 3 + random.below(5) : 2 + random.below(3), scheme = random.below(8);
  RobotPlan robot;
  robot.name = (kind == ArmKind::serial   ? "serial"
                : kind == ArmKind::planar ? "planar"
                                          : "scara") +
               std::to_string(count);
  robot.links.push_back({});
  robot.links[0].name = "mount";
  const double scale = random.log_uniform(0.4, 1.6);
  double mass = 9.0 * scale * scale * random.uniform(0.7, 1.3), length = 0.34 * scale;
  for (int i = 1; i <= count; ++i) {
    const double previous = i == 1 ? 0.12 : robot.links.back().box[kind == ArmKind::scara ? 0 : 2];
    const double side = i == 1 ? 0 : random.uniform(-0.05, 0.05);
    Vec3 at{0, side, previous};
    if (kind == ArmKind::scara && i > 1) at = {previous, 0, side};
    robot.links.push_back(make_link("body" + std::to_string(i), i - 1, make_joint_name(scheme, i, count), at,
                                    draw_axis(kind, i, count, random)));
    draw_arm_link(robot, kind, i, mass, length, random);
    mass *= random.uniform(0.5, 0.78);
    length *= random.uniform(0.72, 0.98);
  }
  for (std::size_t i = 1; i < robot.links.size(); ++i) draw_servo(robot, i, random);
  return robot;
}

}  // namespace hrp::cases
